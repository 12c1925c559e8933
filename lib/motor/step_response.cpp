// SPDX-License-Identifier: Apache-2.0
#include "motor/step_response.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace cairn::motor {
namespace {

/// Of a step's time, from here on the speed is taken to be constant.
constexpr double kSettledShare = 0.6;
constexpr std::size_t kMinPoints = 20;
constexpr double kMinWay_m = 0.01;
/// By how much the last two fifths may differ in speed.
constexpr double kSteady = 0.1;
/// TrackSpeed looks at three reading periods, and a duty holds for one: age on the average.
constexpr double kMeasuring_s = 0.04;
/// Of full_duty_mps, in duty: loop gain of the proportional part.
constexpr double kLoopGain = 0.8;

struct Line {
  double slope;
  double zero_at;
};

Line least_squares(std::vector<StepPoint>::const_iterator from,
                   std::vector<StepPoint>::const_iterator to) {
  const auto count = static_cast<double>(to - from);
  double t = 0;
  double x = 0;
  for (auto point = from; point != to; ++point) {
    t += point->t_s / count;
    x += point->way_m / count;
  }
  double tt = 0;
  double tx = 0;
  for (auto point = from; point != to; ++point) {
    tt += (point->t_s - t) * (point->t_s - t);
    tx += (point->t_s - t) * (point->way_m - x);
  }
  const double slope = tt > 0 ? tx / tt : 0;
  return {slope, slope != 0 ? t - x / slope : 0};
}

}  // namespace

Result<StepFit> fit_step(const std::vector<StepPoint>& points, double duty) {
  if (points.size() < kMinPoints)
    return fail("only " + std::to_string(points.size()) + " readings came during the step");
  const double way_m = (points.back().way_m - points.front().way_m) * (duty > 0 ? 1 : -1);
  if (std::abs(way_m) < kMinWay_m)
    return fail("it did not move: are the motors powered, and is the encoder connected?");
  if (way_m < 0)
    return fail("it moved the other way: turn its motor's or its encoder's wires round");
  const double length_s = points.back().t_s;
  const auto after = [&](double share) {
    return std::find_if(points.begin(), points.end(),
                        [&](const StepPoint& point) { return point.t_s >= share * length_s; });
  };
  const auto settled = after(kSettledShare);
  const auto middle = after((1 + kSettledShare) / 2);
  const Line line = least_squares(settled, points.end());
  const double first = least_squares(settled, middle).slope;
  const double second = least_squares(middle, points.end()).slope;
  if (std::abs(second - first) > kSteady * std::abs(line.slope))
    return fail("it has no constant speed by the end of the step");
  return StepFit{line.slope / duty, std::max(0.0, line.zero_at)};
}

TrackPidConfig settings_for(const StepFit& fit) {
  TrackPidConfig config;
  config.full_duty_mps = fit.full_duty_mps;
  config.response_s = fit.response_s + kMeasuring_s;
  config.proportional = kLoopGain / fit.full_duty_mps;
  config.integral = config.proportional / config.response_s;
  return config;
}

}  // namespace cairn::motor
