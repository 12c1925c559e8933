// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/run_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

#include "core/atomic_file.hpp"
#include "procs/supervisor/group_memory.hpp"

namespace cairn::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMark = ".cairn-run";
constexpr const char* kConfig = "config.yaml";
constexpr std::array<std::string_view, 14> kWrittenByRuns{"trajectory.tum", "trajectory_final.tum",
                                                          "truth.tum",      "map.cairn",
                                                          "map.png",        "map.ply",
                                                          "report.json",    "recording.lcmlog",
                                                          "state",          "log",
                                                          "sequence",       kConfig,
                                                          "group.yaml",     "wheels"};

bool lies_in(const fs::path& path, const fs::path& folder) {
  if (path.empty()) return false;
  const std::string inner = fs::weakly_canonical(path).string() + "/";
  return inner.starts_with(fs::weakly_canonical(folder).string() + "/");
}

Result<void> check_apart(const fs::path& folder, std::span<const fs::path> inputs) {
  for (const fs::path& input : inputs) {
    if (lies_in(input, folder)) {
      return fail(input.string() + ": lies in the folder that the results go to (" +
                  folder.string() + "); choose another --out");
    }
  }
  return {};
}

Result<void> check_idle(const fs::path& folder) {
  const RunUse use = use_of(folder);
  if (use == RunUse::kSupervised) {
    return fail(folder.string() +
                ": its process group runs; end it (./cairn down), or choose another --out");
  }
  if (use == RunUse::kUnsupervised) {
    return fail(folder.string() +
                ": its process group runs without its supervisor; take it up again (./cairn up "
                "GROUP --out " +
                folder.string() + "), or choose another --out");
  }
  return {};
}

Result<void> check_ours(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder / kMark, error) || fs::is_empty(folder, error)) return {};
  return fail(folder.string() + ": holds files that no run of cairn wrote; choose another --out");
}

Result<int> lock(const fs::path& folder) {
  const fs::path mark = folder / kMark;
  const int fd = ::open(mark.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return fail(mark.string() + ": cannot write: " + std::strerror(errno));
  if (::flock(fd, LOCK_EX | LOCK_NB) == 0) return fd;
  ::close(fd);
  return fail(folder.string() + ": another run is writing into it; choose another --out");
}

Result<void> write_config(const RunPlan& plan) {
  const auto text = config_text(plan);
  if (!text) return tl::make_unexpected(text.error());
  return write_file_atomically(plan.out / kConfig,
                               {reinterpret_cast<const std::uint8_t*>(text->data()), text->size()});
}

}  // namespace

fs::path config_of_run(const fs::path& folder) {
  std::error_code error;
  const fs::path config = folder / kConfig;
  const bool there = fs::exists(folder / kMark, error) && fs::exists(config, error);
  return there ? config : fs::path{};
}

Result<RunFolder> RunFolder::take(const fs::path& path, std::span<const fs::path> inputs) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) return fail(path.string() + ": cannot make the folder: " + error.message());
  if (auto apart = check_apart(path, inputs); !apart) return tl::make_unexpected(apart.error());
  if (auto ours = check_ours(path); !ours) return tl::make_unexpected(ours.error());
  const auto locked = lock(path);
  if (!locked) return tl::make_unexpected(locked.error());
  RunFolder folder(*locked);
  if (auto idle = check_idle(path); !idle) return tl::make_unexpected(idle.error());
  for (const std::string_view name : kWrittenByRuns) {
    fs::remove_all(path / name, error);
    if (error) return fail((path / name).string() + ": cannot remove: " + error.message());
  }
  return folder;
}

Result<RunFolder> RunFolder::open(RunPlan& plan) {
  if (plan.out.empty()) plan.out = "out/replay";
  auto folder =
      take(plan.out, std::array<fs::path, 4>{plan.source, plan.map, plan.truth, plan.config_file});
  if (!folder) return folder;
  if (auto written = write_config(plan); !written) return tl::make_unexpected(written.error());
  return folder;
}

RunFolder::RunFolder(RunFolder&& other) noexcept : lock_{std::exchange(other.lock_, -1)} {}

RunFolder::~RunFolder() {
  if (lock_ >= 0) ::close(lock_);
}

}  // namespace cairn::cli
