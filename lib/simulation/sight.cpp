// SPDX-License-Identifier: Apache-2.0
#include "simulation/sight.hpp"

#include <algorithm>
#include <cmath>

namespace cairn::simulation {
namespace {

/// What a pixel of this width sees on a face around where the ray (x, y, 1) meets it.
FaceTexture::Spot spot_at(const SeenFace& face, float x, float y, float pixel_angle) {
  const Eigen::Vector3f ray(x, y, 1);
  const float depth_m = 1 / face.inverse_depth_at(x, y);
  const float towards = face.normal.dot(ray);
  const float ray_s = face.axis_s.dot(ray);
  const float ray_t = face.axis_t.dot(ray);
  const float across = std::sqrt(ray_s * ray_s + ray_t * ray_t);
  const float length = std::sqrt(across * across + towards * towards);
  const float minor_m = depth_m * pixel_angle;
  const float along = across > 0 ? 1.0F / across : 0.0F;
  return {minor_m, minor_m * length / std::abs(towards), ray_s * along, ray_t * along};
}

/// Grey values along rays (x, y, 1), at most FaceTexture::kMaxRun, that all meet one face.
void shade(const SeenFace& face, const FaceTexture& picture, std::span<const float> x,
           std::span<const float> y, float pixel_angle, float* grey) {
  std::array<float, FaceTexture::kMaxRun> s_m;
  std::array<float, FaceTexture::kMaxRun> t_m;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const float depth_m = 1 / face.inverse_depth_at(x[i], y[i]);
    s_m[i] = face.start_s_m +
             depth_m * (face.axis_s.x() * x[i] + face.axis_s.y() * y[i] + face.axis_s.z());
    t_m[i] = face.start_t_m +
             depth_m * (face.axis_t.x() * x[i] + face.axis_t.y() * y[i] + face.axis_t.z());
  }
  const std::size_t middle = x.size() / 2;
  picture.sample({s_m.data(), x.size()}, {t_m.data(), x.size()},
                 spot_at(face, x[middle], y[middle], pixel_angle), grey);
}

}  // namespace

Sight::Sight(const RayScene& still, const RayScene* moving, const Eye& eye,
             const Isometry& T_world_body)
    : still_{still}, moving_{moving}, eye_{eye}, T_world_eye_{T_world_body * eye.T_body_eye} {
  see_faces(still.faces(), T_world_eye_, seen_);
  if (moving != nullptr) see_faces(moving->faces(), T_world_eye_, seen_);
}

void Sight::trace(std::span<const Eigen::Vector3f> rays, std::span<FaceIndex> found) const {
  const Eigen::Matrix3f R_world_eye = T_world_eye_.linear().cast<float>();
  std::vector<Eigen::Vector3f> directions;
  directions.reserve(rays.size());
  for (const Eigen::Vector3f& ray : rays) directions.emplace_back(R_world_eye * ray);
  still_.first_faces(T_world_eye_.translation().cast<float>(), directions, found);
  if (moving_ != nullptr) put_moving_before(rays, directions, found);
}

FaceIndex Sight::nearer(FaceIndex still, FaceIndex moving, float x, float y) const {
  const auto inverse_depth = [&](FaceIndex face) {
    return face == kNothing ? 0 : seen_[face].inverse_depth_at(x, y);
  };
  if (moving == kNothing) return still;
  const auto face = static_cast<FaceIndex>(still_.faces().size()) + moving;
  return inverse_depth(face) > inverse_depth(still) ? face : still;
}

void Sight::put_moving_before(std::span<const Eigen::Vector3f> rays,
                              std::span<const Eigen::Vector3f> directions,
                              std::span<FaceIndex> found) const {
  std::vector<FaceIndex> moving(directions.size());
  moving_->first_faces(T_world_eye_.translation().cast<float>(), directions, moving);
  for (std::size_t i = 0; i < moving.size(); ++i) {
    found[i] = nearer(found[i], moving[i], rays[i].x(), rays[i].y());
  }
}

cv::Mat_<std::int32_t> Sight::visible_faces(const Visibility& visibility) const {
  auto visible = visibility.look(still_, T_world_eye_, seen_);
  if (moving_ != nullptr) show_moving(visibility, visible);
  return visible;
}

void Sight::show_moving(const Visibility& visibility, cv::Mat_<std::int32_t>& visible) const {
  const auto moving =
      visibility.look(*moving_, T_world_eye_, std::span(seen_).subspan(still_.faces().size()));
  std::size_t pixel = 0;
  for (int row = 0; row < visible.rows; ++row) {
    for (int col = 0; col < visible.cols; ++col, ++pixel) {
      if (moving(row, col) < 0) continue;
      visible(row, col) = static_cast<std::int32_t>(
          nearer(static_cast<FaceIndex>(visible(row, col)),
                 static_cast<FaceIndex>(moving(row, col)), eye_.ray_x[pixel], eye_.ray_y[pixel]));
    }
  }
}

