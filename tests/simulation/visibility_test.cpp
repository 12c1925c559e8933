// SPDX-License-Identifier: Apache-2.0
#include "simulation/visibility.hpp"

#include <gtest/gtest.h>

#include <random>

#include "scenes.hpp"

namespace cairn::simulation {
namespace {

/// One ray for each pixel.
cv::Mat_<std::int32_t> ray_by_ray(const RayScene& scene, const Eye& eye,
                                  const Isometry& T_world_eye) {
  std::vector<Eigen::Vector3f> directions;
  for (std::size_t i = 0; i < eye.ray_x.size(); ++i) {
    directions.emplace_back(T_world_eye.linear().cast<float>() * eye.ray(i));
  }
  std::vector<FaceIndex> found(directions.size());
  scene.first_faces(T_world_eye.translation().cast<float>(), directions, found);
  cv::Mat_<std::int32_t> visible(eye.height_px, eye.width_px);
  std::transform(found.begin(), found.end(), visible.begin(),
                 [](FaceIndex face) { return static_cast<std::int32_t>(face); });
  return visible;
}

class VisibilityOf : public testing::TestWithParam<const char*> {};

TEST_P(VisibilityOf, AgreesWithARayForEachPixel) {
  const auto world = load_world(world_file(GetParam()));
  ASSERT_TRUE(world) << world.error().message;
  const auto scene = RayScene::create(world->boxes);
  ASSERT_TRUE(scene) << scene.error().message;
  const auto rig = simulated_rig();
  auto made = make_eye(rig.right, rig.width_px, rig.height_px,
                       rig.T_body_left * rig.T_right_left.inverse());
  ASSERT_TRUE(made) << made.error().message;
  const auto eye = std::make_shared<const Eye>(std::move(*made));
  const Visibility visibility(eye);
  constexpr unsigned kSeed = 23;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> unit(-1, 1);
  int off = 0;
  for (int view = 0; view < 12; ++view) {
    Isometry T = free_pose(*world, 0.25, random);
    T.linear() *= rotation_from_rpy(0.2 * unit(random), 0.2 * unit(random), 0);
    const Isometry T_world_eye = T * eye->T_body_eye;
    std::vector<SeenFace> seen;
    see_faces(scene->faces(), T_world_eye, seen);
    const cv::Mat differ =
        visibility.look(*scene, T_world_eye, seen) != ray_by_ray(*scene, *eye, T_world_eye);
    off += cv::countNonZero(differ);
  }
  // Rays are traced eight at a time, and which eight may decide a tie at a border.
  EXPECT_LE(off, 4) << "pixels of 12 views, seed " << kSeed;
}

INSTANTIATE_TEST_SUITE_P(Worlds, VisibilityOf,
                         testing::Values("room", "apartment", "office", "hand-drawn"),
                         [](const auto& world) {
                           std::string name = world.param;
                           std::erase(name, '-');
                           return name;
                         });

}  // namespace
}  // namespace cairn::simulation
