// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "procs/spy/options.hpp"

namespace cairn::spy {

/// Does what the options ask, until it is done or told to stop. Exit code: 0, or 1 for a failure,
/// which is said on stderr.
[[nodiscard]] int run(const Options& options);

}  // namespace cairn::spy
