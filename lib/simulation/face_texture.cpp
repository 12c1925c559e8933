// SPDX-License-Identifier: Apache-2.0
#include "simulation/face_texture.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "simulation/random_hash.hpp"

namespace cairn::simulation {
namespace {

constexpr double kTexel_m = 0.0025;
constexpr int kMaxTexels = 4096;
constexpr double kJointWidth_m = 0.006;
constexpr double kOctaveFade = 0.75;
/// Variance of uniform noise on [-1, 1], bilinearly interpolated: 1/3 * (2/3)^2.
constexpr double kLatticeVariance = 4.0 / 27.0;
constexpr int kMaxTaps = 4;

/// Row `index` of a random lattice, interpolated to `cols` texels.
std::vector<float> lattice_row(std::uint64_t seed, std::int64_t index, double cell_texels, int cols,
                               float amplitude) {
  const std::uint64_t row_seed = hash64(seed, static_cast<std::uint64_t>(index));
  const auto node = [&](std::int64_t i) {
    const double random = unit_random(hash64(row_seed, static_cast<std::uint64_t>(i)));
    return amplitude * static_cast<float>(2 * random - 1);
  };
  std::vector<float> texels(static_cast<std::size_t>(cols));
  std::int64_t have = -1;
  float before = 0;
  float after = 0;
  for (std::size_t col = 0; col < texels.size(); ++col) {
    const double x = static_cast<double>(col) / cell_texels;
    const auto i = static_cast<std::int64_t>(x);
    if (i != have) {
      before = i == have + 1 && have >= 0 ? after : node(i);
      after = node(i + 1);
      have = i;
    }
    texels[col] = before + static_cast<float>(x - static_cast<double>(i)) * (after - before);
  }
  return texels;
}

/// Adds lattice noise of amplitude `amplitude` and cells of `cell_texels` to the image.
void add_octave(cv::Mat_<float>& image, double cell_texels, float amplitude, std::uint64_t seed) {
  std::vector<float> above;
  std::vector<float> below;
  std::int64_t have = -1;
  for (int row = 0; row < image.rows; ++row) {
    const double y = row / cell_texels;
    const auto index = static_cast<std::int64_t>(y);
    if (index != have) {
      above = index == have + 1 && have >= 0
                  ? std::move(below)
                  : lattice_row(seed, index, cell_texels, image.cols, amplitude);
      below = lattice_row(seed, index + 1, cell_texels, image.cols, amplitude);
      have = index;
    }
    const auto fraction = static_cast<float>(y - static_cast<double>(index));
    float* const out = image[row];
    const float* const upper = above.data();
    const float* const lower = below.data();
    for (int col = 0; col < image.cols; ++col) {
      out[col] += upper[col] + fraction * (lower[col] - upper[col]);
    }
  }
}

void add_noise(cv::Mat_<float>& image, const Material& material, double texel_m,
               std::uint64_t seed) {
  std::vector<double> cells_m;
  for (double cell_m = material.coarse_m; cell_m >= material.fine_m; cell_m /= 2) {
    cells_m.push_back(cell_m);
  }
  double variance = 0;
  for (std::size_t i = 0; i < cells_m.size(); ++i) {
    variance += kLatticeVariance * std::pow(kOctaveFade, 2.0 * static_cast<double>(i));
  }
  for (std::size_t i = 0; i < cells_m.size(); ++i) {
    const double amplitude = material.noise_contrast / std::sqrt(variance) *
                             std::pow(kOctaveFade, static_cast<double>(i));
    add_octave(image, std::max(1.0, cells_m[i] / texel_m), static_cast<float>(amplitude),
               hash64(seed, i));
  }
}

/// Triangles and quadrangles of random place, turn and brightness; later ones cover earlier ones.
void add_patches(cv::Mat_<float>& image, const Material& material, double texel_m,
                 std::uint64_t seed) {
  const double area_m2 = static_cast<double>(image.total()) * texel_m * texel_m;
  const auto count = static_cast<std::uint64_t>(std::lround(material.patches_per_m2 * area_m2));
  cv::Mat_<float> patches(image.size(), 0.0F);
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t patch_seed = hash64(seed, i);
    const auto random = [&](std::uint64_t k) { return unit_random(hash64(patch_seed, k)); };
    const double radius = 0.5 * material.patch_m / texel_m * (0.4 + 1.2 * random(0));
    const double x = random(1) * image.cols;
    const double y = random(2) * image.rows;
    const int corners = random(3) < 0.3 ? 3 : 4;
    const double turn = 2 * std::numbers::pi * random(4);
    std::vector<cv::Point> outline;
    for (int corner = 0; corner < corners; ++corner) {
      const double angle = turn + 2 * std::numbers::pi * (corner + 0.4 * random(5)) / corners;
      outline.emplace_back(static_cast<int>(std::lround(x + radius * std::cos(angle))),
                           static_cast<int>(std::lround(y + radius * std::sin(angle))));
    }
    cv::fillConvexPoly(patches, outline, cv::Scalar(material.patch_contrast * (2 * random(6) - 1)));
  }
  image += patches;
}

/// Dark lines at multiples of the spacing along columns or rows.
void add_joints(cv::Mat_<float>& image, const Material& material, double texel_m) {
  const int width = std::max(1, static_cast<int>(std::lround(kJointWidth_m / texel_m)));
  const cv::Scalar darker(-material.joint_contrast);
  const auto draw = [&](double spacing_m, int length, const auto& strip) {
    for (double at = spacing_m / texel_m; spacing_m > 0 && at + width < length;
         at += spacing_m / texel_m) {
      const int begin = static_cast<int>(at);
      cv::Mat_<float> joint = strip(begin, begin + width);
      joint += darker;
    }
  };
  draw(material.joint_m[0], image.cols, [&](int a, int b) { return image.colRange(a, b); });
  draw(material.joint_m[1], image.rows, [&](int a, int b) { return image.rowRange(a, b); });
}

/// Ambient light and a lamp's, by the angle it falls at (Lambert 1760) and slowly less with
/// distance.
double light_at(const World& world, const Face& face, double s_m, double t_m) {
  const Eigen::Vector3d to_lamp = world.lamp_m - face.at(s_m, t_m);
  const double distance_m = to_lamp.norm();
  if (distance_m == 0) return 1;
  const double cosine = std::max(0.0, face.normal.dot(to_lamp) / distance_m);
  return world.ambient + (1 - world.ambient) * cosine * 4 / (2 + distance_m);
}

cv::Mat_<std::uint8_t> lit(const cv::Mat_<float>& relative, const World& world, const Face& face,
                           const Material& material, double texel_m) {
  constexpr int kStep = 16;
  cv::Mat_<std::uint8_t> grey(relative.size());
  for (int row = 0; row < grey.rows; ++row) {
    for (int begin = 0; begin < grey.cols; begin += kStep) {
      const double light =
          light_at(world, face, (begin + 0.5 * kStep) * texel_m, (row + 0.5) * texel_m);
      const auto scale = static_cast<float>(255 * material.brightness * light);
      for (int col = begin; col < std::min(begin + kStep, grey.cols); ++col) {
        grey(row, col) = static_cast<std::uint8_t>(
            std::clamp(scale * (1.0F + relative(row, col)) + 0.5F, 0.0F, 255.0F));
      }
    }
  }
  return grey;
}

/// Half the size, each texel the mean of four; an odd last one is repeated.
cv::Mat_<std::uint8_t> halved(const cv::Mat_<std::uint8_t>& fine) {
  cv::Mat_<std::uint8_t> coarse((fine.rows + 1) / 2, (fine.cols + 1) / 2);
  for (int row = 0; row < coarse.rows; ++row) {
    const std::uint8_t* const upper = fine[2 * row];
    const std::uint8_t* const lower = fine[std::min(2 * row + 1, fine.rows - 1)];
    for (int col = 0; col < coarse.cols; ++col) {
      const int next = std::min(2 * col + 1, fine.cols - 1);
      const int sum = upper[2 * col] + upper[next] + lower[2 * col] + lower[next];
      coarse(row, col) = static_cast<std::uint8_t>((sum + 2) / 4);
    }
  }
  return coarse;
}

constexpr int kFractionBits = 8;
constexpr int kOne = 1 << kFractionBits;
constexpr int kFraction = kOne - 1;

/// 65536 times the grey value between four texels; x, y in 1/256 texel.
int bilinear(const std::uint8_t* texels, std::size_t stride, int x, int y) {
  const std::uint8_t* const upper = texels + static_cast<std::size_t>(y >> kFractionBits) * stride +
                                    static_cast<std::size_t>(x >> kFractionBits);
  const std::uint8_t* const lower = upper + stride;
  const int fx = x & kFraction;
  const int fy = y & kFraction;
  const int above = upper[0] * (kOne - fx) + upper[1] * fx;
  const int below = lower[0] * (kOne - fx) + lower[1] * fx;
  return above * (kOne - fy) + below * fy;
}

FaceTexture::Level level_of(const cv::Mat_<std::uint8_t>& grey, float texels_per_m) {
  FaceTexture::Level level{{}, texels_per_m};
  constexpr int kPad = FaceTexture::kPad;
  cv::copyMakeBorder(grey, level.grey, kPad, kPad, kPad, kPad, cv::BORDER_REPLICATE);
  return level;
}

}  // namespace

