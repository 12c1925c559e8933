// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/result.hpp"
#include "core/start_program.hpp"

namespace cairn {

/// One run of a program since this machine was booted. Another run that gets the same pid later has
/// another time of start.
struct ProgramId {
  pid_t pid = 0;
  std::int64_t start_ticks = 0;  ///< since boot, as in /proc/PID/stat

  friend bool operator==(const ProgramId&, const ProgramId&) = default;
};

struct ProgramStat {
  ProgramId id;
  std::int64_t cpu_ticks = 0;  ///< processor time used since its start
};

/// Of what runs under this pid now; nothing where nothing does, or only waits to be reaped.
[[nodiscard]] std::optional<ProgramStat> stat_of(pid_t pid);
[[nodiscard]] std::optional<ProgramId> identify(pid_t pid);

/// Whether a process is the leader of this session, or one that it started.
[[nodiscard]] bool in_session_of(pid_t pid, pid_t leader);

/// Tells this boot of the machine from others.
[[nodiscard]] std::string boot_id();

/// A program in a session of its own, started by us or by an earlier supervisor. It runs on where
/// this goes away.
class RunningProgram {
 public:
  /// `note` is called with its id before it runs; where that fails, it never runs.
  [[nodiscard]] static Result<RunningProgram> start(
      Program program, const std::function<Result<void>(ProgramId)>& note);

  /// Nothing where it does not run any more.
  [[nodiscard]] static std::optional<RunningProgram> adopt(const ProgramId& id);

  /// To it and to all that it started in its session.
  void signal(int number) const;

  struct End {
    std::optional<int> exit_code;  ///< minus the signal's number; nothing of one that was adopted
  };
  /// Nothing while it runs. What it started and left behind is killed. Not to be asked again once
  /// it has ended.
  [[nodiscard]] std::optional<End> end();

  [[nodiscard]] const ProgramId& id() const { return id_; }

  /// Whether this process is it, or belongs to its session.
  [[nodiscard]] bool owns(pid_t pid) const;

 private:
  RunningProgram(const ProgramId& id, std::shared_ptr<const int> handle, bool ours)
      : id_{id}, handle_{std::move(handle)}, ours_{ours} {}

  ProgramId id_;
  std::shared_ptr<const int> handle_;  ///< a file descriptor of the process itself, not of its pid
  bool ours_;
};

}  // namespace cairn
