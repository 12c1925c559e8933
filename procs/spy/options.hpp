// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <tl/expected.hpp>

namespace cairn::spy {

struct Options {
  std::string lcm_url;
  std::string log;  ///< a recording to read instead of listening
  bool once = false;
  double seconds = 2;  ///< to listen with --once
  bool json = false;
  std::string channel;  ///< whose fields to show
};

/// Error: the exit code, where everything has been said already (help, a bad option).
[[nodiscard]] tl::expected<Options, int> parse_options(int argc, char** argv);

}  // namespace cairn::spy
