// SPDX-License-Identifier: Apache-2.0
#include "bus/node.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "bus/in_process_bus.hpp"

namespace cairn::bus {
namespace {

/// A node under test and one that talks to it, on a clock that the test sets.
class NodeTest : public ::testing::Test {
 protected:
  void run() {
    hub_.deliver();
    do {
      node_.spin_once(0);
    } while (node_.has_work());
    hub_.deliver();
  }
  template <class Channel>
  void send(Utime utime) {
    typename Channel::type message{};
    peer_.publish<Channel>(message, utime);
  }
  const ChannelCounts& counts(const char* channel) { return node_.counts().find(channel)->second; }

  ManualClock clock_;
  InProcessHub hub_;
  Bus& bus_ = hub_.make_endpoint();
  Bus& peer_bus_ = hub_.make_endpoint();
  Node node_{"tested", bus_, clock_, StateFolder{}, 1};
  Node peer_{"peer", peer_bus_, clock_, StateFolder{}, 2};
};

TEST_F(NodeTest, JoinsByUtimeWhateverTheOrderOfArrival) {
  std::vector<Utime> joined;
  node_.join<channels::Disparity, channels::Pose>(
      [&](const disparity_t& seen, const pose_t& from) {
        EXPECT_EQ(seen.header.utime, from.header.utime);
        joined.push_back(seen.header.utime);
      },
      Backlog::kEvery);
  send<channels::Pose>(2);
  send<channels::Pose>(1);
  send<channels::Disparity>(1);
  send<channels::Disparity>(3);
  run();
  EXPECT_EQ(joined, (std::vector<Utime>{1}));
  send<channels::Disparity>(2);
  send<channels::Pose>(3);
  run();
  EXPECT_EQ(joined, (std::vector<Utime>{1, 2, 3}));
}

TEST_F(NodeTest, APairThatANewerOneOvertookIsNotHandledLate) {
  std::vector<Utime> joined;
  node_.join<channels::Disparity, channels::Pose>(
      [&](const disparity_t& seen, const pose_t&) { joined.push_back(seen.header.utime); });
  for (const Utime utime : {1, 3}) {
    send<channels::Disparity>(utime);
    send<channels::Pose>(utime);
  }
  send<channels::Disparity>(2);
  send<channels::Pose>(2);
  run();
  EXPECT_EQ(joined, (std::vector<Utime>{1, 3}));
}

TEST_F(NodeTest, DataTimeSetBackByOverASecondBeginsAnew) {
  std::vector<Utime> joined;
  node_.join<channels::Disparity, channels::Pose>(
      [&](const disparity_t& seen, const pose_t&) { joined.push_back(seen.header.utime); });
  for (const Utime utime : {9'000'000, 100}) {
    send<channels::Disparity>(utime);
    send<channels::Pose>(utime);
    run();
  }
  EXPECT_EQ(joined, (std::vector<Utime>{9'000'000, 100}));
}

TEST_F(NodeTest, SkipsTheOldestForTheNewestAndCountsThemApartFromLost) {
  std::vector<Utime> handled;
  node_.on<channels::Particles>(
      [&](const particles_t& seen) { handled.push_back(seen.header.utime); });
  for (const Utime utime : {1, 2, 3}) send<channels::Particles>(utime);
  run();
  EXPECT_EQ(handled, (std::vector<Utime>{3}));
  EXPECT_EQ(counts("PARTICLES").skipped, 2);
  EXPECT_EQ(counts("PARTICLES").lost, 0);
  EXPECT_EQ(counts("PARTICLES").received, 3);
}

TEST_F(NodeTest, AGapInTheSequenceIsLostAndANewSessionIsNot) {
  node_.on<channels::Pose>([](const pose_t&) {});
  const auto send_as = [&](std::int64_t session, std::int32_t sequence) {
    pose_t pose{};
    pose.header.session = session;
    pose.header.sequence = sequence;
    ASSERT_TRUE(peer_bus_.publish("POSE", encode(pose).value()));
  };
  send_as(7, 0);
  send_as(7, 1);
  send_as(7, 5);
  send_as(8, 0);
  send_as(8, 1);
  run();
  EXPECT_EQ(counts("POSE").lost, 3);
  EXPECT_EQ(counts("POSE").received, 5);
}

TEST_F(NodeTest, JunkIsCountedWithItsReasonAndTheNextMessageIsHandled) {
  int handled = 0;
  node_.on<channels::Pose>([&](const pose_t&) { ++handled; });
  const std::vector<std::uint8_t> junk(20, 0xee);
  ASSERT_TRUE(peer_bus_.publish("POSE", junk));
  send<channels::Pose>(1);
  run();
  EXPECT_EQ(handled, 1);
  EXPECT_EQ(counts("POSE").refused, 1);
  EXPECT_EQ(counts("POSE").last_refusal, "the bytes are not a whole message of type pose_t");
}

TEST_F(NodeTest, AHandlerThatThrowsCostsItsMessageAndNoMore) {
  int handled = 0;
  node_.on<channels::Pose>([&](const pose_t&) {
    if (++handled == 1) throw std::runtime_error("out of cheese");
  });
  send<channels::Pose>(1);
  send<channels::Pose>(2);
  run();
  EXPECT_EQ(handled, 2);
  EXPECT_EQ(counts("POSE").last_refusal, "while handling it: out of cheese");
}

TEST_F(NodeTest, TimersOfHostTimeDoNotMakeUpForMissedPeriods) {
  int fired = 0;
  node_.every_host(100, [&] { ++fired; });
  clock_.set(99);
  run();
  EXPECT_EQ(fired, 0);
  clock_.set(1050);
  run();
  EXPECT_EQ(fired, 1);
  EXPECT_EQ(node_.next_deadline_us(), 1100);
}

TEST_F(NodeTest, TimersOfDataTimeFollowTheClockChannelAlone) {
  int fired = 0;
  node_.every_data(100'000, [&] { ++fired; });
  clock_.set(10'000'000);
  run();
  EXPECT_EQ(fired, 0);
  for (const Utime utime : {1'000'000, 1'050'000, 1'100'000, 1'150'000})
    send<channels::Clock>(utime);
  run();
  EXPECT_EQ(fired, 1);
  EXPECT_EQ(node_.data_time(), 1'150'000);
}

TEST_F(NodeTest, TheHeartbeatComesFromTheWorkLoopAndSaysWhatIsMissing) {
  std::vector<process_status_t> beats;
  peer_.on<channels::ProcessStatus>([&](const process_status_t& status) {
    if (status.process == "tested") beats.push_back(status);
  });
  node_.on<channels::StereoFrame>([](const stereo_frame_t&) {});
  run();
  clock_.set(999'999);
  run();
  while (peer_.spin_once(0), peer_.has_work()) {
  }
  ASSERT_EQ(beats.size(), 1U) << "one with the first spin, the next after a second";
  EXPECT_EQ(beats[0].health, process_status_t::HEALTH_OK);
  EXPECT_EQ(beats[0].types_hash, types_hash());
  clock_.set(4'000'000);
  run();
  while (peer_.spin_once(0), peer_.has_work()) {
  }
  ASSERT_EQ(beats.size(), 2U);
  EXPECT_EQ(beats[1].health, process_status_t::HEALTH_WAITING);
  EXPECT_EQ(beats[1].reason, "no STEREO_FRAME for 4 s");
}

TEST_F(NodeTest, WhatCannotBeEncodedIsNotSentAndCounted) {
  particles_t particles{};
  particles.count = 3;
  EXPECT_FALSE(node_.publish<channels::Particles>(particles, 1));
  EXPECT_EQ(node_.counter("unsent"), 1);
}

TEST(Channels, EveryNameIsTakenOnceAndShortEnoughForLcm) {
  std::vector<std::string> names;
  for_each_channel([&](auto channel) { names.emplace_back(channel.name); });
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
  for (const std::string& name : names) EXPECT_LE(name.size(), 63U);
}

}  // namespace
}  // namespace cairn::bus
