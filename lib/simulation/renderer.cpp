// SPDX-License-Identifier: Apache-2.0
#include "simulation/renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "simulation/face_texture.hpp"
#include "simulation/pixel_rays.hpp"
#include "simulation/random_hash.hpp"
#include "simulation/ray_scene.hpp"

namespace cairn::simulation {
namespace {

/// One camera of the rig, as the renderer needs it.
struct Eye {
  camera::CameraModel model;
  Isometry T_body_eye = Isometry::Identity();
  std::vector<Eigen::Vector3f> rays;  ///< (x, y, 1) of each pixel, row by row
  float gain = 1;
  float offset_grey = 0;
};

/// A face as one eye at one place sees it: for the ray d = (x, y, 1) in the eye's axes, depth =
/// distance / (normal . d) and the point on the face is (s, t) = start + depth * (axis . d).
struct SeenFace {
  Eigen::Vector3f normal;
  Eigen::Vector3f axis_s;
  Eigen::Vector3f axis_t;
  float distance_m;
  float start_s_m;
  float start_t_m;

  [[nodiscard]] float depth_m(const Eigen::Vector3f& ray) const {
    return distance_m / normal.dot(ray);
  }
};

std::vector<SeenFace> faces_seen_from(const std::vector<Face>& faces, const Isometry& T_world_eye) {
  const Eigen::Matrix3d R_eye_world = T_world_eye.linear().transpose();
  std::vector<SeenFace> seen;
  seen.reserve(faces.size());
  for (const Face& face : faces) {
    const Eigen::Vector3d to_corner = face.corner_m - T_world_eye.translation();
    seen.push_back(
        {(R_eye_world * face.normal).cast<float>(), (R_eye_world * face.axis_s).cast<float>(),
         (R_eye_world * face.axis_t).cast<float>(), static_cast<float>(face.normal.dot(to_corner)),
         static_cast<float>(-face.axis_s.dot(to_corner)),
         static_cast<float>(-face.axis_t.dot(to_corner))});
  }
  return seen;
}

/// Grey value of what a ray meets on a face; `pixel_angle` is the width of a pixel on the plane at
/// depth 1.
float shade(const SeenFace& seen, const FaceTexture& texture, const Eigen::Vector3f& ray,
            float pixel_angle) {
  const float towards = seen.normal.dot(ray);
  const float depth_m = seen.distance_m / towards;
  const float ray_s = seen.axis_s.dot(ray);
  const float ray_t = seen.axis_t.dot(ray);
  const float across = std::sqrt(ray_s * ray_s + ray_t * ray_t);
  const float length = std::sqrt(across * across + towards * towards);
  const float minor_m = depth_m * pixel_angle;
  const float major_m = minor_m * length / std::abs(towards);
  const float along = across > 0 ? 1.0F / across : 0.0F;
  return texture.sample(seen.start_s_m + depth_m * ray_s, seen.start_t_m + depth_m * ray_t, minor_m,
                        major_m, ray_s * along, ray_t * along);
}

/// Sum of the eight bytes of a number.
int byte_sum(std::uint64_t value) {
  constexpr std::uint64_t kEven = 0x00ff00ff00ff00ffULL;
  return static_cast<int>((((value & kEven) + ((value >> 8) & kEven)) * 0x0001000100010001ULL) >>
                          48);
}

/// Adds a sensor's noise to true grey values: the sum of eight uniform bytes is near enough to
/// normal.
class NoiseMaker {
 public:
  explicit NoiseMaker(const SensorConfig& sensor) {
    constexpr double kByteSumDeviation = 209.02;  // sqrt(8 * (256^2 - 1) / 12)
    for (std::size_t grey = 0; grey < scale_.size(); ++grey) {
      const double variance = sensor.read_noise_grey * sensor.read_noise_grey +
                              sensor.shot_noise_grey * static_cast<double>(grey);
      scale_[grey] = static_cast<float>(std::sqrt(variance) / kByteSumDeviation);
    }
  }

  void apply(const cv::Mat_<float>& clean, std::uint64_t seed,
             cv::Mat_<std::uint8_t>& noisy) const {
    constexpr int kByteSumMean = 1020;
    for (int row = 0; row < clean.rows; ++row) {
      const std::uint64_t row_seed = hash64(seed, static_cast<std::uint64_t>(row));
      for (int col = 0; col < clean.cols; ++col) {
        const float grey = std::clamp(clean(row, col), 0.0F, 255.0F);
        const int random =
            byte_sum(hash64(row_seed + static_cast<std::uint64_t>(col))) - kByteSumMean;
        const float value =
            grey + scale_[static_cast<std::size_t>(grey)] * static_cast<float>(random);
        noisy(row, col) = static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
      }
    }
  }

