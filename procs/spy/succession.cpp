// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/succession.hpp"

#include <algorithm>

namespace cairn::spy {

int restarts_in(std::vector<HeardRun> runs) {
  std::sort(runs.begin(), runs.end(),
            [](const HeardRun& a, const HeardRun& b) { return a.first_us < b.first_us; });
  int restarts = 0;
  std::vector<HeardRun> unreplaced;
  for (const HeardRun& run : runs) {
    const auto former =
        std::find_if(unreplaced.begin(), unreplaced.end(), [&](const HeardRun& earlier) {
          return earlier.process == run.process && earlier.last_us < run.first_us;
        });
    if (former == unreplaced.end()) {
      unreplaced.push_back(run);
    } else {
      *former = run;
      ++restarts;
    }
  }
  return restarts;
}

}  // namespace cairn::spy
