// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdlib>

namespace cairn::testing {

inline constexpr unsigned long long kSeed = 20240229;

/// How many damaged messages a test makes: CAIRN_MUTANTS of the environment, else 20,000.
[[nodiscard]] inline int mutant_count() {
  const char* wanted = std::getenv("CAIRN_MUTANTS");
  return wanted != nullptr ? std::atoi(wanted) : 20'000;
}

}  // namespace cairn::testing
