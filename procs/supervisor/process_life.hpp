// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>

#include "core/time.hpp"

namespace cairn {

/// When one process of a group is to be started, told to end, and killed: what is wanted of it
/// against what it does. Knows no process and reads no clock: it is told what happened and asked
/// what to do, all in host time.
///
/// A process that dies is started again after 0.25 s. A *quick* death, before it was heard well for
/// 3 s, doubles that time for the next, up to 30 s; 60 s well, or a death that was not quick,
/// begins it anew. 5 quick deaths within 60 s: it is given up until somebody wants it again. Never
/// more than 10 starts within a minute, whatever it dies of. One that was heard and is silent for 2
/// s hangs; after 2.75 s it is killed, which is a death.
class ProcessLife {
 public:
  enum class Action { kNone, kStart, kInterrupt, kTerminate, kKill };
  enum class State { kStopped, kStarting, kRunning, kHung, kFailed };
  enum class Restart { kAlways, kOnFailure, kNever };

  static constexpr std::int64_t kFirstDelay_us = 250'000;
  static constexpr std::int64_t kLongestDelay_us = 30 * kMicrosecondsPerSecond;
  static constexpr std::int64_t kQuick_us = 3 * kMicrosecondsPerSecond;
  static constexpr int kQuickDeaths = 5;
  static constexpr std::int64_t kWindow_us = 60 * kMicrosecondsPerSecond;
  static constexpr int kStartsPerWindow = 10;
  static constexpr std::int64_t kHangs_us = 2 * kMicrosecondsPerSecond;
  static constexpr std::int64_t kHangsForGood_us = 2'750'000;
  /// Time to the first heartbeat, for a large map for example.
  static constexpr std::int64_t kLongestStart_us = 30 * kMicrosecondsPerSecond;

  struct Policy {
    Restart restart = Restart::kAlways;
    std::int64_t stop_grace_us = 10 * kMicrosecondsPerSecond;
  };

  /// What a supervisor that takes over must know.
  struct Memory {
    bool wanted = true;
    bool failed = false;
    int starts = 0;
    int exit_code = 0;
    std::string reason;
  };

  ProcessLife(const Policy& policy, const Memory& memory);

  // ---- what people want ----

  /// Runs from now on; one that was given up gets another chance.
  void want(HostTime now_us);
  void want_not(HostTime now_us, const std::string& why = "stopped by hand");
  /// Ends and runs again, without back-off; wanted from now on.
  void restart(HostTime now_us);

  // ---- what happened ----

  void started(HostTime now_us);
  /// An earlier supervisor had started it, and it runs.
  void adopted(HostTime now_us);
  /// `why` in words; counts as a quick death.
  void could_not_start(HostTime now_us, const std::string& why);
  /// A heartbeat; `ready`: it is up. `note`: what it says about itself.
  void heard(HostTime now_us, bool ready, const std::string& note);
  /// Minus the signal's number where it was killed; nothing where nobody can know.
  void ended(HostTime now_us, std::optional<int> exit_code);
  /// For so long nobody has listened: that was not its silence.
  void nobody_listened(std::int64_t duration_us);

  /// What is to be done now. To be carried out, and asked again some ten times a second. It is not
  /// started while `held`.
  [[nodiscard]] Action next(HostTime now_us, bool held = false);

  // ---- how it is ----

  [[nodiscard]] State state(HostTime now_us) const;
  [[nodiscard]] bool wanted() const { return memory_.wanted; }
  [[nodiscard]] bool runs() const { return runs_; }
  /// It has been up since it was last started.
  [[nodiscard]] bool ready() const { return runs_ && ready_since_us_.has_value(); }
  [[nodiscard]] int restarts() const { return memory_.starts > 0 ? memory_.starts - 1 : 0; }
  [[nodiscard]] int exit_code() const { return memory_.exit_code; }
  [[nodiscard]] std::string reason(HostTime now_us) const;
  [[nodiscard]] const Memory& memory() const { return memory_; }

 private:
  void died(HostTime now_us);
  void begin_to_stop(HostTime now_us);
  void forget_the_past(HostTime now_us);
  [[nodiscard]] Action next_of_running(HostTime now_us);
  [[nodiscard]] Action next_of_stopping(HostTime now_us);
  [[nodiscard]] std::int64_t silent_us(HostTime now_us) const;

  Policy policy_;
  Memory memory_;
  bool runs_ = false;
  HostTime started_us_ = 0;
  std::optional<HostTime> heard_us_;
  std::optional<HostTime> ready_since_us_;
  std::optional<HostTime> stopping_since_us_;
  Action last_signal_ = Action::kNone;
  bool killed_for_silence_ = false;
  std::string note_;  ///< what it last said about itself
  HostTime next_start_us_ = 0;
  int quick_deaths_in_a_row_ = 0;
  std::deque<HostTime> quick_deaths_us_;
  std::deque<HostTime> starts_us_;
};

/// "ended with code 1", "killed by SIGSEGV".
[[nodiscard]] std::string describe_end(std::optional<int> exit_code);

}  // namespace cairn
