// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace cairn::cli {

/// The whole command line of `cairn`. Exit code 0 after success, 2 for a wrong command line, 1 for
/// all else.
[[nodiscard]] int run(int argc, char** argv);

}  // namespace cairn::cli
