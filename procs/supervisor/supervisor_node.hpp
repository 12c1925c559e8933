// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/group_command_t.hpp>
#include <cairn/group_state_t.hpp>
#include <cairn/process_status_t.hpp>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "core/config.hpp"
#include "core/state_folder.hpp"
#include "procs/supervisor/group_life.hpp"
#include "procs/supervisor/printed_lines.hpp"
#include "procs/supervisor/running_program.hpp"

namespace cairn {

struct SupervisorConfig {
  std::string group;
  std::string run;

  void visit(ConfigVisitor& v) {
    v.text("group", group, "file of the group; its format: config/groups/README.md");
    v.text("run", run, "folder of this run: state/PROCESS and log/PROCESS.log");
  }
};

/// supervisor: starts a group of processes, watches their heartbeats, starts again what died or
/// hangs, tells everybody how they are, and does what people tell it. Killed, it leaves them
/// running; started again on the same run, it takes them up. Ended in an orderly way, it ends them.
class SupervisorNode {
 public:
  using Config = SupervisorConfig;
  static constexpr const char* kName = "supervisor";
  static constexpr const char* kAbout =
      "supervisor: starts a group of processes and starts again what died or hangs (GROUP_STATE)";

  [[nodiscard]] static Result<void> check(const Config& config);

  /// An error: another supervisor has this run, or the run's folder cannot be written.
  [[nodiscard]] static Result<std::unique_ptr<SupervisorNode>> create(const Config& config,
                                                                      bus::Node& node);

  SupervisorNode(const GroupConfig& group, std::filesystem::path run, StateFolder state,
                 const std::optional<GroupMemory>& memory, bus::Node& node);

  /// Ends all processes of the group, and waits for their ends. An error: one that could not be
  /// ended; or that the group was not started, because another one is on the bus.
  [[nodiscard]] Result<void> finish();

 private:
  struct Child {
    std::optional<RunningProgram> program;
    std::optional<PrintedLines> printed;
    std::set<pid_t> former;  ///< pids of its earlier runs
  };
  struct Stranger {
    pid_t pid;
    HostTime heard_us;
  };

  void adopt(const GroupMemory& memory);
  void look_after();
  void notice_ends(HostTime now_us);
  void act(HostTime now_us);
  void start(std::size_t process, HostTime now_us);
  void say(std::size_t process, const std::string& what);
  void take(const process_status_t& status);
  void take(const group_state_t& other);
  void take(const group_command_t& command);
  [[nodiscard]] Result<void> obey(const group_command_t& command);
  void refuse_bus(const std::string& who);
  void carry_output();
  void publish_changes();
  [[nodiscard]] group_state_t state_message() const;
  [[nodiscard]] GroupMemory memory() const;
  [[nodiscard]] Result<void> remember();
  void tell_health();

  GroupConfig group_;
  std::filesystem::path run_;
  StateFolder state_;
  bus::Node& node_;
  GroupLife life_;
  std::vector<Child> children_;  ///< in the order of life_
  int starts_ = 1;               ///< of supervisors of this run
  HostTime listen_until_us_;     ///< until then it finds out whether the bus is free
  HostTime looked_us_;
  Result<void> bus_is_ours_;
  std::map<std::string, Stranger> strangers_;          ///< by the name that they use
  std::map<std::int64_t, std::int32_t> last_command_;  ///< sequence by session
  std::vector<std::int64_t> published_;                ///< what was in the newest GROUP_STATE
  Result<void> remembered_;
};

}  // namespace cairn