 private:
  std::array<float, 256> scale_{};
};

}  // namespace

struct Renderer::State {
  RayScene scene;
  std::vector<FaceTexture> textures;
  int width_px = 0;
  int height_px = 0;
  Eye left;
  Eye right;
  NoiseMaker noise;
  std::uint64_t seed = 0;

  [[nodiscard]] cv::Mat_<std::int32_t> trace(const Eye& eye, const Isometry& T_world_eye) const;
  [[nodiscard]] cv::Mat_<float> depth_m(const Eye& eye, const cv::Mat_<std::int32_t>& visible,
                                        const std::vector<SeenFace>& seen) const;
  [[nodiscard]] cv::Mat_<float> paint(const Eye& eye, const Isometry& T_world_eye,
                                      const cv::Mat_<std::int32_t>& visible,
                                      const std::vector<SeenFace>& seen) const;
  void smooth_edges(const Eye& eye, const Isometry& T_world_eye,
                    const cv::Mat_<std::int32_t>& visible, const std::vector<SeenFace>& seen,
                    cv::Mat_<float>& grey) const;
  [[nodiscard]] cv::Mat_<float> depth_from(const Eye& eye, const Isometry& T_world_body) const;
};

cv::Mat_<std::int32_t> Renderer::State::trace(const Eye& eye, const Isometry& T_world_eye) const {
  const Eigen::Matrix3f R_world_eye = T_world_eye.linear().cast<float>();
  const Eigen::Vector3f origin_m = T_world_eye.translation().cast<float>();
  std::vector<Eigen::Vector3f> directions(static_cast<std::size_t>(width_px));
  std::vector<FaceIndex> found(directions.size());
  cv::Mat_<std::int32_t> visible(height_px, width_px);
  for (int row = 0; row < height_px; ++row) {
    const auto first = static_cast<std::size_t>(row) * directions.size();
    for (std::size_t i = 0; i < directions.size(); ++i) {
      directions[i] = R_world_eye * eye.rays[first + i];
    }
    scene.first_faces(origin_m, directions, found);
    std::transform(found.begin(), found.end(), visible[row],
                   [](FaceIndex face) { return static_cast<std::int32_t>(face); });
  }
  return visible;
}

cv::Mat_<float> Renderer::State::depth_m(const Eye& eye, const cv::Mat_<std::int32_t>& visible,
                                         const std::vector<SeenFace>& seen) const {
  cv::Mat_<float> depth(visible.size(), 0.0F);
  std::size_t pixel = 0;
  for (int row = 0; row < height_px; ++row) {
    for (int col = 0; col < width_px; ++col, ++pixel) {
      const std::int32_t face = visible(row, col);
      if (face >= 0)
        depth(row, col) = seen[static_cast<std::size_t>(face)].depth_m(eye.rays[pixel]);
    }
  }
  return depth;
}

cv::Mat_<float> Renderer::State::paint(const Eye& eye, const Isometry& T_world_eye,
                                       const cv::Mat_<std::int32_t>& visible,
                                       const std::vector<SeenFace>& seen) const {
  const auto pixel_angle = static_cast<float>(1.0 / eye.model.fx_px);
  cv::Mat_<float> grey(visible.size(), 0.0F);
  std::size_t pixel = 0;
  for (int row = 0; row < height_px; ++row) {
    for (int col = 0; col < width_px; ++col, ++pixel) {
      if (visible(row, col) < 0) continue;
      const auto face = static_cast<std::size_t>(visible(row, col));
      grey(row, col) = shade(seen[face], textures[face], eye.rays[pixel], pixel_angle);
    }
  }
  smooth_edges(eye, T_world_eye, visible, seen, grey);
  grey = eye.gain * grey + eye.offset_grey;
  return grey;
}

void Renderer::State::smooth_edges(const Eye& eye, const Isometry& T_world_eye,
                                   const cv::Mat_<std::int32_t>& visible,
                                   const std::vector<SeenFace>& seen, cv::Mat_<float>& grey) const {
  constexpr std::size_t kRays = 4;
  const auto step_x = static_cast<float>(0.25 / eye.model.fx_px);
  const auto step_y = static_cast<float>(0.25 / eye.model.fy_px);
  const Eigen::Matrix3f R_world_eye = T_world_eye.linear().cast<float>();
  const Eigen::Vector3f origin_m = T_world_eye.translation().cast<float>();
  std::vector<cv::Point> pixels;
  std::vector<Eigen::Vector3f> rays;
  std::vector<Eigen::Vector3f> directions;
  for (int row = 1; row + 1 < height_px; ++row) {
    for (int col = 1; col + 1 < width_px; ++col) {
      const std::int32_t face = visible(row, col);
      if (face == visible(row, col - 1) && face == visible(row, col + 1) &&
          face == visible(row - 1, col) && face == visible(row + 1, col)) {
        continue;
      }
      pixels.emplace_back(col, row);
      const Eigen::Vector3f& centre = eye.rays[static_cast<std::size_t>(row * width_px + col)];
      for (const float y : {-step_y, step_y}) {
        for (const float x : {-step_x, step_x}) {
          rays.push_back(centre + Eigen::Vector3f(x, y, 0));
          directions.push_back(R_world_eye * rays.back());
        }
      }
    }
  }
  std::vector<FaceIndex> found(directions.size());
  scene.first_faces(origin_m, directions, found);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    float sum = 0;
    for (std::size_t k = kRays * i; k < kRays * (i + 1); ++k) {
      if (found[k] == kNothing) continue;
      sum += shade(seen[found[k]], textures[found[k]], rays[k], 2 * step_x);
    }
    grey(pixels[i]) = sum / kRays;
  }
}

