// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "core/geometry.hpp"
#include "simulation/eye.hpp"
#include "simulation/face_texture.hpp"
#include "simulation/ray_scene.hpp"
#include "simulation/seen_face.hpp"
#include "simulation/visibility.hpp"

namespace cairn::simulation {

/// What one eye sees from one place: the faces of what stands still, and after them those of what
/// moves.
class Sight {
 public:
  /// `moving` may be null. All that is given must outlive this.
  Sight(const RayScene& still, const RayScene* moving, const Eye& eye,
        const Isometry& T_world_body);

  /// Face of each pixel, -1 where nothing is.
  [[nodiscard]] cv::Mat_<std::int32_t> visible_faces(const Visibility& visibility) const;

  /// Depth of the centre of every `step`-th pixel of every `step`-th row, from the first ones on; 0
  /// where nothing is.
  [[nodiscard]] cv::Mat_<float> depth_m(int step) const;
  [[nodiscard]] cv::Mat_<float> depth_m(const cv::Mat_<std::int32_t>& visible) const;

  /// Light that each pixel gets, as grey values; `pictures` are the faces'. On the borders of faces
  /// the mean over four rays.
  [[nodiscard]] cv::Mat_<float> light(const cv::Mat_<std::int32_t>& visible,
                                      std::span<const FaceTexture* const> pictures) const;

 private:
  void trace(std::span<const Eigen::Vector3f> rays, std::span<FaceIndex> found) const;
  void put_moving_before(std::span<const Eigen::Vector3f> rays,
                         std::span<const Eigen::Vector3f> directions,
                         std::span<FaceIndex> found) const;
  [[nodiscard]] FaceIndex nearer(FaceIndex still, FaceIndex moving, float x, float y) const;
  void show_moving(const Visibility& visibility, cv::Mat_<std::int32_t>& visible) const;
  void paint_run(std::size_t pixel, std::size_t count, std::int32_t face,
                 std::span<const FaceTexture* const> pictures, float* grey) const;
  void smooth_borders(const cv::Mat_<std::int32_t>& visible,
                      std::span<const FaceTexture* const> pictures, cv::Mat_<float>& grey) const;

  const RayScene& still_;
  const RayScene* moving_;
  const Eye& eye_;
  Isometry T_world_eye_;
  std::vector<SeenFace> seen_;
};

}  // namespace cairn::simulation
