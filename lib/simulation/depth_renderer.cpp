// SPDX-License-Identifier: Apache-2.0
#include "simulation/depth_renderer.hpp"

#include <optional>
#include <utility>
#include <vector>

#include "simulation/eye.hpp"
#include "simulation/person_look.hpp"
#include "simulation/ray_scene.hpp"
#include "simulation/sight.hpp"

namespace cairn::simulation {

struct DepthRenderer::State {
  RayScene scene;
  Eye left;
  Eye right;
  std::vector<Person> people;

  [[nodiscard]] cv::Mat_<float> depth_m(const Eye& eye, const Isometry& T_world_body, int step,
                                        std::span<const PersonPose> poses) const {
    const std::vector<Box> boxes = people_boxes(people, poses);
    std::optional<RayScene> moving;
    if (!boxes.empty()) {
      if (auto made = scene.beside(boxes)) moving = std::move(*made);
    }
    return Sight(scene, moving ? &*moving : nullptr, eye, T_world_body).depth_m(step);
  }
};

DepthRenderer::DepthRenderer(std::unique_ptr<State> state) : state_{std::move(state)} {}
DepthRenderer::~DepthRenderer() = default;
DepthRenderer::DepthRenderer(DepthRenderer&&) noexcept = default;
DepthRenderer& DepthRenderer::operator=(DepthRenderer&&) noexcept = default;

Result<DepthRenderer> DepthRenderer::create(const World& world, const camera::RigCalibration& rig) {
  if (const auto ok = camera::check(rig); !ok) return tl::make_unexpected(ok.error());
  auto left = make_eye(rig.left, rig.width_px, rig.height_px, rig.T_body_left);
  if (!left) return fail("left " + left.error().message);
  auto right = make_eye(rig.right, rig.width_px, rig.height_px,
                        rig.T_body_left * rig.T_right_left.inverse());
  if (!right) return fail("right " + right.error().message);
  auto scene = RayScene::create(world.boxes);
  if (!scene) return tl::make_unexpected(scene.error());
  return DepthRenderer{std::unique_ptr<State>(
      new State{std::move(*scene), std::move(*left), std::move(*right), world.people})};
}

cv::Mat_<float> DepthRenderer::left_m(const Isometry& T_world_body, int step,
                                      std::span<const PersonPose> people) const {
  return state_->depth_m(state_->left, T_world_body, step, people);
}

cv::Mat_<float> DepthRenderer::right_m(const Isometry& T_world_body, int step,
                                       std::span<const PersonPose> people) const {
  return state_->depth_m(state_->right, T_world_body, step, people);
}

}  // namespace cairn::simulation
