// SPDX-License-Identifier: Apache-2.0
// H-PROC-1: any process is killed without warning and started again by a script; the run goes on.
#include <gtest/gtest.h>

#include <iostream>

#include "camera/frame_source.hpp"
#include "mapping/map_file.hpp"
#include "network_namespace.hpp"
#include "system/end_error.hpp"
#include "system/live_group.hpp"
#include "system/recordings_of_tests.hpp"

namespace cairn::testing {
namespace {

TEST(Restart, EachProcessIsKilledOnceAndTheRunEndsNearTheTruth) {
  if (!enter_network_namespace() || !add_multicast_route()) GTEST_SKIP() << kNoNamespace;
  const std::filesystem::path dataset = real_street().value_or(rendered_room());
  LiveGroup group(dataset);
  for (const std::string& process : kWithoutCamera) group.start(process);
  ASSERT_TRUE(group.listen_until_heard(kWithoutCamera));
  group.start("camera");
  std::int64_t frames = 8;
  for (const char* process : {"stereo", "camera", "odometry", "localizer", "mapper"}) {
    ASSERT_TRUE(group.listen_until([&] { return group.heard().frames() >= frames; }))
        << "before " << process;
    group.kill(process);
    group.start(process);
    frames += 10;
  }
  ASSERT_EQ(group.wait("camera"), 0) << group.output("camera");
  group.listen_until_quiet();
  group.stop();
  const auto dataset_size = camera::open_dataset(dataset.string()).value().frames->size().value();
  EXPECT_EQ(group.heard().trajectory().back().utime,
            camera::open_dataset(dataset.string()).value().info.utimes.back());
  EXPECT_GE(group.heard().frames(), dataset_size - 1)
      << "the camera goes on after the last frame that it published";
  for (const char* process : {"stereo", "camera", "odometry", "localizer", "mapper"}) {
    EXPECT_EQ(group.heard().restarts()[process], 1U) << process;
  }
  const double error = end_error_fraction(group.heard().trajectory(), dataset);
  std::cout << "off by " << 100 * error << " % of the way; " << group.heard().trajectory().size()
            << " poses of " << dataset_size << " frames\n";
  EXPECT_LE(error, 0.06);
  const auto map = mapping::load_map(group.map(), {});
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_GT(map->map.occupied_voxels(), 1000U);
  EXPECT_NE(group.output("mapper").find("goes on with the map"), std::string::npos)
      << group.output("mapper");
}

}  // namespace
}  // namespace cairn::testing
