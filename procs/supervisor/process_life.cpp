// SPDX-License-Identifier: Apache-2.0
#include "procs/supervisor/process_life.hpp"

#include <algorithm>
#include <csignal>
#include <cstring>

namespace cairn {
namespace {

std::string seconds_text(std::int64_t duration_us) {
  const std::int64_t tenths = (duration_us + 50'000) / 100'000;
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " s";
}

void forget_before(std::deque<HostTime>& times_us, HostTime limit_us) {
  while (!times_us.empty() && times_us.front() <= limit_us) times_us.pop_front();
}

}  // namespace

std::string describe_end(std::optional<int> exit_code) {
  if (!exit_code) return "ended";
  if (*exit_code >= 0) return "ended with code " + std::to_string(*exit_code);
  const char* name = ::sigabbrev_np(-*exit_code);
  return "killed by " +
         (name != nullptr ? "SIG" + std::string(name) : "signal " + std::to_string(-*exit_code));
}

ProcessLife::ProcessLife(const Policy& policy, const Memory& memory)
    : policy_{policy}, memory_{memory} {}

void ProcessLife::want(HostTime now_us) {
  if (memory_.failed || !memory_.wanted) {
    next_start_us_ = now_us;
    quick_deaths_in_a_row_ = 0;
    quick_deaths_us_.clear();
    starts_us_.clear();
  }
  memory_.wanted = true;
  memory_.failed = false;
}

void ProcessLife::want_not(HostTime now_us, const std::string& why) {
  memory_.wanted = false;
  memory_.failed = false;
  if (runs_) begin_to_stop(now_us);
  memory_.reason = why;
}

void ProcessLife::restart(HostTime now_us) {
  want(now_us);
  starts_us_.clear();
  if (runs_) begin_to_stop(now_us);
}

void ProcessLife::begin_to_stop(HostTime now_us) {
  if (!stopping_since_us_) stopping_since_us_ = now_us;
}

void ProcessLife::started(HostTime now_us) {
  adopted(now_us);
  ++memory_.starts;
  starts_us_.push_back(now_us);
}

void ProcessLife::adopted(HostTime now_us) {
  runs_ = true;
  started_us_ = now_us;
  heard_us_.reset();
  ready_since_us_.reset();
  stopping_since_us_.reset();
  last_signal_ = Action::kNone;
  killed_for_silence_ = false;
  note_.clear();
  if (!memory_.wanted) begin_to_stop(now_us);
}

void ProcessLife::could_not_start(HostTime now_us, const std::string& why) {
  memory_.reason = why;
  ready_since_us_.reset();
  died(now_us);
}

void ProcessLife::heard(HostTime now_us, bool ready, const std::string& note) {
  if (!runs_) return;
  heard_us_ = now_us;
  if (ready && !ready_since_us_) ready_since_us_ = now_us;
  note_ = note;
}

void ProcessLife::nobody_listened(std::int64_t duration_us) {
  if (heard_us_) *heard_us_ += duration_us;
  started_us_ += duration_us;
}

void ProcessLife::ended(HostTime now_us, std::optional<int> exit_code) {
  runs_ = false;
  memory_.exit_code = exit_code.value_or(0);
  const bool asked = stopping_since_us_.has_value() || !memory_.wanted;
  stopping_since_us_.reset();
  if (asked) {
    if (memory_.wanted) memory_.reason = "restarted by hand";
    if (exit_code == -SIGKILL) memory_.reason += "; it had to be killed";
    next_start_us_ = now_us;
    return;
  }
  memory_.reason =
      killed_for_silence_ ? "killed, because it did not answer" : describe_end(exit_code);
  const bool well = exit_code == 0 && !killed_for_silence_;
  if (policy_.restart == Restart::kAlways || (policy_.restart == Restart::kOnFailure && !well)) {
    return died(now_us);
  }
  memory_.wanted = false;
  memory_.failed = !well;
}

// To be called with what is known of the run that ended.
void ProcessLife::died(HostTime now_us) {
  const bool quick = !ready_since_us_ || now_us - *ready_since_us_ < kQuick_us;
  if (!quick) quick_deaths_in_a_row_ = 0;
  const int doublings = std::min(quick_deaths_in_a_row_, 30);
  next_start_us_ = now_us + std::min(kLongestDelay_us, kFirstDelay_us << doublings);
  if (!quick) return;
  ++quick_deaths_in_a_row_;
  forget_before(quick_deaths_us_, now_us - kWindow_us);
  quick_deaths_us_.push_back(now_us);
  if (quick_deaths_us_.size() < kQuickDeaths) return;
  memory_.failed = true;
  memory_.reason = "given up after " + std::to_string(kQuickDeaths) +
                   " quick deaths; the last: " + memory_.reason;
}

void ProcessLife::forget_the_past(HostTime now_us) {
  if (!ready_since_us_ || now_us - *ready_since_us_ < kWindow_us) return;
  quick_deaths_in_a_row_ = 0;
  quick_deaths_us_.clear();
}

ProcessLife::Action ProcessLife::next(HostTime now_us, bool held) {
  if (runs_) return next_of_running(now_us);
  forget_before(starts_us_, now_us - kWindow_us);
  const bool may = memory_.wanted && !memory_.failed && !held && now_us >= next_start_us_ &&
                   starts_us_.size() < kStartsPerWindow;
  return may ? Action::kStart : Action::kNone;
}

ProcessLife::Action ProcessLife::next_of_running(HostTime now_us) {
  if (stopping_since_us_) return next_of_stopping(now_us);
  forget_the_past(now_us);
  const bool silent =
      heard_us_ ? silent_us(now_us) >= kHangsForGood_us : now_us - started_us_ >= kLongestStart_us;
  if (!silent || killed_for_silence_) return Action::kNone;
  killed_for_silence_ = true;
  return Action::kKill;
}

// Asked twice, in two ways, before it is made to.
ProcessLife::Action ProcessLife::next_of_stopping(HostTime now_us) {
  const std::int64_t waited_us = now_us - *stopping_since_us_;
  Action due = Action::kInterrupt;
  if (2 * waited_us >= policy_.stop_grace_us) due = Action::kTerminate;
  if (waited_us >= policy_.stop_grace_us) due = Action::kKill;
  if (due <= last_signal_) return Action::kNone;
  last_signal_ = due;
  return due;
}

std::int64_t ProcessLife::silent_us(HostTime now_us) const {
  return heard_us_ ? now_us - *heard_us_ : 0;
}

ProcessLife::State ProcessLife::state(HostTime now_us) const {
  if (!runs_) return memory_.failed ? State::kFailed : State::kStopped;
  if (silent_us(now_us) >= kHangs_us || killed_for_silence_) return State::kHung;
  return ready_since_us_ ? State::kRunning : State::kStarting;
}

std::string ProcessLife::reason(HostTime now_us) const {
  if (runs_ && stopping_since_us_) return "is being ended";
  switch (state(now_us)) {
    case State::kHung:
      return "silent for " + seconds_text(silent_us(now_us));
    case State::kStarting:
    case State::kRunning:
      return note_;
    case State::kFailed:
    case State::kStopped:
      break;
  }
  if (!memory_.wanted || memory_.failed) return memory_.reason;
  const HostTime due_us = std::max(
      next_start_us_, starts_us_.size() < kStartsPerWindow ? 0 : starts_us_.front() + kWindow_us);
  if (due_us <= now_us) return memory_.reason;
  return memory_.reason + "; starts again in " + seconds_text(due_us - now_us);
}

}  // namespace cairn
