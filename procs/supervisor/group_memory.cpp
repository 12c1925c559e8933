// SPDX-License-Identifier: Apache-2.0
#include "procs/supervisor/group_memory.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace cairn {
namespace {

using Json = nlohmann::json;

constexpr const char* kFile = "group";
constexpr std::size_t kRoom_bytes = 16'384;
constexpr std::size_t kLongestReason = 300;

Json to_json(const GroupMemory::Process& process) {
  return {{"wanted", process.life.wanted},
          {"failed", process.life.failed},
          {"starts", process.life.starts},
          {"exit_code", process.life.exit_code},
          {"reason", process.life.reason.substr(0, kLongestReason)},
          {"pid", process.program.pid},
          {"start_ticks", process.program.start_ticks}};
}

GroupMemory::Process to_process(const Json& json, bool same_boot) {
  GroupMemory::Process process;
  process.life.wanted = json.at("wanted").get<bool>();
  process.life.failed = json.at("failed").get<bool>();
  process.life.starts = json.at("starts").get<int>();
  process.life.exit_code = json.at("exit_code").get<int>();
  process.life.reason = json.at("reason").get<std::string>();
  if (same_boot) {
    process.program.pid = json.at("pid").get<pid_t>();
    process.program.start_ticks = json.at("start_ticks").get<std::int64_t>();
  }
  return process;
}

}  // namespace

std::vector<std::uint8_t> to_bytes(const GroupMemory& memory, const std::string& boot) {
  Json json{{"boot", boot},
            {"supervisor_starts", memory.supervisor_starts},
            {"ending", memory.ending},
            {"processes", Json::object()}};
  for (const auto& [name, process] : memory.processes) json["processes"][name] = to_json(process);
  std::string text = json.dump(1, ' ', false, Json::error_handler_t::replace);
  text.resize((text.size() / kRoom_bytes + 1) * kRoom_bytes, '\n');
  return {text.begin(), text.end()};
}

std::optional<GroupMemory> group_memory(std::span<const std::uint8_t> bytes,
                                        const std::string& boot) {
  try {
    const Json json = Json::parse(bytes.begin(), bytes.end());
    GroupMemory memory;
    memory.supervisor_starts = json.at("supervisor_starts").get<int>();
    memory.ending = json.at("ending").get<bool>();
    const bool same_boot = json.at("boot").get<std::string>() == boot;
    for (const auto& [name, process] : json.at("processes").items()) {
      memory.processes.emplace(name, to_process(process, same_boot));
    }
    return memory;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::optional<GroupMemory> recall_group(const StateFolder& state) {
  const auto bytes = state.load(kFile);
  if (!bytes || bytes->empty()) return std::nullopt;
  return group_memory(*bytes, boot_id());
}

// Both slots get their room at once.
Result<void> remember_group(const StateFolder& state, const GroupMemory& memory) {
  const auto bytes = to_bytes(memory, boot_id());
  if (!state.load(kFile)) {
    if (auto saved = state.save(kFile, bytes); !saved) return saved;
  }
  return state.save(kFile, bytes);
}

Result<void> forget_group(const StateFolder& state) { return state.save(kFile, {}); }

std::filesystem::path supervisor_state(const std::filesystem::path& run) {
  return run / "state" / "supervisor";
}

RunUse use_of(const std::filesystem::path& run) {
  std::error_code error;
  if (!std::filesystem::exists(supervisor_state(run), error)) return RunUse::kNone;
  const auto state = StateFolder::open(supervisor_state(run));
  if (!state) return RunUse::kSupervised;
  const auto memory = recall_group(*state);
  if (!memory) return RunUse::kNone;
  const bool any_runs =
      std::any_of(memory->processes.begin(), memory->processes.end(), [](const auto& process) {
        return RunningProgram::adopt(process.second.program).has_value();
      });
  return any_runs ? RunUse::kUnsupervised : RunUse::kNone;
}

}  // namespace cairn
