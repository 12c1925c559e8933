// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "messages/check.hpp"
#include "procs/cli/command.hpp"
#include "procs/cli/group_session.hpp"
#include "procs/cli/why_still.hpp"
#include "procs/spy/printable.hpp"
#include "procs/spy/quantities.hpp"
#include "procs/spy/text_table.hpp"
#include "procs/supervisor/running_program.hpp"

namespace cairn::cli {
namespace {

namespace channels = bus::channels;
using Json = nlohmann::ordered_json;

/// A heartbeat of everybody comes in this time, and all that moves or stops a robot.
constexpr std::int64_t kListen_us = 1'100'000;
constexpr const char* kNotKnown = "-";

/// One line of the table.
struct Row {
  std::string process;
  bool wanted = true;
  std::string state;
  std::string health;
  std::string note;
  pid_t pid = 0;
  std::optional<double> cpu_share;
  std::optional<std::int64_t> rss_bytes;
  std::optional<std::int64_t> uptime_us;
  int restarts = 0;
  int exit_code = 0;
};

std::string state_name(const process_state_t& process) {
  switch (process.actual) {
    case process_state_t::ACTUAL_STARTING:
      return "starting";
    case process_state_t::ACTUAL_RUNNING:
      return "running";
    case process_state_t::ACTUAL_HUNG:
      return "hung";
    case process_state_t::ACTUAL_FAILED:
      return "failed";
    default:
      return process.wanted ? "down" : "stopped";
  }
}

std::string health_name(const process_status_t& status) {
  switch (status.health) {
    case process_status_t::HEALTH_STARTING:
      return "starting";
    case process_status_t::HEALTH_OK:
      return "ok";
    case process_status_t::HEALTH_WAITING:
      return "waiting";
    default:
      return "ill";
  }
}

// The health stands in a column of its own.
std::string without_health(const std::string& reason) {
  for (const char* health : {"ill: ", "waiting: "}) {
    if (reason.starts_with(health)) return reason.substr(std::string(health).size());
  }
  return reason;
}

/// Listens for a second, and knows the group then.
class Look {
 public:
  explicit Look(GroupSession& session) : session_{session} {
    bus::Node& node = session.node();
    node.on<channels::WheelState>([this](const wheel_state_t& m) { keep(m, motion_.wheels); });
    node.on<channels::Clearance>([this](const clearance_t& m) { keep(m, motion_.clearance); });
    node.on<channels::Pose>([this](const pose_t& m) { keep(m, motion_.pose); });
    node.on<channels::PlanState>([this](const plan_state_t& m) { motion_.plan = m; });
  }

  Result<void> listen() {
    const HostTime begin_us = session_.node().host_time();
    if (auto found = session_.find_supervisor(); !found) return found;
    const HostTime found_us = session_.node().host_time();
    std::map<pid_t, std::int64_t> ticks_before;
    for (const process_state_t& process : group().state()->processes) {
      ticks_before[process.pid] = ticks(process.pid);
    }
    ticks_before[group().state()->pid] = ticks(group().state()->pid);
    group().wait_until([] { return false; }, begin_us + kListen_us - found_us);
    const HostTime end_us = session_.node().host_time();
    if (group().state() == nullptr) return fail("the supervisor is not heard any more");
    for (const auto& [pid, before] : ticks_before) {
      const double used_s =
          static_cast<double>(ticks(pid) - before) / static_cast<double>(::sysconf(_SC_CLK_TCK));
      cpu_share_[pid] = used_s / to_seconds(end_us - found_us);
    }
    return {};
  }

  [[nodiscard]] std::vector<Row> rows() const {
    std::vector<Row> rows;
    for (const process_state_t& process : group().state()->processes) {
      Row row;
      row.process = process.process;
      row.wanted = process.wanted;
      row.state = state_name(process);
      row.note = without_health(process.reason);
      row.pid = process.pid;
      row.restarts = process.restarts;
      row.exit_code = process.exit_code;
      fill_in(row);
      rows.push_back(std::move(row));
    }
    rows.push_back(supervisor());
    return rows;
  }

  /// Nothing of a group that has no wheels.
  [[nodiscard]] std::optional<Motion> motion() const {
    if (!motion_.wheels && group().find("motor") == nullptr) return std::nullopt;
    return describe_motion(motion_);
  }

  [[nodiscard]] GroupClient& group() const { return session_.group(); }

 private:
  template <class Message>
  void keep(const Message& message, std::optional<Message>& into) {
    if (messages::check(message)) into = message;
  }

