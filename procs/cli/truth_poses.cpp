// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/truth_poses.hpp"

#include <algorithm>

#include "messages/geometry_messages.hpp"

namespace cairn::cli {

TruthPoses::TruthPoses(evaluation::Trajectory truth, bus::Node& node)
    : truth_{std::move(truth)}, node_{node} {
  node.on<bus::channels::Disparity>([this](const disparity_t& seen) { answer(seen.header.utime); });
}

void TruthPoses::answer(Utime utime) {
  const auto distance = [utime](const evaluation::StampedPose& pose) {
    return std::abs(pose.utime - utime);
  };
  const auto nearest =
      std::min_element(truth_.begin(), truth_.end(),
                       [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  constexpr std::int64_t kLongestGap_us = 10'000;
  if (nearest == truth_.end() || distance(*nearest) > kLongestGap_us) {
    return node_.refuse(bus::channels::Disparity::name, "the truth has no pose at this time");
  }
  pose_t pose{};
  pose.T_map_body = messages::to_message(nearest->T);
  pose.T_map_odom = messages::to_message(Isometry::Identity());
  pose.correction_utime = utime;
  pose.state = pose_t::STATE_TRACKING;
  node_.publish<bus::channels::Pose>(std::move(pose), utime);
}

}  // namespace cairn::cli