cv::Mat_<float> Renderer::State::depth_from(const Eye& eye, const Isometry& T_world_body) const {
  const Isometry T_world_eye = T_world_body * eye.T_body_eye;
  return depth_m(eye, trace(eye, T_world_eye), faces_seen_from(scene.faces(), T_world_eye));
}

Renderer::Renderer(std::unique_ptr<State> state) : state_{std::move(state)} {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Result<Renderer> Renderer::create(const World& world, const camera::RigCalibration& rig,
                                  const SensorConfig& sensor, std::uint64_t seed) {
  if (const auto ok = camera::check(rig); !ok) return tl::make_unexpected(ok.error());
  auto left_rays = pixel_rays(rig.left, rig.width_px, rig.height_px);
  if (!left_rays) return fail("left " + left_rays.error().message);
  auto right_rays = pixel_rays(rig.right, rig.width_px, rig.height_px);
  if (!right_rays) return fail("right " + right_rays.error().message);
  auto scene = RayScene::create(world);
  if (!scene) return tl::make_unexpected(scene.error());
  std::vector<FaceTexture> textures;
  for (std::size_t i = 0; i < scene->faces().size(); ++i) {
    const Box& box = world.boxes[i / kFacesPerBox];
    const Material& material = world.materials[box.material];
    const std::size_t picture = box.pictures * kFacesPerBox + i % kFacesPerBox;
    textures.push_back(bake_texture(world, scene->faces()[i], material,
                                    hash64(static_cast<std::uint64_t>(material.seed), picture)));
  }
  const Eye left{rig.left, rig.T_body_left, std::move(*left_rays), 1.0F, 0.0F};
  const Eye right{rig.right, rig.T_body_left * rig.T_right_left.inverse(), std::move(*right_rays),
                  static_cast<float>(sensor.right_gain),
                  static_cast<float>(sensor.right_offset_grey)};
  return Renderer{
      std::unique_ptr<State>(new State{std::move(*scene), std::move(textures), rig.width_px,
                                       rig.height_px, left, right, NoiseMaker(sensor), seed})};
}

RenderedPair Renderer::render(const Isometry& T_world_body, std::int64_t frame) const {
  RenderedPair pair;
  const std::uint64_t frame_seed = hash64(state_->seed, static_cast<std::uint64_t>(frame));
  const auto take = [&](const Eye& eye, std::uint64_t side, cv::Mat_<std::uint8_t>& image,
                        cv::Mat_<float>* depth) {
    const Isometry T_world_eye = T_world_body * eye.T_body_eye;
    const auto visible = state_->trace(eye, T_world_eye);
    const auto seen = faces_seen_from(state_->scene.faces(), T_world_eye);
    if (depth != nullptr) *depth = state_->depth_m(eye, visible, seen);
    image.create(visible.size());
    state_->noise.apply(state_->paint(eye, T_world_eye, visible, seen), hash64(frame_seed, side),
                        image);
  };
  take(state_->left, 0, pair.left, &pair.left_depth_m);
  take(state_->right, 1, pair.right, nullptr);
  return pair;
}

cv::Mat_<float> Renderer::left_depth_m(const Isometry& T_world_body) const {
  return state_->depth_from(state_->left, T_world_body);
}

cv::Mat_<float> Renderer::right_depth_m(const Isometry& T_world_body) const {
  return state_->depth_from(state_->right, T_world_body);
}

}  // namespace cairn::simulation