  static std::int64_t ticks(pid_t pid) {
    const auto stat = pid > 0 ? stat_of(pid) : std::nullopt;
    return stat ? stat->cpu_ticks : 0;
  }

  [[nodiscard]] Row supervisor() const {
    Row row;
    row.process = "supervisor";
    row.state = "running";
    row.pid = group().state()->pid;
    fill_in(row);
    if (const process_status_t* own = group().status(row.process)) {
      row.note = own->reason;
      for (const counter_t& counter : own->counters) {
        if (counter.name == "starts") row.restarts = static_cast<int>(counter.value - 1);
      }
    }
    return row;
  }

  void fill_in(Row& row) const {
    const auto share = cpu_share_.find(row.pid);
    if (row.pid != 0 && share != cpu_share_.end() && share->second >= 0) {
      row.cpu_share = share->second;
    }
    const process_status_t* own = row.pid == 0 ? nullptr : group().status(row.process);
    if (own == nullptr) return;
    row.health = health_name(*own);
    row.rss_bytes = own->rss_bytes;
    row.uptime_us = own->uptime_us;
  }

  GroupSession& session_;
  MotionHeard motion_;
  std::map<pid_t, double> cpu_share_;
};

std::string percent(double share) { return std::to_string(std::lround(100 * share)); }

void print_table(const Look& look) {
  spy::TextTable table({{"process"},
                        {"state"},
                        {"pid", true, 3},
                        {"health"},
                        {"cpu %", true, 2},
                        {"memory", true, 1},
                        {"restarts", true},
                        {"age", true, 4},
                        {"note"}});
  for (const Row& row : look.rows()) {
    table.add({row.process, row.state, row.pid == 0 ? kNotKnown : std::to_string(row.pid),
               row.health.empty() ? kNotKnown : row.health,
               row.cpu_share ? percent(*row.cpu_share) : kNotKnown,
               row.rss_bytes ? spy::bytes_text(static_cast<double>(*row.rss_bytes)) : kNotKnown,
               std::to_string(row.restarts),
               row.uptime_us ? spy::duration_text(static_cast<double>(*row.uptime_us)) : kNotKnown,
               spy::printable(row.note)});
  }
  for (const std::string& line : table.lines()) std::cout << line << "\n";
  if (const auto motion = look.motion()) std::cout << spy::printable(motion->text) << "\n";
}

Json to_json(const Row& row) {
  Json json{{"process", row.process}, {"wanted", row.wanted},     {"state", row.state},
            {"pid", row.pid},         {"health", nullptr},        {"cpu_share", nullptr},
            {"rss_bytes", nullptr},   {"restarts", row.restarts}, {"exit_code", row.exit_code},
            {"uptime_s", nullptr},    {"note", row.note}};
  if (row.pid == 0) json["pid"] = nullptr;
  if (!row.health.empty()) json["health"] = row.health;
  if (row.cpu_share) json["cpu_share"] = *row.cpu_share;
  if (row.rss_bytes) json["rss_bytes"] = *row.rss_bytes;
  if (row.uptime_us) json["uptime_s"] = to_seconds(*row.uptime_us);
  return json;
}

void print_json(const Look& look) {
  Json json{{"group", look.group().state()->group},
            {"run", look.group().state()->run},
            {"ready", look.group().ready()},
            {"moves", nullptr},
            {"motion", nullptr},
            {"processes", Json::array()}};
  if (const auto motion = look.motion()) {
    json["moves"] = motion->moves;
    json["motion"] = motion->text;
  }
  for (const Row& row : look.rows()) json["processes"].push_back(to_json(row));
  std::cout << json.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
}

int ps(const std::string& lcm_url, bool json) {
  const auto session = GroupSession::open(lcm_url);
  if (!session) return failed(session.error().message);
  Look look(**session);
  if (auto listened = look.listen(); !listened) return failed(listened.error().message);
  json ? print_json(look) : print_table(look);
  return 0;
}

}  // namespace

void add_ps(CLI::App& app, Run& run) {
  auto lcm_url = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  CLI::App* command =
      app.add_subcommand("ps", "the processes of the group, and why the robot does not move");
  command->add_flag("--json", *json, "for scripts; rates are fractions of 1");
  command->add_option("--lcm-url", *lcm_url, "bus of the group");
  command->footer("Example:\n  cairn ps");
  command->callback(
      [&run, lcm_url, json] { run = [lcm_url, json] { return ps(*lcm_url, *json); }; });
}

}  // namespace cairn::cli
