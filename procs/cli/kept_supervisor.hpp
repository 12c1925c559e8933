// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>

#include "core/result.hpp"
#include "core/time.hpp"
#include "procs/supervisor/process_life.hpp"
#include "procs/supervisor/running_program.hpp"

namespace cairn::cli {

/// A supervisor that is started again when it dies. Its processes run on without it; a new one
/// takes them up. Where this goes away, the supervisor and its group stay: end() ends them.
class KeptSupervisor {
 public:
  /// `run` holds the group.yaml of write_group, and its supervisor listens on the bus named there.
  /// What it prints is appended to RUN/log/supervisor.log.
  [[nodiscard]] static Result<KeptSupervisor> start(const std::filesystem::path& run,
                                                    HostTime now_us);

  /// To be called some ten times a second: starts it again where it died, with the back-off of
  /// every process. An error: it ended with a failure of its own before it was up, as where another
  /// group is on the bus; the error is what it said.
  [[nodiscard]] Result<void> look_after(HostTime now_us);

  /// It ended well: somebody ended the group.
  [[nodiscard]] bool ended() const { return ended_; }

  /// How often it was started again.
  [[nodiscard]] int restarts() const { return life_.restarts(); }

  /// 0 while it does not run.
  [[nodiscard]] pid_t pid() const { return program_ ? program_->id().pid : 0; }

  /// Tells it to end the group and itself; it is looked after until it has.
  void end();

 private:
  explicit KeptSupervisor(std::filesystem::path run);
  [[nodiscard]] std::filesystem::path log() const;
  [[nodiscard]] Result<void> start_now(HostTime now_us);
  [[nodiscard]] Result<void> take_end(HostTime now_us, const RunningProgram::End& end);

  std::filesystem::path run_;
  std::string lcm_url_;
  ProcessLife life_;
  std::optional<RunningProgram> program_;
  HostTime told_us_ = 0;  ///< when it was told to end, or started
  bool ending_ = false;
  bool ended_ = false;
};

/// Keeps the supervisor of this run until its group is ended; ends it on SIGINT, SIGTERM or SIGHUP.
[[nodiscard]] Result<void> keep_supervisor(const std::filesystem::path& run);

}  // namespace cairn::cli
