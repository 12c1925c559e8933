// SPDX-License-Identifier: Apache-2.0
#include "motor/latch_file.hpp"

#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string_view>
#include <system_error>

#include "core/atomic_file.hpp"
#include "core/checksum.hpp"
#include "motor/plain_text.hpp"

namespace cairn::motor {
namespace {

constexpr std::string_view kStateHome = "$XDG_STATE_HOME";
constexpr std::string_view kLatched = "cairn latch 1\nlatched by ";
constexpr std::string_view kReleased = "cairn latch 1\nreleased by ";
constexpr std::size_t kMaxFile_bytes = 4096;

std::span<const std::uint8_t> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string seal(std::string_view text) {
  char line[40];
  std::snprintf(line, sizeof line, "checksum %016" PRIx64 "\n", fnv1a_64(bytes_of(text)));
  return line;
}

}  // namespace

Result<std::filesystem::path> LatchFile::locate(const std::string& setting) {
  if (!setting.starts_with(kStateHome)) return std::filesystem::path(setting);
  const std::string rest = setting.substr(kStateHome.size());
  if (const char* state = std::getenv("XDG_STATE_HOME"); state != nullptr && *state == '/')
    return std::filesystem::path(state + rest);
  if (const char* home = std::getenv("HOME"); home != nullptr && *home == '/')
    return std::filesystem::path(std::string(home) + "/.local/state" + rest);
  return fail("latch_file: " + setting + ": neither XDG_STATE_HOME nor HOME is set");
}

LatchFile::State LatchFile::load() const {
  if (path_.empty()) return {};
  std::error_code problem;
  const auto there = std::filesystem::symlink_status(path_, problem);
  if (there.type() == std::filesystem::file_type::not_found) return {};
  const auto bytes = read_file(path_, kMaxFile_bytes);
  if (!bytes) return {true, bytes.error().message};
  const std::string_view text{reinterpret_cast<const char*>(bytes->data()), bytes->size()};
  const std::size_t check_at = text.rfind("checksum ");
  if (check_at == std::string_view::npos || text.substr(check_at) != seal(text.substr(0, check_at)))
    return {true, path_.string() + ": is damaged"};
  const std::string_view content = text.substr(0, check_at);
  for (const std::string_view kind : {kLatched, kReleased}) {
    if (!content.starts_with(kind) || !content.ends_with('\n')) continue;
    const std::string_view name = content.substr(kind.size(), content.size() - kind.size() - 1);
    return {kind == kLatched, std::string(name)};
  }
  return {true, path_.string() + ": is of another version"};
}

Result<void> LatchFile::save(const State& state) const {
  if (path_.empty()) return {};
  std::error_code problem;
  if (path_.has_parent_path()) std::filesystem::create_directories(path_.parent_path(), problem);
  if (problem) return fail(path_.parent_path().string() + ": cannot be made: " + problem.message());
  std::string text{state.latched ? kLatched : kReleased};
  text += plain_text(state.by) + "\n";
  text += seal(text);
  return write_file_atomically(path_, bytes_of(text));
}

}  // namespace cairn::motor
