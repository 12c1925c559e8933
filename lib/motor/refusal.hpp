// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace cairn::motor {

/// Why something that was ordered is not done.
struct Refusal {
  const char* kind;  ///< what it is counted under: one word of a few
  std::string why;   ///< names the field
};

using Verdict = tl::expected<void, Refusal>;

[[nodiscard]] inline tl::unexpected<Refusal> refuse(const char* kind, std::string why) {
  return tl::make_unexpected(Refusal{kind, std::move(why)});
}

}  // namespace cairn::motor
