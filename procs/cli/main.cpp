// SPDX-License-Identifier: Apache-2.0
// cairn: the one command for people; `cairn --help` lists its words.
#include "procs/cli/cli.hpp"

int main(int argc, char** argv) { return cairn::cli::run(argc, argv); }
