// SPDX-License-Identifier: Apache-2.0
#include "motor/step_trial.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "motor/memory_link.hpp"
#include "wheel_rig.hpp"

namespace cairn::motor {
namespace {

constexpr std::int64_t kMs = 1000;

std::vector<StepPoint> step_of(double full_duty_mps, double lag_s, double duty) {
  testing::Plant plant;
  plant.full_duty_mps = full_duty_mps;
  plant.lag_s = lag_s;
  std::vector<StepPoint> points;
  for (int ms = 0; ms <= 1500; ++ms) {
    if (ms % 20 == 0) points.push_back({ms * 1e-3, static_cast<double>(plant.ticks()) / 5000});
    plant.run(duty, 0.001);
  }
  return points;
}

TEST(StepResponse, FindsSpeedAndLagOfAFirstOrderTrack) {
  for (const double full_mps : {0.3, 0.8, 2.0}) {
    for (const double lag_s : {0.03, 0.08, 0.2}) {
      for (const double duty : {0.4, -0.4}) {
        const auto fit = fit_step(step_of(full_mps, lag_s, duty), duty);
        ASSERT_TRUE(fit) << fit.error().message;
        EXPECT_NEAR(fit->full_duty_mps, full_mps, 0.01 * full_mps);
        EXPECT_NEAR(fit->response_s, lag_s, 0.006);
      }
    }
  }
}

TEST(StepResponse, SaysWhatIsWrongWithATrack) {
  const auto error = [](const std::vector<StepPoint>& points) {
    const auto fit = fit_step(points, 0.4);
    return fit ? "" : fit.error().message;
  };
  EXPECT_NE(error({}).find("readings"), std::string::npos);
  EXPECT_NE(error(step_of(0, 0.1, 0.4)).find("did not move"), std::string::npos);
  EXPECT_NE(error(step_of(0.8, 0.1, -0.4)).find("the other way"), std::string::npos);
  EXPECT_NE(error(step_of(0.8, 3, 0.4)).find("no constant speed"), std::string::npos);
}

/// The whole trial, by the reference controller.
struct Trial {
  Trial() {
    auto [far, near] = make_memory_links();
    rig.emplace(std::move(far), 1, now_us);
    trial.emplace(WheelLine("the line", open_once(std::move(near))), 5000, now_us);
  }
  void run(HostTime until_us = 60'000'000) {
    bool goes_on = true;
    while (goes_on && now_us < until_us) {
      now_us += kMs;
      if (rig) {
        rig->run(now_us);
        most_driven =
            std::max({most_driven, std::abs(rig->duty().left), std::abs(rig->duty().right)});
      }
      if (now_us % StepTrial::kTick_us == 0) goes_on = trial->tick(now_us);
    }
    if (rig) rig->run(now_us + kMs);
  }

  HostTime now_us = 1'000'000;
  double most_driven = 0;
  std::optional<testing::WheelRig> rig;
  std::optional<StepTrial> trial;
};

TEST(StepTrial, FindsBothTracksAndLeavesThemStanding) {
  Trial trial;
  trial.rig->right.full_duty_mps = 0.7;
  trial.rig->right.lag_s = 0.08;
  trial.run();
  const auto fits = trial.trial->result();
  ASSERT_TRUE(fits) << fits.error().message;
  EXPECT_NEAR(fits->at(0).full_duty_mps, 0.8, 0.01);
  EXPECT_NEAR(fits->at(1).full_duty_mps, 0.7, 0.01);
  // The line and its reading take up to 10 ms of it.
  EXPECT_NEAR(fits->at(0).response_s, 0.15, 0.015);
  EXPECT_NEAR(fits->at(1).response_s, 0.08, 0.015);
  EXPECT_FALSE(trial.rig->driven());
  EXPECT_NEAR(trial.most_driven, StepTrial::kDuty, 1e-4);
}

TEST(StepTrial, WithoutAControllerItEndsAndSaysWhy) {
  Trial trial;
  trial.rig->silent = true;
  trial.run();
  ASSERT_FALSE(trial.trial->result());
  EXPECT_NE(trial.trial->result().error().message.find("no wheel controller"), std::string::npos);
  EXPECT_EQ(trial.most_driven, 0);
}

TEST(StepTrial, EndsWithTheLossOfTheController) {
  Trial trial;
  trial.run(3'000'000);
  ASSERT_TRUE(trial.rig->driven());
  trial.rig->silent = true;
  trial.run();
  EXPECT_FALSE(trial.rig->driven());
  EXPECT_NE(trial.trial->result().error().message.find("was lost"), std::string::npos);
}

TEST(StepTrial, CanBeStopped) {
  Trial trial;
  trial.run(3'000'000);
  ASSERT_TRUE(trial.rig->driven());
  trial.trial->stop();
  trial.rig->run(trial.now_us + kMs);
  EXPECT_FALSE(trial.rig->driven());
  EXPECT_FALSE(trial.trial->tick(trial.now_us));
  EXPECT_FALSE(trial.trial->result());
}

// A robot's tracks as they are measured 50 times a second, under the settings that a trial of them
// suggests.
TEST(StepResponse, TheSettingsThatItSuggestsHoldTheTrackThatItSaw) {
  double worst = 0;
  for (const double full_mps : {0.4, 0.8, 2.0}) {
    for (const double lag_s : {0.03, 0.08, 0.15, 0.3}) {
      const TrackPidConfig config =
          settings_for(fit_step(step_of(full_mps, lag_s, 0.4), 0.4).value());
      TrackPid pid(config, 1);
      testing::Plant plant;
      plant.full_duty_mps = full_mps;
      plant.lag_s = lag_s;
      double ways[4] = {};
      const double target_mps = 0.5 * full_mps;
      double most_mps = 0;
      for (int i = 0; i < 200; ++i) {
        std::copy(ways + 1, ways + 4, ways);
        ways[3] = static_cast<double>(plant.ticks()) / plant.ticks_per_m;
        const double duty = pid.step(target_mps, (ways[3] - ways[0]) / 0.06, 0.02);
        for (int ms = 0; ms < 20; ++ms) plant.run(duty, 0.001);
        most_mps = std::max(most_mps, plant.speed_mps);
      }
      EXPECT_NEAR(plant.speed_mps, target_mps, 0.02 * target_mps) << full_mps << " " << lag_s;
      worst = std::max(worst, most_mps / target_mps - 1);
    }
  }
  std::printf("worst overshoot %.1f %%\n", 100 * worst);
  EXPECT_LT(worst, 0.05);
}

}  // namespace
}  // namespace cairn::motor
