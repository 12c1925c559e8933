// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace cairn::testing {

/// What a program that was run to its end came to.
struct Ran {
  int code = 0;
  std::string output;
};

/// `cairn WORDS...`, run to its end.
[[nodiscard]] Ran run_cairn(const std::vector<std::string>& words);

[[nodiscard]] nlohmann::json report_of(const std::filesystem::path& out);
[[nodiscard]] std::string text_of(const std::filesystem::path& file);

/// Of "dropped" or "skipped" in a report, over all channels.
[[nodiscard]] std::int64_t total(const nlohmann::json& counts);

/// F-score of two maps within 5 cm, each in the frame of its own run's start.
[[nodiscard]] double f_score(const std::filesystem::path& map,
                             const std::filesystem::path& reference);

}  // namespace cairn::testing
