// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bus/host_clock.hpp"
#include "bus/node.hpp"
#include "core/child_process.hpp"
#include "procs/cli/run_recorder.hpp"
#include "temporary_folder.hpp"

namespace cairn::testing {

/// What a stock kernel gives a socket: asked for half of 212,992, which the kernel doubles.
inline constexpr const char* kStockUrl = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=106496";

/// What a replay runs besides its source.
inline const std::vector<std::string> kWithoutCamera{"stereo", "odometry", "localizer", "mapper"};

/// Real processes on real multicast, and a listener.
class LiveGroup {
 public:
  explicit LiveGroup(const std::filesystem::path& dataset, double speed = 1);

  /// camera, stereo, odometry, localizer or mapper with this run's state folder and settings; again
  /// after a kill: a restart.
  void start(const std::string& process);
  /// Any other program, under a name.
  void start(const std::string& name, const std::vector<std::string>& command);
  void kill(const std::string& name, int signal = 9);
  /// Waits for its end; its exit code.
  int wait(const std::string& name);

  /// Listens until it is so; false after `longest_s` without.
  bool listen_until(const std::function<bool()>& so, double longest_s = 60);
  bool listen_until_heard(const std::vector<std::string>& processes);
  /// Listens until nothing has come for a second.
  void listen_until_quiet();
  /// SIGTERM to the project's processes, then to all others (lcm-logger drops its backlog if it
  /// ends before its senders), and waits for their ends.
  void stop();

  [[nodiscard]] cli::RunRecorder& heard() { return *recorder_; }
  [[nodiscard]] std::filesystem::path folder() const { return folder_.path(); }
  [[nodiscard]] std::filesystem::path map() const {
    return folder_.path() / "mapper" / "map.cairn";
  }
  /// What a process printed.
  [[nodiscard]] std::string output(const std::string& name) const;
  [[nodiscard]] bus::Node& node() { return *node_; }
  [[nodiscard]] bus::Bus& bus() { return *bus_; }

 private:
  TemporaryFolder folder_;
  std::map<std::string, std::vector<std::string>> settings_;
  bus::SteadyClock clock_;
  std::unique_ptr<bus::Bus> bus_;
  std::unique_ptr<bus::Node> node_;
  std::unique_ptr<cli::RunRecorder> recorder_;
  std::map<std::string, ChildProcess> children_;
};

}  // namespace cairn::testing
