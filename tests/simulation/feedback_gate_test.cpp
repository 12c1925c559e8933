// SPDX-License-Identifier: Apache-2.0
#include "procs/simulator/feedback_gate.hpp"

#include <gtest/gtest.h>

namespace cairn {
namespace {

constexpr Utime kPeriod_us = 65'000;

Utime frame(int k) { return kMicrosecondsPerSecond + k * kPeriod_us; }

/// Everybody answers up to frame `k`.
void answer(FeedbackGate& gate, int k) {
  gate.hear_disparity(frame(k));
  gate.hear_pose(frame(k));
  gate.hear_map(frame(k));
}

TEST(FeedbackGate, LetsTwoFramesGoUnanswered) {
  FeedbackGate gate(true);
  for (int k = 0; k < 2; ++k) {
    EXPECT_FALSE(gate.waits_for(k)) << k;
    gate.frame_taken(frame(k));
  }
  EXPECT_EQ(gate.waits_for(2), "DISPARITY, POSE");
}

TEST(FeedbackGate, FrameKPlusTwoWaitsForDisparityAndPoseOfFrameK) {
  FeedbackGate gate(true);
  for (int k = 0; k < 40; ++k) {
    if (k >= 2) {
      gate.hear_map(frame(k - 2));
      EXPECT_EQ(gate.waits_for(k), "DISPARITY, POSE") << k;
      gate.hear_pose(frame(k - 2));
      EXPECT_EQ(gate.waits_for(k), "DISPARITY") << k;
      gate.hear_disparity(frame(k - 2));
    }
    ASSERT_FALSE(gate.waits_for(k)) << k;
    gate.frame_taken(frame(k));
  }
}

TEST(FeedbackGate, FrameKPlusEightWaitsForTheMapThroughFrameK) {
  FeedbackGate gate(true);
  for (int k = 0; k < 8; ++k) {
    gate.hear_disparity(frame(k));
    gate.hear_pose(frame(k));
    ASSERT_FALSE(gate.waits_for(k)) << k;
    gate.frame_taken(frame(k));
  }
  EXPECT_EQ(gate.waits_for(8), "MAP_DELTA");
  gate.hear_map(frame(0) - 1);
  EXPECT_EQ(gate.waits_for(8), "MAP_DELTA");
  gate.hear_map(frame(0));
  EXPECT_FALSE(gate.waits_for(8));
}

TEST(FeedbackGate, WhoMakesDisparitiesItselfWaitsForNone) {
  FeedbackGate gate(false);
  gate.frame_taken(frame(0));
  gate.frame_taken(frame(1));
  EXPECT_EQ(gate.waits_for(0), "POSE");
}

TEST(FeedbackGate, GivesUpWhatDoesNotComeUntilItIsHeardOfAgain) {
  FeedbackGate gate(true);
  int k = 0;
  const auto take = [&] { gate.frame_taken(frame(k++)); };
  take();
  take();
  gate.hear_disparity(frame(1));
  const HostTime start_us = 77;
  EXPECT_EQ(gate.waits_for(start_us), "POSE");
  EXPECT_EQ(gate.waits_for(start_us + FeedbackGate::kPatience_us - 1), "POSE");
  EXPECT_FALSE(gate.waits_for(start_us + FeedbackGate::kPatience_us));
  take();
  gate.hear_disparity(frame(2));
  EXPECT_FALSE(gate.waits_for(start_us + FeedbackGate::kPatience_us));
  gate.hear_pose(frame(0));
  EXPECT_EQ(gate.waits_for(start_us + FeedbackGate::kPatience_us), "POSE");
  answer(gate, k);
  EXPECT_FALSE(gate.waits_for(start_us + FeedbackGate::kPatience_us));
}

}  // namespace
}  // namespace cairn
