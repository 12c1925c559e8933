// SPDX-License-Identifier: Apache-2.0
#include "bus/lockstep.hpp"

#include <gtest/gtest.h>

#include <sstream>

namespace cairn::bus {
namespace {

// A source that ticks, two processes that answer each tick, and a listener that writes down all
// that it hears.
std::string transcript(int threads) {
  Lockstep lockstep(threads);
  Node& source = lockstep.add("source", {});
  Node& left = lockstep.add("left", {});
  Node& right = lockstep.add("right", {});
  Node& listener = lockstep.add("listener", {});
  std::ostringstream heard;
  int frame = 0;
  source.every_host(100'000, [&] {
    source.publish<channels::StereoFrame>({}, 100'000 * frame);
    if (++frame == 20) source.request_stop();
  });
  left.on<channels::StereoFrame>([&](const stereo_frame_t& seen) {
    left.publish<channels::Disparity>({}, seen.header.utime);
  });
  right.on<channels::StereoFrame>([&](const stereo_frame_t& seen) {
    right.publish<channels::Odometry>({}, seen.header.utime);
  });
  listener.on_raw([&](const RawMessage& raw) { heard << raw.channel << " "; });
  listener.join<channels::Disparity, channels::Odometry>(
      [&](const disparity_t& seen, const odometry_t&) { heard << seen.header.utime << "\n"; });
  lockstep.run(source);
  EXPECT_EQ(listener.counts().find("DISPARITY")->second.skipped, 0);
  return heard.str();
}

TEST(Lockstep, TheResultDoesNotDependOnTheNumberOfThreads) {
  const std::string once = transcript(1);
  EXPECT_NE(once.find("1900000\n"), std::string::npos)
      << "the last frame is worked off before the end";
  EXPECT_EQ(transcript(1), once);
  EXPECT_EQ(transcript(2), once);
  EXPECT_EQ(transcript(4), once);
}

}  // namespace
}  // namespace cairn::bus
