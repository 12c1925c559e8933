// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>

#include "procs/cli/run_plan.hpp"

namespace cairn::cli {

/// The folder that a run writes into, held by a lock for as long as this lives.
///
/// A folder is taken if it is new, empty, or holds the mark of an earlier run; of that run's files
/// only those that runs write are removed. Anything else is refused, so that nobody's files are
/// lost: a folder that no run made, one that another run is writing into, and one that holds what
/// this run is to read, and one whose process group runs.
class RunFolder {
 public:
  /// Makes it if it is missing. The inputs are what the run is to read; empty paths are none.
  [[nodiscard]] static Result<RunFolder> take(const std::filesystem::path& folder,
                                              std::span<const std::filesystem::path> inputs);

  /// plan.out, by default out/replay; it gets the effective config of the run (config.yaml).
  /// Everything that can be wrong with the plan should have been found before.
  [[nodiscard]] static Result<RunFolder> open(RunPlan& plan);

  RunFolder(RunFolder&& other) noexcept;
  RunFolder& operator=(RunFolder&&) = delete;
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;
  ~RunFolder();

 private:
  explicit RunFolder(int lock) : lock_{lock} {}
  int lock_;
};

/// The config that the run of this folder had; empty where the folder is no run's.
[[nodiscard]] std::filesystem::path config_of_run(const std::filesystem::path& folder);

}  // namespace cairn::cli