void FaceTexture::sample(std::span<const float> s_m, std::span<const float> t_m, const Spot& spot,
                         float* grey) const {
  // As many samples along the spot as it is longer than wide (Schilling, Knittel, Strasser 1996).
  const int taps = std::clamp(static_cast<int>(spot.major_m / spot.minor_m + 0.5F), 1, kMaxTaps);
  const float width_m = std::max(spot.minor_m, spot.major_m / static_cast<float>(kMaxTaps));
  const float texels = std::clamp(1.42F * width_m * levels.front().texels_per_m, 1.0F, 65536.0F);
  const std::size_t index =
      std::min<std::size_t>(std::bit_width(static_cast<unsigned>(texels)), levels.size()) - 1;
  const Level& level = levels[index];
  // Half the pad is for the spot, the other half for what lies beyond the face by rounding.
  constexpr float kReach = FaceTexture::kPad / 2;
  const float first = -0.5F * static_cast<float>(taps - 1);
  const float step = std::min(spot.major_m * level.texels_per_m / static_cast<float>(taps),
                              kReach / std::max(0.5F, -first));
  const auto in_steps = [](float value) { return static_cast<int>(value * kOne); };
  const float max_x = static_cast<float>(level.grey.cols) - kReach - 2;
  const float max_y = static_cast<float>(level.grey.rows) - kReach - 2;
  std::array<int, kMaxRun> x;
  std::array<int, kMaxRun> y;
  std::array<int, kMaxRun> sum{};
  const std::size_t count = std::min(s_m.size(), kMaxRun);
  for (std::size_t i = 0; i < count; ++i) {
    x[i] = in_steps(std::clamp(s_m[i] * level.texels_per_m + (kPad - 0.5F), kReach, max_x) +
                    first * step * spot.along_s);
    y[i] = in_steps(std::clamp(t_m[i] * level.texels_per_m + (kPad - 0.5F), kReach, max_y) +
                    first * step * spot.along_t);
  }
  const int step_x = in_steps(step * spot.along_s);
  const int step_y = in_steps(step * spot.along_t);
  const auto stride = static_cast<std::size_t>(level.grey.cols);
  for (int tap = 0; tap < taps; ++tap) {
    for (std::size_t i = 0; i < count; ++i) {
      sum[i] += bilinear(level.grey[0], stride, x[i] + tap * step_x, y[i] + tap * step_y);
    }
  }
  const float scale = 1.0F / static_cast<float>(kOne * kOne * taps);
  for (std::size_t i = 0; i < count; ++i) grey[i] = scale * static_cast<float>(sum[i]);
}

FaceTexture bake_texture(const World& world, const Face& face, const Material& material,
                         std::uint64_t seed) {
  const double texel_m = std::max(kTexel_m, std::max(face.size_s_m, face.size_t_m) / kMaxTexels);
  const auto texels = [&](double size_m) {
    return std::max(1, static_cast<int>(std::ceil(size_m / texel_m)));
  };
  cv::Mat_<float> relative(texels(face.size_t_m), texels(face.size_s_m), 0.0F);
  add_noise(relative, material, texel_m, hash64(seed, 1));
  add_patches(relative, material, texel_m, hash64(seed, 2));
  add_joints(relative, material, texel_m);
  FaceTexture texture;
  cv::Mat_<std::uint8_t> grey = lit(relative, world, face, material, texel_m);
  auto texels_per_m = static_cast<float>(1 / texel_m);
  texture.levels.push_back(level_of(grey, texels_per_m));
  while (grey.total() > 1) {
    grey = halved(grey);
    texels_per_m *= 0.5F;
    texture.levels.push_back(level_of(grey, texels_per_m));
  }
  return texture;
}

}  // namespace cairn::simulation
