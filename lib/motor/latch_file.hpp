// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "core/result.hpp"

namespace cairn::motor {

/// Keeps over every restart whether STOP holds a robot. A file that is not there holds nothing; one
/// that cannot be read, or is not whole, holds the robot.
class LatchFile {
 public:
  struct State {
    bool latched = false;
    std::string by;  ///< who latched or released it; or what is wrong with the file
  };

  /// `setting` is a path; `$XDG_STATE_HOME` at its beginning stands for that variable, or for
  /// `~/.local/state` where it is not set. An error: neither it nor HOME is set.
  [[nodiscard]] static Result<std::filesystem::path> locate(const std::string& setting);

  /// An empty path: nothing is kept and nothing is found.
  explicit LatchFile(std::filesystem::path path) : path_{std::move(path)} {}

  [[nodiscard]] State load() const;

  /// On disk when this returns without an error. Makes the folder if it is missing.
  [[nodiscard]] Result<void> save(const State& state) const;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace cairn::motor
