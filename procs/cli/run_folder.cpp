// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/run_folder.hpp"

#include <algorithm>
#include <array>
#include <string_view>

namespace cairn::cli {
namespace {

constexpr std::array<std::string_view, 11> kOwn{
    "trajectory.tum", "trajectory_final.tum", "truth.tum", "map.cairn", "map.png", "map.ply",
    "report.json",    "recording.lcmlog",     "state",     "log",       "sequence"};

}  // namespace

Result<void> prepare_run_folder(RunPlan& plan) {
  if (plan.out.empty()) plan.out = "out/replay";
  std::error_code error;
  std::filesystem::create_directories(plan.out, error);
  if (error) return fail(plan.out.string() + ": cannot make the folder: " + error.message());
  for (const auto& entry : std::filesystem::directory_iterator(plan.out, error)) {
    const std::string name = entry.path().filename();
    if (std::find(kOwn.begin(), kOwn.end(), name) == kOwn.end()) {
      return fail(plan.out.string() + ": holds '" + name +
                  "', which no run wrote; choose another --out");
    }
  }
  for (const std::string_view name : kOwn) {
    if (plan.source.lexically_normal().string().starts_with(
            (plan.out / name).lexically_normal().string()))
      continue;
    std::filesystem::remove_all(plan.out / name, error);
    if (error) return fail((plan.out / name).string() + ": cannot remove: " + error.message());
  }
  return {};
}

}  // namespace cairn::cli
