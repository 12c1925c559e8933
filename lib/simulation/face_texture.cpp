// SPDX-License-Identifier: Apache-2.0
#include "simulation/face_texture.hpp"

#include <algorithm>
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
      before = node(i);
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
    for (std::size_t col = 0; col < above.size(); ++col) {
      out[col] += above[col] + fraction * (below[col] - above[col]);
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

float bilinear(const cv::Mat_<std::uint8_t>& image, float x, float y) {
  const auto max_x = static_cast<float>(image.cols - 1);
  const auto max_y = static_cast<float>(image.rows - 1);
  x = std::clamp(x, 0.0F, max_x);
  y = std::clamp(y, 0.0F, max_y);
  const int col = static_cast<int>(x);
  const int row = static_cast<int>(y);
  const float fx = x - static_cast<float>(col);
  const float fy = y - static_cast<float>(row);
  const std::uint8_t* const upper = image[row];
  const std::uint8_t* const lower = image[std::min(row + 1, image.rows - 1)];
  const int next = std::min(col + 1, image.cols - 1);
  const auto grey = [](const std::uint8_t* line, int at) { return static_cast<float>(line[at]); };
  const float above = grey(upper, col) + fx * (grey(upper, next) - grey(upper, col));
  const float below = grey(lower, col) + fx * (grey(lower, next) - grey(lower, col));
  return above + fy * (below - above);
}

}  // namespace

float FaceTexture::sample(float s_m, float t_m, float minor_m, float major_m, float along_s,
                          float along_t) const {
  const int taps = std::clamp(static_cast<int>(major_m / minor_m + 0.5F), 1, kMaxTaps);
  const float width_m = std::max(minor_m, major_m / static_cast<float>(kMaxTaps));
  const float texels = std::clamp(1.42F * width_m * levels.front().texels_per_m, 1.0F, 65536.0F);
  const std::size_t level =
      std::min<std::size_t>(std::bit_width(static_cast<unsigned>(texels)), levels.size()) - 1;
  const auto& [image, per_m] = levels[level];
  const float step_m = major_m / static_cast<float>(taps);
  float sum = 0;
  for (int tap = 0; tap < taps; ++tap) {
    const float offset_m = (static_cast<float>(tap) - 0.5F * static_cast<float>(taps - 1)) * step_m;
    sum += bilinear(image, (s_m + offset_m * along_s) * per_m - 0.5F,
                    (t_m + offset_m * along_t) * per_m - 0.5F);
  }
  return sum / static_cast<float>(taps);
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
  texture.levels.push_back(
      {lit(relative, world, face, material, texel_m), static_cast<float>(1 / texel_m)});
  while (texture.levels.back().grey.total() > 1) {
    const FaceTexture::Level& finer = texture.levels.back();
    texture.levels.push_back({halved(finer.grey), 0.5F * finer.texels_per_m});
  }
  return texture;
}

}  // namespace cairn::simulation
