// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "core/time.hpp"
#include "motor/message_order.hpp"
#include "motor/refusal.hpp"

namespace cairn::motor {

enum class Driver { kPlanner, kPerson };

/// How to move now.
struct DriveOrder {
  SentStamp stamp;
  Driver driver = Driver::kPlanner;
  std::int64_t lease = 0;  ///< of a person; never 0 there
  double forward_mps = 0;
  double turn_radps = 0;
};

/// How fast the robot may move forward.
struct ForwardPermission {
  SentStamp stamp;
  double max_forward_mps = 0;
  Utime disparity_utime = 0;  ///< of the DISPARITY that it rests on
};

struct GateLimits {
  double max_speed_mps = 0;  ///< of the body, and of each track
  double max_turn_radps = 0;
  double track_gauge_m = 0;
};

enum class GateState { kIdle, kDriving, kLatched };

/// What keeps the robot from doing what it is told; the last two are none of the gate's.
enum class Hold {
  kNone,
  kLatched,       ///< STOP
  kNoClock,       ///< data time stands still, or there is none
  kNobody,        ///< no order since the start, the last STOP, or since the wheels were lost
  kSilent,        ///< the driver's last order is too old
  kNoGuard,       ///< no permission was sent lately
  kNoSight,       ///< the permission rests on what was seen too long ago
  kNotFree,       ///< the permission is for no speed at all
  kNoController,  ///< nobody answers on the line to the wheels
  kStalled        ///< a track did not move when it was driven; given a rest
};

struct GateOutput {
  GateState state = GateState::kIdle;
  Hold hold = Hold::kNobody;
  double forward_mps = 0;
  double turn_radps = 0;

  /// No drive at all, at once: not one that slows down.
  [[nodiscard]] bool stands() const { return state != GateState::kDriving; }
};

/// Decides whether the robot moves. It holds still unless it is told, freshly and with a clear
/// view, to move. Host time is passed in and never goes back; ages run from sending.
///
/// STOP beats a person, a person with a lease beats the planner. Forward motion needs permission.
/// Turning on the spot and going back need none; but the planner, who has no eyes of his own for
/// what is near, does nothing at all while no permission comes, whatever it says.
class CommandGate {
 public:
  static constexpr std::int64_t kMaxCommandAge_us = 250'000;
  static constexpr std::int64_t kMaxPermissionAge_us = 200'000;
  static constexpr std::int64_t kMaxDisparityAge_us = 400'000;  ///< of data time
  static constexpr std::int64_t kMaxClockAge_us = 250'000;
  static constexpr std::int64_t kLease_us = 1'000'000;  ///< from a person's last order

  /// Starts idle or latched; what was sent before `now_us` never counts.
  CommandGate(const GateLimits& limits, bool latched, HostTime now_us);

  /// Refused: what is too old, sent in the future, replayed, not finite, over the limits, or a
  /// person's without a lease or under the lease of another.
  [[nodiscard]] Verdict drive(const DriveOrder& order, HostTime now_us);

  /// The newest permission counts. One that is not a speed takes away the one before it.
  [[nodiscard]] Verdict permit(const ForwardPermission& permission, HostTime now_us);

  /// Data time is `utime`, as was said at `sent_us`.
  void clock(Utime utime, HostTime sent_us, HostTime now_us);

  /// Latches, whoever says it and whenever it was said.
  void stop(HostTime now_us);

  /// Ends the latch, for a person who said so in the last 250 ms and after the last STOP. What was
  /// ordered before stays forgotten.
  [[nodiscard]] Verdict release(bool person, const SentStamp& stamp, HostTime now_us);

  /// What was ordered up to now counts no more: the robot moves only by an order sent later.
  void forget(HostTime now_us);

  [[nodiscard]] bool latched() const { return latched_; }

  /// What to do now: always finite and within the limits, zero unless driving.
  [[nodiscard]] GateOutput output(HostTime now_us, Utime data_now_us) const;

 private:
  [[nodiscard]] static Verdict check_fresh(const SentStamp& stamp, HostTime now_us);
  [[nodiscard]] Verdict check_motion(const DriveOrder& order) const;
  [[nodiscard]] bool leased(HostTime now_us) const;
  [[nodiscard]] Hold without_permission(HostTime now_us, Utime data_now_us) const;
  void limit(GateOutput& output) const;

  GateLimits limits_;
  bool latched_;
  HostTime latched_us_;
  HostTime forgotten_us_;
  MessageOrder planner_order_;
  MessageOrder person_order_;
  MessageOrder permission_order_;
  std::optional<DriveOrder> planner_;
  std::optional<DriveOrder> person_;
  std::optional<ForwardPermission> permission_;
  Utime clock_utime_ = 0;
  std::optional<HostTime> clock_moved_us_;
};

}  // namespace cairn::motor
