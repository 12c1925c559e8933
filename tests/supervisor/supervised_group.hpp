// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "procs/cli/group_client.hpp"
#include "procs/cli/group_session.hpp"
#include "procs/cli/kept_supervisor.hpp"
#include "procs/supervisor/group_config.hpp"
#include "temporary_folder.hpp"

namespace cairn::testing {

/// A group of stand-ins under a real supervisor, on real multicast; nothing of it is left when this
/// is gone.
class SupervisedGroup {
 public:
  /// With these names; change `config()` before `up()`.
  explicit SupervisedGroup(const std::vector<std::string>& processes);
  ~SupervisedGroup();
  SupervisedGroup(const SupervisedGroup&) = delete;
  SupervisedGroup& operator=(const SupervisedGroup&) = delete;

  [[nodiscard]] GroupConfig& config() { return config_; }
  /// Starts the supervisor, and waits until all is ready; false after 60 s.
  bool up();
  /// The same without waiting.
  void start();
  /// SIGKILL to the supervisor alone.
  void kill_supervisor();
  /// From now on nobody starts a supervisor that died; `keep_again` starts one.
  void let_supervisor_die();
  void keep_again();

  /// Spins and looks after the supervisor until it is so; false after `longest_s`.
  bool wait_until(const std::function<bool()>& so, double longest_s = 60);
  /// Ends the group by command, and waits until its supervisor is gone.
  bool down();

  [[nodiscard]] cli::GroupClient& group() { return session_->group(); }
  [[nodiscard]] const process_state_t& process(const std::string& name);
  [[nodiscard]] bool runs(const std::string& name);
  [[nodiscard]] HostTime now_us() { return session_->node().host_time(); }
  [[nodiscard]] bus::Node& node() { return session_->node(); }
  [[nodiscard]] std::filesystem::path run() const { return folder_.path() / "run"; }
  [[nodiscard]] std::optional<cli::KeptSupervisor>& supervisor() { return kept_; }
  [[nodiscard]] const Result<void>& supervisor_error() const { return error_; }
  [[nodiscard]] std::string log_of(const std::string& process) const;

  /// Of all processes of this run, and of one of its processes, from /proc.
  [[nodiscard]] std::multiset<pid_t> pids_in_proc() const;
  [[nodiscard]] std::multiset<pid_t> pids_in_proc(const std::string& process) const;

 private:
  TemporaryFolder folder_;
  GroupConfig config_;
  std::unique_ptr<cli::GroupSession> session_;
  std::optional<cli::KeptSupervisor> kept_;
  Result<void> error_;
};

/// Sorted; the value that so much of them do not exceed.
[[nodiscard]] double percentile(std::vector<double> values, double share);

/// "n 40, median 0.41, largest 0.63 s".
[[nodiscard]] std::string spread_text(const std::vector<double>& seconds);

}  // namespace cairn::testing
