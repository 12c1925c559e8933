// SPDX-License-Identifier: Apache-2.0
#include "localization/localizer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>

#include "self_mapped_drive.hpp"

namespace cairn::localization {
namespace {

using testing::DriveResult;

void show(const std::string& what, const DriveResult& drive) {
  auto ms = drive.update_ms;
  std::sort(ms.begin(), ms.end());
  std::cout << what << ": frames " << drive.poses.size() << " odometry rms "
            << DriveResult::rms_m(drive.odometry, drive.truth) << " end "
            << DriveResult::end_m(drive.odometry, drive.truth) << ", pose rms "
            << DriveResult::rms_m(drive.poses, drive.truth) << " end "
            << DriveResult::end_m(drive.poses, drive.truth) << " m; ms p50 " << ms[ms.size() / 2]
            << " p99 " << ms[ms.size() * 99 / 100] << " max " << ms.back() << "\n";
  if (std::getenv("CAIRN_SHOW") != nullptr) {
    for (std::size_t i = 0; i < drive.poses.size(); i += 10) {
      const Vector6d e = change_between(drive.truth[i], drive.poses[i]);
      const Vector6d o = change_between(drive.truth[i], drive.odometry[i]);
      std::cout << i << " pose err " << e.transpose() * 1e3 << " | odo " << o.transpose() * 1e3
                << " sigma " << std::sqrt(drive.published[i].covariance(0, 0)) << "\n";
    }
  }
}

TEST(Localizer, Trial) {
  const auto world = testing::world_named("room");
  const auto path = testing::room_tour(2, 0.4);
  show("slip 30 %",
       testing::drive_and_map(world, path, testing::slipping_tracks(0.3), 0.02, 0.3, 1, {}));
  show("stereo 1 %",
       testing::drive_and_map(world, path, testing::stereo_like(0.01, 1), 0.02, 0.3, 1, {}));
  show("stereo 0 %",
       testing::drive_and_map(world, path, testing::stereo_like(0.0, 1), 0.02, 0.3, 1, {}));
}

}  // namespace
}  // namespace cairn::localization
