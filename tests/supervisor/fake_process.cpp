// SPDX-License-Identifier: Apache-2.0
// Stands in for any process of a group: a heartbeat and nothing else, or what its settings say.
#include <sys/prctl.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>

#include "bus/process.hpp"

namespace {

struct FakeConfig {
  int exit_at_once = -1;
  std::string print;
  bool crash = false;

  void visit(cairn::ConfigVisitor& v) {
    v.integer("exit_at_once", exit_at_once, -1, 255, "", "code; -1: runs");
    v.text("print", print, "written to stderr at start");
    v.flag("crash", crash, "abort at start");
  }
};

// It goes by the name of its state folder.
std::string name_of(int argc, char** argv) {
  for (int i = 1; i + 1 < argc; ++i) {
    if (std::string(argv[i]) == "--state") return std::filesystem::path(argv[i + 1]).filename();
  }
  return "fake";
}

}  // namespace

int main(int argc, char** argv) {
  FakeConfig config;
  ::prctl(PR_SET_DUMPABLE, 0);  // its crashes are no news
  cairn::bus::ProcessDescription fake;
  fake.name = name_of(argc, argv);
  fake.about = "a stand-in";
  fake.visit_config = [&](cairn::ConfigVisitor& v) { config.visit(v); };
  fake.check = [] { return cairn::Result<void>{}; };
  fake.start = [&](cairn::bus::Node&) -> cairn::Result<std::function<cairn::Result<void>()>> {
    if (!config.print.empty()) std::cerr << config.print << std::endl;
    if (config.exit_at_once >= 0) ::_exit(config.exit_at_once);
    if (config.crash) std::abort();
    return std::function<cairn::Result<void>()>([] { return cairn::Result<void>{}; });
  };
  return cairn::bus::run_process(argc, argv, fake);
}
