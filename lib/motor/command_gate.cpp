// SPDX-License-Identifier: Apache-2.0
#include "motor/command_gate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

namespace cairn::motor {
namespace {

/// Senders compute in floating point; what is over a limit by no more than this is at the limit.
constexpr double kRounding = 1 + 1e-6;

std::string number(double value) {
  std::string text = std::to_string(value);
  return text.substr(0, text.find('.') + 4);
}

std::string milliseconds(std::int64_t duration_us) {
  return std::to_string(duration_us / 1000) + " ms";
}

GateOutput standing(GateState state, Hold hold) { return {state, hold, 0, 0}; }

}  // namespace

CommandGate::CommandGate(const GateLimits& limits, bool latched, HostTime now_us)
    : limits_{limits}, latched_{latched}, latched_us_{now_us}, forgotten_us_{now_us} {}

Verdict CommandGate::check_fresh(const SentStamp& stamp, HostTime now_us) {
  if (stamp.sent_us > now_us) return refuse("future", "header.sent_steady_us: in the future");
  // Written so that no difference can overflow.
  if (stamp.sent_us < now_us - kMaxCommandAge_us)
    return refuse("stale",
                  "header.sent_steady_us: over " + milliseconds(kMaxCommandAge_us) + " ago");
  return {};
}

Verdict CommandGate::check_motion(const DriveOrder& order) const {
  if (!std::isfinite(order.forward_mps)) return refuse("not_finite", "forward_mps: is not finite");
  if (!std::isfinite(order.turn_radps)) return refuse("not_finite", "turn_radps: is not finite");
  if (std::abs(order.forward_mps) > limits_.max_speed_mps * kRounding)
    return refuse("too_fast", "forward_mps: is " + number(order.forward_mps) +
                                  ", the robot's limit is " + number(limits_.max_speed_mps));
  if (std::abs(order.turn_radps) > limits_.max_turn_radps * kRounding)
    return refuse("too_fast", "turn_radps: is " + number(order.turn_radps) +
                                  ", the robot's limit is " + number(limits_.max_turn_radps));
  return {};
}

Verdict CommandGate::drive(const DriveOrder& order, HostTime now_us) {
  if (auto good = check_motion(order); !good) return good;
  if (auto fresh = check_fresh(order.stamp, now_us); !fresh) return fresh;
  const bool person = order.driver == Driver::kPerson;
  if (person && order.lease == 0) return refuse("lease", "lease: a person drives with one only");
  if (person && leased(now_us) && person_->lease != order.lease)
    return refuse("lease", "lease: another person is driving");
  if (auto rising = (person ? person_order_ : planner_order_).take(order.stamp); !rising)
    return rising;
  if (latched_ || order.stamp.sent_us <= forgotten_us_) return {};
  (person ? person_ : planner_) = order;
  return {};
}

Verdict CommandGate::permit(const ForwardPermission& permission, HostTime now_us) {
  if (auto fresh = check_fresh(permission.stamp, now_us); !fresh) return fresh;
  if (auto rising = permission_order_.take(permission.stamp); !rising) return rising;
  permission_.reset();
  if (!std::isfinite(permission.max_forward_mps))
    return refuse("not_finite", "max_forward_mps: is not finite");
  permission_ = permission;
  return {};
}

void CommandGate::clock(Utime utime, HostTime sent_us, HostTime now_us) {
  if (clock_moved_us_ && utime == clock_utime_) return;
  clock_utime_ = utime;
  clock_moved_us_ = std::min(sent_us, now_us);
}

void CommandGate::stop(HostTime now_us) {
  latched_ = true;
  latched_us_ = now_us;
  forget(now_us);
}

Verdict CommandGate::release(bool person, const SentStamp& stamp, HostTime now_us) {
  if (!person) return refuse("not_a_person", "person: only a person releases");
  if (auto fresh = check_fresh(stamp, now_us); !fresh) return fresh;
  if (!latched_) return {};
  if (stamp.sent_us <= latched_us_)
    return refuse("stale", "header.sent_steady_us: before the last STOP, or before motor started");
  latched_ = false;
  forget(now_us);
  return {};
}

void CommandGate::forget(HostTime now_us) {
  planner_.reset();
  person_.reset();
  forgotten_us_ = now_us;
}

bool CommandGate::leased(HostTime now_us) const {
  return person_ && person_->stamp.sent_us >= now_us - kLease_us;
}

Hold CommandGate::without_permission(HostTime now_us, Utime data_now_us) const {
  if (!permission_ || permission_->stamp.sent_us < now_us - kMaxPermissionAge_us)
    return Hold::kNoGuard;
  const Utime seen_us = permission_->disparity_utime;
  if (seen_us < data_now_us - kMaxDisparityAge_us || seen_us > data_now_us + kMaxDisparityAge_us)
    return Hold::kNoSight;
  return permission_->max_forward_mps > 0 ? Hold::kNone : Hold::kNotFree;
}

GateOutput CommandGate::output(HostTime now_us, Utime data_now_us) const {
  if (latched_) return standing(GateState::kLatched, Hold::kLatched);
  if (!clock_moved_us_ || *clock_moved_us_ < now_us - kMaxClockAge_us)
    return standing(GateState::kIdle, Hold::kNoClock);
  const std::optional<DriveOrder>& order = leased(now_us) ? person_ : planner_;
  if (!order) return standing(GateState::kIdle, Hold::kNobody);
  if (order->stamp.sent_us < now_us - kMaxCommandAge_us)
    return standing(GateState::kIdle, Hold::kSilent);
  GateOutput output{GateState::kDriving, Hold::kNone, order->forward_mps, order->turn_radps};
  const Hold held = without_permission(now_us, data_now_us);
  if (held == Hold::kNoGuard && order->driver == Driver::kPlanner)
    return standing(GateState::kIdle, held);
  if (output.forward_mps > 0 && held != Hold::kNone) {
    if (held != Hold::kNotFree && output.turn_radps == 0) return standing(GateState::kIdle, held);
    output.hold = held;
    output.forward_mps = 0;
  } else if (output.forward_mps > 0) {
    output.forward_mps = std::min(output.forward_mps, permission_->max_forward_mps);
  }
  limit(output);
  return output;
}

// Where both do not fit, the turn is kept and the speed gives way.
void CommandGate::limit(GateOutput& output) const {
  const double half_gauge_m = limits_.track_gauge_m / 2;
  const double max_turn = std::min(limits_.max_turn_radps, limits_.max_speed_mps / half_gauge_m);
  output.turn_radps = std::clamp(output.turn_radps, -max_turn, max_turn);
  const double room =
      std::max(0.0, limits_.max_speed_mps - std::abs(output.turn_radps) * half_gauge_m);
  output.forward_mps = std::clamp(output.forward_mps, -room, room);
}

}  // namespace cairn::motor
