// SPDX-License-Identifier: Apache-2.0
// spy: what goes over the bus, for people and scripts.
// in: everything   out: nothing
#include "procs/spy/modes.hpp"
#include "procs/spy/options.hpp"

int main(int argc, char** argv) {
  const auto options = cairn::spy::parse_options(argc, argv);
  return options ? cairn::spy::run(*options) : options.error();
}
