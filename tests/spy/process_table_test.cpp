// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/process_table.hpp"

#include <gtest/gtest.h>

#include "procs/spy/succession.hpp"
#include "spy/messages.hpp"

namespace cairn::spy {
namespace {

constexpr std::int64_t kSecond = 1'000'000;

TEST(Succession, AnotherRunAfterSilenceIsARestart) {
  EXPECT_EQ(restarts_in({}), 0);
  EXPECT_EQ(restarts_in({{"a", 0, 10}}), 0);
  EXPECT_EQ(restarts_in({{"a", 0, 10}, {"a", 11, 20}, {"a", 21, 30}}), 2);
}

TEST(Succession, ThoseWhoSpeakAtTheSameTimeAreTwo) {
  EXPECT_EQ(restarts_in({{"a", 0, 10}, {"a", 5, 20}}), 0);
  EXPECT_EQ(restarts_in({{"a", 0, 10}, {"a", 5, 20}, {"a", 12, 30}}), 1);
}

TEST(Succession, AnotherProcessIsNoRestart) {
  EXPECT_EQ(restarts_in({{"a", 0, 10}, {"b", 11, 20}}), 0);
  EXPECT_EQ(restarts_in({{"", 0, 10}, {"", 11, 20}, {"b", 30, 40}}), 1);
}

TEST(ProcessTable, ShowsWhatTheProcessSays) {
  process_status_t status = process_status("stereo", 1);
  status.pid = 42;
  status.health = process_status_t::HEALTH_WAITING;
  status.reason = "no STEREO_FRAME";
  status.uptime_us = 10 * kSecond;
  status.cpu_s = 5;
  for (int i = 1; i <= 2; ++i) {
    channel_status_t channel{};
    channel.received = 100 * i;
    channel.published = 10 * i;
    channel.lost = i;
    channel.skipped = 2 * i;
    channel.refused = 3 * i;
    status.channels.push_back(channel);
  }
  ProcessTable table;
  table.add(status, 0);
  ProcessSummary row = table.summary(0).at(0);
  EXPECT_EQ(row.process, "stereo");
  EXPECT_EQ(row.pid, 42);
  EXPECT_EQ(row.health, "waiting");
  EXPECT_EQ(row.reason, "no STEREO_FRAME");
  EXPECT_TRUE(row.same_types);
  EXPECT_DOUBLE_EQ(row.cpu_share.value(), 0.5);
  EXPECT_EQ(row.received, 300);
  EXPECT_EQ(row.published, 30);
  EXPECT_EQ(row.lost, 3);
  EXPECT_EQ(row.skipped, 6);
  EXPECT_EQ(row.refused, 9);

  status.uptime_us = 12 * kSecond;
  status.cpu_s = 5.5;
  table.add(status, 2 * kSecond);
  EXPECT_DOUBLE_EQ(table.summary(2 * kSecond).at(0).cpu_share.value(), 0.25);
  EXPECT_EQ(table.name_of(1), "stereo");
  EXPECT_EQ(table.name_of(2), "");
}

TEST(ProcessTable, SilenceForTwoSecondsIsSaid) {
  ProcessTable table;
  table.add(process_status("stereo", 1), 0);
  EXPECT_EQ(table.summary(2 * kSecond).at(0).health, "ok");
  EXPECT_EQ(table.summary(2 * kSecond + 1).at(0).health, "silent");
  EXPECT_EQ(table.summary(3 * kSecond).at(0).age_us, 3 * kSecond);
}

TEST(ProcessTable, ARestartedProcessIsOneRow) {
  ProcessTable table;
  table.add(process_status("stereo", 1), 0);
  table.add(process_status("stereo", 1), kSecond);
  table.add(process_status("stereo", 9), 3 * kSecond);
  const auto rows = table.summary(3 * kSecond);
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].session, 9);
  EXPECT_EQ(rows[0].restarts, 1);
}

TEST(ProcessTable, TwoOfOneNameAreTwoRows) {
  ProcessTable table;
  for (int i = 0; i < 4; ++i) {
    table.add(process_status("camera", 1), i * kSecond);
    table.add(process_status("camera", 2), i * kSecond + 500'000);
  }
  const auto rows = table.summary(4 * kSecond);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].restarts, 0);
}

TEST(ProcessTable, ForeignTypesAreSeen) {
  process_status_t status = process_status("old", 1);
  ++status.types_hash;
  ProcessTable table;
  table.add(status, 0);
  EXPECT_FALSE(table.summary(0).at(0).same_types);
}

}  // namespace
}  // namespace cairn::spy