cv::Mat_<float> Sight::depth_m(int step) const {
  cv::Mat_<float> depth((eye_.height_px + step - 1) / step, (eye_.width_px + step - 1) / step);
  std::vector<Eigen::Vector3f> rays(static_cast<std::size_t>(depth.cols));
  std::vector<FaceIndex> found(rays.size());
  for (int row = 0; row < depth.rows; ++row) {
    for (int col = 0; col < depth.cols; ++col) {
      rays[static_cast<std::size_t>(col)] = eye_.ray(eye_.pixel(col * step, row * step));
    }
    trace(rays, found);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      depth(row, static_cast<int>(i)) =
          found[i] == kNothing ? 0 : 1 / seen_[found[i]].inverse_depth_at(rays[i].x(), rays[i].y());
    }
  }
  return depth;
}

cv::Mat_<float> Sight::depth_m(const cv::Mat_<std::int32_t>& visible) const {
  cv::Mat_<float> depth(visible.size());
  std::size_t pixel = 0;
  for (int row = 0; row < visible.rows; ++row) {
    const std::int32_t* const faces = visible[row];
    float* const out = depth[row];
    for (int col = 0; col < visible.cols; ++col, ++pixel) {
      out[col] = faces[col] < 0 ? 0
                                : 1 / seen_[static_cast<std::size_t>(faces[col])].inverse_depth_at(
                                          eye_.ray_x[pixel], eye_.ray_y[pixel]);
    }
  }
  return depth;
}

cv::Mat_<float> Sight::light(const cv::Mat_<std::int32_t>& visible,
                             std::span<const FaceTexture* const> pictures) const {
  cv::Mat_<float> grey(visible.size());
  constexpr int kMaxRun = static_cast<int>(FaceTexture::kMaxRun);
  for (int row = 0; row < visible.rows; ++row) {
    const std::int32_t* const faces = visible[row];
    for (int begin = 0; begin < visible.cols;) {
      int end = begin + 1;
      while (end < visible.cols && end < begin + kMaxRun && faces[end] == faces[begin]) ++end;
      paint_run(eye_.pixel(begin, row), static_cast<std::size_t>(end - begin), faces[begin],
                pictures, grey[row] + begin);
      begin = end;
    }
  }
  smooth_borders(visible, pictures, grey);
  return grey;
}

void Sight::paint_run(std::size_t pixel, std::size_t count, std::int32_t face,
                      std::span<const FaceTexture* const> pictures, float* grey) const {
  if (face < 0) {
    std::fill_n(grey, count, 0.0F);
    return;
  }
  const auto index = static_cast<std::size_t>(face);
  shade(seen_[index], *pictures[index], std::span(eye_.ray_x).subspan(pixel, count),
        std::span(eye_.ray_y).subspan(pixel, count), eye_.pixel_angle_x, grey);
}

void Sight::smooth_borders(const cv::Mat_<std::int32_t>& visible,
                           std::span<const FaceTexture* const> pictures,
                           cv::Mat_<float>& grey) const {
  constexpr std::size_t kRays = 4;
  const float step_x = 0.25F * eye_.pixel_angle_x;
  const float step_y = 0.25F * eye_.pixel_angle_y;
  std::vector<cv::Point> pixels;
  std::vector<Eigen::Vector3f> rays;
  for (int row = 1; row + 1 < visible.rows; ++row) {
    const std::int32_t* const above = visible[row - 1];
    const std::int32_t* const here = visible[row];
    const std::int32_t* const below = visible[row + 1];
    for (int col = 1; col + 1 < visible.cols; ++col) {
      const std::int32_t face = here[col];
      if (face == here[col - 1] && face == here[col + 1] && face == above[col] &&
          face == below[col]) {
        continue;
      }
      pixels.emplace_back(col, row);
      const Eigen::Vector3f centre = eye_.ray(eye_.pixel(col, row));
      for (const float y : {-step_y, step_y}) {
        for (const float x : {-step_x, step_x}) {
          rays.emplace_back(centre + Eigen::Vector3f(x, y, 0));
        }
      }
    }
  }
  std::vector<FaceIndex> found(rays.size());
  trace(rays, found);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    float sum = 0;
    for (std::size_t k = kRays * i; k < kRays * (i + 1); ++k) {
      if (found[k] == kNothing) continue;
      float sample = 0;
      shade(seen_[found[k]], *pictures[found[k]], {&rays[k].x(), 1}, {&rays[k].y(), 1}, 2 * step_x,
            &sample);
      sum += sample;
    }
    grey(pixels[i]) = sum / kRays;
  }
}

}  // namespace cairn::simulation
