// SPDX-License-Identifier: Apache-2.0
#include "system/demo_runs.hpp"

#include <fstream>
#include <sstream>

#include "core/child_process.hpp"
#include "system/recordings_of_tests.hpp"
#include "temporary_folder.hpp"

namespace cairn::testing {

namespace fs = std::filesystem;

Ran run_cairn(const std::vector<std::string>& words) {
  const TemporaryFolder folder;
  std::vector<std::string> command{program("cairn-cli")};
  command.insert(command.end(), words.begin(), words.end());
  auto child = ChildProcess::start(command, folder.path() / "output").value();
  const int code = child.wait();
  return {code, text_of(folder.path() / "output")};
}

nlohmann::json report_of(const fs::path& out) {
  return nlohmann::json::parse(text_of(out / "report.json"));
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

std::int64_t total(const nlohmann::json& counts) {
  std::int64_t sum = 0;
  for (const auto& [name, count] : counts.items()) sum += count.get<std::int64_t>();
  return sum;
}

double f_score(const fs::path& map, const fs::path& reference) {
  const Ran ran = run_cairn({"eval", "map", map, reference, "--json"});
  if (ran.code != 0) return -1;
  const auto json = nlohmann::json::parse(ran.output);
  return json["f_score"].is_number() ? json["f_score"].get<double>() : -1;
}

}  // namespace cairn::testing
