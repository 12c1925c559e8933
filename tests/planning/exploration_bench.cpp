// SPDX-License-Identifier: Apache-2.0
// Explores a world many times, each with another seed, and prints a line for each.
//   exploration_bench WORLD.yaml|random FIRST_SEED LAST_SEED [PEOPLE [LIMIT_S [RESOLUTION_M]]]
// With "random" every seed is another place. Set STORY=1 to read what the robot said,
// UNSEEN=1 where floor was left unseen.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "explorer_bench.hpp"
#include "random_world.hpp"

namespace {

double at_share(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

/// Where reachable floor was not seen, by half metres, largest first.
void tell_unseen(const cairn::testing::ExplorerBench& bench) {
  std::map<std::pair<int, int>, int> counts;
  const auto& cells = bench.sight().floor().cells();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (bench.sight().seen()[i] != 0) continue;
    const auto half = [](double m) { return static_cast<int>(std::floor(2 * m)); };
    ++counts[{half(cells[i].middle_m.x()), half(cells[i].middle_m.y())}];
  }
  for (const auto& [place, count] : counts) {
    std::printf("  unseen %.4f m2 in the half metre from (%.1f, %.1f)\n", count * 0.0025,
                0.5 * place.first, 0.5 * place.second);
  }
}

}  // namespace

int main(int argc, char** argv) {
  using namespace cairn;
  if (argc < 4) {
    std::fprintf(stderr, "exploration_bench WORLD.yaml|random FIRST LAST [PEOPLE [LIMIT_S ...]]\n");
    return 2;
  }
  const std::string place = argv[1];
  const auto number = [&](int i, double otherwise) {
    return argc > i ? std::atof(argv[i]) : otherwise;
  };
  for (int seed = std::atoi(argv[2]); seed <= std::atoi(argv[3]); ++seed) {
    auto world = place == "random" ? testing::random_world(static_cast<unsigned>(seed))
                                   : simulation::load_world(place);
    if (!world) {
      std::fprintf(stderr, "%s\n", world.error().message.c_str());
      return 1;
    }
    testing::BenchConfig config;
    config.seed = static_cast<unsigned>(seed);
    config.people =
        std::min(static_cast<int>(number(4, 2)), static_cast<int>(world->people.size()));
    config.resolution_m = number(6, config.resolution_m);
    testing::ExplorerBench bench(*world, config);
    bench.navigator().explore(0);
    bench.run(number(5, 900));
    const auto& report = bench.navigator().report();
    const bool finished = report.phase == planning::Phase::kArrived;
    std::printf(
        "%s seed %d people %d: %s %.0f s, %.1f m, coverage %.3f, collisions %d, "
        "planner %.2f ms mean %.1f p99 %.1f max, guard %.2f mean %.1f p99; %s\n",
        place.substr(place.rfind('/') + 1).c_str(), seed, config.people,
        finished ? "finished" : "UNFINISHED", bench.time_s(), bench.driven_m(), bench.coverage(),
        static_cast<int>(bench.collisions()), mean(bench.cost().planner_ms),
        at_share(bench.cost().planner_ms, 0.99), at_share(bench.cost().planner_ms, 1),
        mean(bench.cost().guard_ms), at_share(bench.cost().guard_ms, 0.99), report.reason.c_str());
    if (std::getenv("STORY") != nullptr) std::fputs(bench.story().c_str(), stdout);
    if (std::getenv("UNSEEN") != nullptr) tell_unseen(bench);
    std::fflush(stdout);
  }
  return 0;
}
