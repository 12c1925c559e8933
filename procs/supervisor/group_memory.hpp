// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/state_folder.hpp"
#include "procs/supervisor/process_life.hpp"
#include "procs/supervisor/running_program.hpp"

namespace cairn {

/// What a supervisor leaves to the one that takes over.
struct GroupMemory {
  struct Process {
    ProcessLife::Memory life;
    ProgramId program;  ///< pid 0: does not run
  };
  std::map<std::string, Process> processes;
  int supervisor_starts = 0;
  bool ending = false;  ///< the group is being ended
};

/// On disk as text, with room to spare: rewriting it needs no new room on a disk that has become
/// full.
[[nodiscard]] std::vector<std::uint8_t> to_bytes(const GroupMemory& memory,
                                                 const std::string& boot);

/// Nothing where the bytes are none that to_bytes made. Of another boot, no program runs any more.
[[nodiscard]] std::optional<GroupMemory> group_memory(std::span<const std::uint8_t> bytes,
                                                      const std::string& boot);

/// What the supervisor of a run has left. Nothing: the run is new, or its group was ended.
[[nodiscard]] std::optional<GroupMemory> recall_group(const StateFolder& state);
[[nodiscard]] Result<void> remember_group(const StateFolder& state, const GroupMemory& memory);
[[nodiscard]] Result<void> forget_group(const StateFolder& state);

/// Folder of a run's supervisor.
[[nodiscard]] std::filesystem::path supervisor_state(const std::filesystem::path& run);

enum class RunUse {
  kNone,
  kSupervised,   ///< a supervisor has it
  kUnsupervised  ///< its supervisor died, its processes run on
};
[[nodiscard]] RunUse use_of(const std::filesystem::path& run);

}  // namespace cairn
