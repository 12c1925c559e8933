// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/result.hpp"
#include "simulation/face.hpp"
#include "simulation/world.hpp"

namespace cairn::simulation {

/// What is first along a ray: an index into RayScene::faces(), or kNothing.
using FaceIndex = std::uint32_t;
inline constexpr FaceIndex kNothing = 0xffffffffU;

/// The faces of boxes, ready for rays (Embree, Wald et al. 2014). Faces of boxes are seen from
/// outside and inside.
class RayScene {
 public:
  /// Fails if Embree does not start.
  [[nodiscard]] static Result<RayScene> create(std::span<const Box> boxes);

  /// Another scene on this one's ray tracer, made quickly: for what moves from frame to frame.
  [[nodiscard]] Result<RayScene> beside(std::span<const Box> boxes) const;

  ~RayScene();
  RayScene(RayScene&&) noexcept;
  RayScene& operator=(RayScene&&) noexcept;

  /// Face f belongs to box f / kFacesPerBox.
  [[nodiscard]] const std::vector<Face>& faces() const;

  /// Edge e belongs to box e / kEdgesPerBox.
  [[nodiscard]] const std::vector<Edge>& edges() const;

  /// The first face along each of the rays from one point; as many results as directions.
  /// Directions need no unit length.
  void first_faces(const Eigen::Vector3f& origin_m, std::span<const Eigen::Vector3f> directions,
                   std::span<FaceIndex> result) const;

  /// True if nothing stands between the two points, the last 1 mm before `to_m` left out.
  [[nodiscard]] bool sees(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) const;

 private:
  struct State;
  explicit RayScene(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn::simulation
