// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/why_still.hpp"

#include <gtest/gtest.h>

namespace cairn::cli {
namespace {

/// A robot that explores, sees its way, and knows where it is.
MotionHeard driving() {
  MotionHeard heard;
  heard.wheels.emplace();
  heard.wheels->gate = wheel_state_t::GATE_DRIVING;
  heard.clearance.emplace();
  heard.clearance->max_forward_mps = 0.3;
  heard.pose.emplace();
  heard.pose->state = pose_t::STATE_TRACKING;
  heard.plan.emplace();
  heard.plan->state = plan_state_t::STATE_EXPLORING;
  return heard;
}

TEST(WhyStill, ARobotThatMovesMoves) {
  MotionHeard heard = driving();
  heard.wheels->left_measured_mps = 0.3;
  heard.wheels->right_measured_mps = 0.2;
  EXPECT_TRUE(describe_motion(heard).moves);
  EXPECT_EQ(describe_motion(heard).text, "moves: 0.25 m/s, tracks 0.30 m/s and 0.20 m/s");
  heard.wheels->right_measured_mps = -0.3;
  EXPECT_TRUE(describe_motion(heard).moves) << "on the spot";
}

TEST(WhyStill, TheFirstReasonIsSaid) {
  MotionHeard heard = driving();
  EXPECT_EQ(describe_motion(heard).text, "holds still: driving: zero is commanded");
  heard.clearance->max_forward_mps = 0;
  heard.clearance->reason = "no sight of the floor at 0.4 m";
  EXPECT_EQ(describe_motion(heard).text,
            "holds still: no clearance: no sight of the floor at 0.4 m");
  heard.clearance.reset();
  EXPECT_EQ(describe_motion(heard).text, "holds still: no clearance: guard is not heard");
  heard.wheels->gate = wheel_state_t::GATE_IDLE;
  EXPECT_EQ(describe_motion(heard).text, "holds still: idle: nobody tells it to move");
  heard.plan->state = plan_state_t::STATE_REFUSED;
  heard.plan->reason = "unreachable: a wall";
  EXPECT_EQ(describe_motion(heard).text,
            "holds still: idle: planner refused the goal: unreachable: a wall");
  heard.pose->state = pose_t::STATE_LOST;
  EXPECT_EQ(describe_motion(heard).text,
            "holds still: lost: the localizer does not know where the robot is");
  heard.wheels->faults = 1;
  EXPECT_EQ(describe_motion(heard).text, "holds still: no wheels: motor has no controller");
  heard.wheels->gate = wheel_state_t::GATE_LATCHED;
  EXPECT_EQ(describe_motion(heard).text,
            "holds still: latched: somebody stopped the robot; ./cairn release ends it");
  heard.wheels.reset();
  EXPECT_EQ(describe_motion(heard).text, "holds still: no wheels: motor is not heard");
}

}  // namespace
}  // namespace cairn::cli
