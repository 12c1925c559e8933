// SPDX-License-Identifier: Apache-2.0
#include "motor/step_trial.hpp"

#include <cmath>

namespace cairn::motor {
namespace {

constexpr std::array<const char*, 2> kNames{"left", "right"};
/// A track that is not driven may do so much of what the other one does.
constexpr double kStill = 0.1;

double way_m(const std::vector<StepPoint>& points) {
  return points.empty() ? 0 : std::abs(points.back().way_m);
}

}  // namespace

bool StepTrial::tick(HostTime now_us) {
  if (done_) return false;
  const WheelLine::News news = line_.poll(now_us);
  if ((seen_ && news.anew) || (seen_ && !line_.connected())) {
    end("the wheel controller was lost" + (line_.trouble().empty() ? "" : ": " + line_.trouble()));
  } else if (!seen_ && now_us - began_us_ > kPatience_us) {
    end("no wheel controller: " + line_.trouble());
  }
  seen_ = seen_ || line_.connected();
  for (const ReportFrame& report : news.reports) {
    if (!done_) take(report);
  }
  return !done_;
}

void StepTrial::take(const ReportFrame& report) {
  if (!any_) since_us_ = report.device_us;
  any_ = true;
  const std::int64_t passed_us = report.device_us - since_us_;
  if (!stepping_ && passed_us >= kRest_us) {
    stepping_ = true;
    since_us_ = report.device_us;
    from_ticks_ = {report.left_ticks, report.right_ticks};
  } else if (stepping_) {
    const std::array<std::int64_t, 2> ticks{report.left_ticks, report.right_ticks};
    for (std::size_t i = 0; i < 2; ++i) {
      points_[track_][i].push_back(
          {to_seconds(passed_us), static_cast<double>(ticks[i] - from_ticks_[i]) / ticks_per_m_});
    }
    if (passed_us >= kStep_us) {
      stepping_ = false;
      since_us_ = report.device_us;
      if (++track_ == 2) return end("");
    }
  }
  line_.drive(stepping_ && track_ == 0 ? kDuty : 0, stepping_ && track_ == 1 ? kDuty : 0);
}

void StepTrial::stop() { end("stopped"); }

void StepTrial::end(const std::string& problem) {
  line_.stop();
  line_.drive(0, 0);
  if (!done_) problem_ = problem;
  done_ = true;
}

Result<std::array<StepFit, 2>> StepTrial::result() const {
  if (!problem_.empty()) return fail(problem_);
  std::array<StepFit, 2> fits{};
  for (std::size_t i = 0; i < 2; ++i) {
    const std::string name = kNames[i];
    if (way_m(points_[i][1 - i]) > kStill * way_m(points_[i][i]))
      return fail(name + " was driven and the other track moved: are left and right mixed up?");
    const auto fit = fit_step(points_[i][i], kDuty);
    if (!fit) return fail(name + " track: " + fit.error().message);
    fits[i] = *fit;
  }
  return fits;
}

}  // namespace cairn::motor
