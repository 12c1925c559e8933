// SPDX-License-Identifier: Apache-2.0
#include "simulation/texture_share.hpp"

#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "simulation/random_hash.hpp"
#include "simulation/reachable_floor.hpp"
#include "simulation/renderer.hpp"

namespace cairn::simulation {
namespace {

/// Ground points where the robot has room, by chance.
std::vector<Eigen::Vector3d> free_places(const ReachableFloor& floor, const TextureConfig& config) {
  std::vector<Eigen::Vector3d> places;
  for (std::uint64_t i = 0; static_cast<int>(places.size()) < config.places; ++i) {
    const std::size_t cell = hash64(config.seed, i) % floor.cells().size();
    const Eigen::Vector3d& middle_m = floor.cells()[cell].middle_m;
    if (floor.has_room_at(middle_m.head<2>())) places.push_back(middle_m);
  }
  return places;
}

/// 255 where the image has too little texture.
cv::Mat_<std::uint8_t> textureless(const cv::Mat_<std::uint8_t>& image,
                                   const TextureConfig& config) {
  const cv::Mat kernel = (cv::Mat_<float>(1, 3) << -0.5F, 0.0F, 0.5F);
  cv::Mat_<float> gradient;
  cv::filter2D(image, gradient, CV_32F, kernel);
  cv::Mat_<float> energy;
  cv::multiply(gradient, gradient, energy);
  cv::boxFilter(energy, energy, CV_32F, {config.block_px, config.block_px});
  cv::Mat_<std::uint8_t> low;
  cv::compare(energy, config.least_gradient_grey2, low, cv::CMP_LT);
  return low;
}

}  // namespace

Result<double> textureless_share(const World& world, const camera::RigCalibration& rig,
                                 const TextureConfig& config) {
  const auto floor = ReachableFloor::flood(world, world.T_world_start.translation().head<2>(), {});
  if (!floor) return tl::make_unexpected(floor.error());
  SensorConfig perfect{0, 0, 1, 0, 0, 450};
  const auto renderer = Renderer::create(world, rig, perfect, config.seed);
  if (!renderer) return tl::make_unexpected(renderer.error());
  double pixels = 0;
  double low_pixels = 0;
  for (const Eigen::Vector3d& place_m : free_places(*floor, config)) {
    for (int direction = 0; direction < config.directions; ++direction) {
      Isometry T = Isometry::Identity();
      T.translation() = place_m;
      T.linear() = rotation_from_rpy(0, 0, 2 * std::numbers::pi * direction / config.directions);
      const RenderedPair pair = renderer->render(T, 0);
      cv::Mat_<std::uint8_t> counts;
      cv::compare(pair.left_depth_m, config.min_depth_m, counts, cv::CMP_GE);
      pixels += cv::countNonZero(counts);
      cv::bitwise_and(textureless(pair.left, config), counts, counts);
      low_pixels += cv::countNonZero(counts);
    }
  }
  if (pixels == 0) return fail("texture: nothing is to be seen");
  return low_pixels / pixels;
}

}  // namespace cairn::simulation
