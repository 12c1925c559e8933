// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/traffic.hpp"

#include <gtest/gtest.h>

#include <random>

#include "procs/spy/summary_json.hpp"
#include "procs/spy/summary_text.hpp"
#include "spy/messages.hpp"

namespace cairn::spy {
namespace {

namespace channels = bus::channels;
constexpr std::int64_t kMs = 1000;
constexpr std::int64_t kSecond = 1'000'000;

class TrafficTest : public ::testing::Test {
 protected:
  ChannelSummary channel(const std::string& name, std::int64_t now_us) const {
    for (const ChannelSummary& channel : traffic_.summary(now_us).channels) {
      if (channel.channel == name) return channel;
    }
    ADD_FAILURE() << "no channel " << name;
    return {};
  }

  Traffic traffic_{schema(), PaceWindow::kNewest, Timing::kLive};
};

TEST_F(TrafficTest, NothingHeardIsNothingSaid) {
  const TrafficSummary summary = traffic_.summary(5 * kSecond);
  EXPECT_EQ(summary.messages, 0);
  EXPECT_EQ(summary.span_us, 0);
  EXPECT_TRUE(summary.channels.empty());
  EXPECT_TRUE(summary.processes.empty());
}

TEST_F(TrafficTest, AChannelsTypeCountRateAndBandwidth) {
  const auto one = message<channels::Pose>(1, 0);
  for (int i = 0; i < 31; ++i) traffic_.add(message<channels::Pose>(1, i), i * 100 * kMs);
  const ChannelSummary pose = channel("POSE", 3 * kSecond);
  EXPECT_EQ(pose.type, "pose_t");
  EXPECT_TRUE(pose.in_catalogue);
  EXPECT_EQ(pose.count, 31);
  EXPECT_EQ(pose.bytes, static_cast<std::int64_t>(31 * one.bytes.size()));
  EXPECT_DOUBLE_EQ(pose.pace->rate_hz, 10);
  EXPECT_DOUBLE_EQ(pose.pace->bytes_per_s, 10.0 * static_cast<double>(one.bytes.size()));
  EXPECT_EQ(pose.lost, 0);
  EXPECT_EQ(traffic_.summary(3 * kSecond).span_us, 3 * kSecond);
}

TEST_F(TrafficTest, GapsInASendersSequenceAreLosses) {
  for (const int sequence : {5, 6, 9, 10, 20})
    traffic_.add(message<channels::Pose>(1, sequence), 0);
  const ChannelSummary pose = channel("POSE", 0);
  EXPECT_EQ(pose.lost, 2 + 9);
  EXPECT_EQ(pose.senders.at(0).lost, 11);
  EXPECT_EQ(traffic_.summary(0).lost, 11);
}

TEST_F(TrafficTest, EachSenderHasItsOwnSequence) {
  for (int i = 0; i < 4; ++i) {
    traffic_.add(message<channels::LogLine>(1, 100 + i), 0);
    traffic_.add(message<channels::LogLine>(2, 3 * i), 0);
  }
  EXPECT_EQ(channel("LOG_LINE", 0).lost, 3 * 2);
  EXPECT_EQ(channel("LOG_LINE", 0).senders.size(), 2u);
}

TEST_F(TrafficTest, ASequenceThatGoesBackIsNoLoss) {
  for (const int sequence : {0, 1, 2, 0, 1}) traffic_.add(message<channels::Pose>(1, sequence), 0);
  EXPECT_EQ(channel("POSE", 0).lost, 0);
  EXPECT_EQ(channel("POSE", 0).out_of_order, 1);
}

TEST_F(TrafficTest, ARestartedSenderIsSeenAndCostsNothing) {
  traffic_.add(message<channels::Pose>(1, 500), 0);
  traffic_.add(message<channels::Pose>(1, 501), 100 * kMs);
  traffic_.add(message<channels::Pose>(2, 0), 900 * kMs);
  traffic_.add(message<channels::Pose>(2, 1), 1000 * kMs);
  const ChannelSummary pose = channel("POSE", 1100 * kMs);
  EXPECT_EQ(pose.restarts, 1);
  EXPECT_EQ(pose.lost, 0);
  ASSERT_EQ(pose.senders.size(), 2u);
  EXPECT_EQ(pose.senders[0].session, 2);
  EXPECT_EQ(pose.senders[0].age_us, 100 * kMs);
}

TEST_F(TrafficTest, SendersAreNamedByTheirProcessStatus) {
  traffic_.add(message<channels::Pose>(7, 0), 0);
  EXPECT_EQ(channel("POSE", 0).senders.at(0).process, "");
  traffic_.add({channels::ProcessStatus::name, bytes_of(process_status("localizer", 7))}, 0);
  EXPECT_EQ(channel("POSE", 0).senders.at(0).process, "localizer");
  EXPECT_EQ(traffic_.summary(0).processes.at(0).process, "localizer");
}

TEST_F(TrafficTest, LatencyIsFromSendingToArrivalAndOnlyWhereItCanBe) {
  for (int i = 0; i < 100; ++i)
    traffic_.add(message<channels::Pose>(1, i, kSecond - i * kMs), kSecond);
  EXPECT_NEAR(static_cast<double>(channel("POSE", kSecond).latency->p50_us), 50e3, 1e3);
  EXPECT_NEAR(static_cast<double>(channel("POSE", kSecond).latency->p99_us), 98e3, 1e3);
  // Sent in the future, or long ago: not live traffic of this machine.
  traffic_.add(message<channels::Clock>(1, 0, 2 * kSecond), kSecond);
  traffic_.add(message<channels::Clock>(1, 1, -100 * kSecond), kSecond);
  EXPECT_FALSE(channel("CLOCK", kSecond).latency);

  Traffic recorded(schema(), PaceWindow::kWhole, Timing::kRecorded);
  recorded.add(message<channels::Pose>(1, 0, kSecond), kSecond);
  EXPECT_FALSE(recorded.summary(kSecond).channels.at(0).latency);
}

TEST_F(TrafficTest, StaleAfterFivePeriodsWhereSilenceMeansSomething) {
  for (int i = 0; i <= 10; ++i) {
    traffic_.add(message<channels::Pose>(1, i), i * 200 * kMs);
    traffic_.add(message<channels::LogLine>(1, i), i * 200 * kMs);
    traffic_.add({"UNKNOWN", {1}}, i * 200 * kMs);
  }
  EXPECT_FALSE(channel("POSE", 3000 * kMs).stale);
  EXPECT_TRUE(channel("POSE", 3001 * kMs).stale);
  EXPECT_EQ(channel("POSE", 3001 * kMs).age_us, 1001 * kMs);
  EXPECT_FALSE(channel("LOG_LINE", 60 * kSecond).stale);
  EXPECT_FALSE(channel("UNKNOWN", 60 * kSecond).stale);
}

TEST_F(TrafficTest, WhatCannotBeDecodedIsCountedWithTheReason) {
  auto cut = message<channels::Pose>(1, 0);
  cut.bytes.pop_back();
  traffic_.add(cut, 0);
  EXPECT_EQ(channel("POSE", 0).undecodable, 1);
  EXPECT_EQ(channel("POSE", 0).last_problem, "pose_t.covariance: the message ends before it");

  traffic_.add({"POSE", message<channels::Clock>(1, 0).bytes}, 0);
  EXPECT_EQ(channel("POSE", 0).last_problem, "a clock_t on a channel of pose_t");

  traffic_.add({"POSE", {1, 2, 3, 4, 5, 6, 7, 8, 9}}, 0);
  EXPECT_EQ(channel("POSE", 0).last_problem, "another version of pose_t, or none at all");

  traffic_.add({"POSE", {}}, 0);
  EXPECT_EQ(channel("POSE", 0).last_problem, "too short for a message");

  traffic_.add(message<channels::Pose>(1, -1), 0);
  EXPECT_EQ(channel("POSE", 0).last_problem, "header.sequence is negative");
  EXPECT_EQ(channel("POSE", 0).undecodable, 5);
  EXPECT_TRUE(channel("POSE", 0).senders.empty());
  EXPECT_TRUE(traffic_.newest().empty());
}

TEST_F(TrafficTest, UnknownChannelsAreShownByTheirFingerprint) {
  traffic_.add({"MY_POSE", message<channels::Pose>(1, 0).bytes}, 0);
  traffic_.add({"THEIRS", {0, 0, 0, 0, 0, 0, 0x12, 0x34, 9}}, 0);
  EXPECT_EQ(channel("MY_POSE", 0).type, "pose_t");
  EXPECT_FALSE(channel("MY_POSE", 0).in_catalogue);
  EXPECT_EQ(channel("MY_POSE", 0).undecodable, 0);
  EXPECT_EQ(channel("THEIRS", 0).type, "unknown 0x0000000000001234");
  EXPECT_EQ(channel("THEIRS", 0).undecodable, 1);
}

// Recorders stamp on arrival: neighbours may be swapped by some milliseconds.
TEST_F(TrafficTest, ARecordingWhoseTimeIsSetBackIsSeen) {
  int sequence = 0;
  for (const std::int64_t time_us : {5 * kSecond, 5 * kSecond - 10 * kMs, 3 * kSecond, 4 * kSecond})
    traffic_.add(message<channels::Clock>(1, sequence++), time_us);
  EXPECT_EQ(traffic_.summary(5 * kSecond).time_set_back, 1);
}

TEST_F(TrafficTest, LcmsSelfTestIsNotTraffic) {
  traffic_.add({"LCM_SELF_TEST", {1, 2, 3}}, 0);
  EXPECT_EQ(traffic_.summary(0).messages, 0);
}

TEST_F(TrafficTest, TheNewestWholeMessageIsKept) {
  traffic_.add(message<channels::Pose>(1, 0), 0);
  const auto newest = message<channels::Pose>(1, 1);
  traffic_.add(newest, 0);
  traffic_.add({"POSE", {1}}, 0);
  EXPECT_EQ(*traffic_.newest().at("POSE").bytes, newest.bytes);
  EXPECT_EQ(traffic_.newest().at("POSE").type->name, "pose_t");
}

TEST_F(TrafficTest, NamesAndSessionsWithoutEndCostNoMemoryWithoutEnd) {
  for (int i = 0; i < 3000; ++i) {
    traffic_.add({"CHANNEL_" + std::to_string(i), {1}}, i);
    traffic_.add(message<channels::Pose>(i, 0), i);
  }
  const TrafficSummary summary = traffic_.summary(3000);
  EXPECT_EQ(summary.channels.size(), 1000u);
  EXPECT_EQ(summary.ignored, 3000 - 999);
  EXPECT_EQ(channel("POSE", 3000).senders.size(), 256u);
  EXPECT_EQ(channel("POSE", 3000).restarts, 2999);
}

TEST(Traffic, SurvivesGarbage) {
  constexpr unsigned kSeed = 21;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  process_status_t status = process_status("mapper", 3);
  status.channels.resize(3);
  status.channel_count = 3;
  const std::vector<bus::RawMessage> whole{{"PROCESS_STATUS", bytes_of(status)},
                                           message<bus::channels::Pose>(1, 5),
                                           message<bus::channels::StereoFrame>(2, 6),
                                           message<bus::channels::GroupState>(4, 7)};
  Traffic traffic(schema(), PaceWindow::kNewest, Timing::kLive);
  for (int trial = 0; trial < 4000; ++trial) {
    bus::RawMessage damaged = whole[random() % whole.size()];
    for (std::uint64_t faults = 1 + random() % 4; faults > 0; --faults)
      damaged.bytes[random() % damaged.bytes.size()] = static_cast<std::uint8_t>(random());
    if (random() % 8 == 0) damaged.bytes.resize(random() % damaged.bytes.size());
    if (random() % 8 == 0) damaged.channel[random() % 4] = static_cast<char>(random());
    traffic.add(std::move(damaged), static_cast<std::int64_t>(random()));
    if (trial % 100 != 0) continue;
    const TrafficSummary summary = traffic.summary(static_cast<std::int64_t>(random()));
    EXPECT_FALSE(to_json(summary).dump().empty());
    EXPECT_FALSE(channel_table(summary).lines(100).empty());
    EXPECT_FALSE(process_table(summary).lines(100).empty());
  }
  const TrafficSummary summary = traffic.summary(0);
  EXPECT_EQ(summary.messages, 4000);
  EXPECT_GT(summary.undecodable, 1000);
}

}  // namespace
}  // namespace cairn::spy
