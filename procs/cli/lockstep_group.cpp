// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/lockstep_group.hpp"

namespace cairn::cli {

Result<void> LockstepGroup::run(const bus::Node& source, const std::function<bool()>& go_on) {
  lockstep_.run(source, go_on);
  for (const auto& finish : finish_) {
    if (auto finished = finish(); !finished) return finished;
  }
  return {};
}

}  // namespace cairn::cli
