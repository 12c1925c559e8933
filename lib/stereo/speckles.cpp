// SPDX-License-Identifier: Apache-2.0
#include "stereo/speckles.hpp"

#include <algorithm>
#include <cstdlib>
#include <vector>

namespace cairn::stereo {
namespace {

/// Columns first to below end of a row, each within a step of the one before.
struct Run {
  int first = 0;
  int end = 0;
};

class Islands {
 public:
  int add(int size_px) {
    parent_.push_back(static_cast<int>(parent_.size()));
    size_px_.push_back(size_px);
    return parent_.back();
  }

  void join(int a, int b) {
    a = root(a);
    b = root(b);
    if (a == b) return;
    parent_[index(std::max(a, b))] = std::min(a, b);
    size_px_[index(std::min(a, b))] += size_px_[index(std::max(a, b))];
  }

  int size_px(int run) { return size_px_[index(root(run))]; }

 private:
  static std::size_t index(int run) { return static_cast<std::size_t>(run); }

  int root(int run) {
    while (parent_[index(run)] != run) {
      parent_[index(run)] = parent_[index(parent_[index(run)])];
      run = parent_[index(run)];
    }
    return run;
  }

  std::vector<int> parent_;
  std::vector<int> size_px_;
};

void find_runs(const std::int16_t* row, int cols, std::int16_t no_answer, int max_step_16ths,
               std::vector<Run>& runs) {
  for (int col = 0; col < cols;) {
    if (row[col] <= no_answer) {
      ++col;
      continue;
    }
    const int first = col++;
    while (col < cols && row[col] > no_answer &&
           std::abs(row[col] - row[col - 1]) <= max_step_16ths) {
      ++col;
    }
    runs.push_back({first, col});
  }
}

bool touch(const std::int16_t* a, const std::int16_t* b, int first, int end, int max_step_16ths) {
  for (int col = first; col < end; ++col) {
    if (std::abs(a[col] - b[col]) <= max_step_16ths) return true;
  }
  return false;
}

}  // namespace

void remove_speckles(cv::Mat_<std::int16_t>& disparity_16ths, std::int16_t no_answer,
                     int max_size_px, int max_step_16ths) {
  std::vector<Run> runs;
  std::vector<std::size_t> first_of_row{0};
  Islands islands;
  for (int row = 0; row < disparity_16ths.rows; ++row) {
    const std::int16_t* here = disparity_16ths[row];
    find_runs(here, disparity_16ths.cols, no_answer, max_step_16ths, runs);
    for (std::size_t i = first_of_row.back(); i < runs.size(); ++i) {
      islands.add(runs[i].end - runs[i].first);
    }
    std::size_t above = row > 0 ? first_of_row[static_cast<std::size_t>(row) - 1] : 0;
    const std::size_t above_end = first_of_row.back();
    for (std::size_t i = first_of_row.back(); i < runs.size() && above < above_end;) {
      const int first = std::max(runs[i].first, runs[above].first);
      const int end = std::min(runs[i].end, runs[above].end);
      if (touch(here, disparity_16ths[row - (row > 0)], first, end, max_step_16ths)) {
        islands.join(static_cast<int>(i), static_cast<int>(above));
      }
      if (runs[i].end < runs[above].end) {
        ++i;
      } else {
        ++above;
      }
    }
    first_of_row.push_back(runs.size());
  }
  for (int row = 0; row < disparity_16ths.rows; ++row) {
    const auto r = static_cast<std::size_t>(row);
    for (std::size_t i = first_of_row[r]; i < first_of_row[r + 1]; ++i) {
      if (islands.size_px(static_cast<int>(i)) > max_size_px) continue;
      std::int16_t* const here = disparity_16ths[row];
      std::fill(here + runs[i].first, here + runs[i].end, no_answer);
    }
  }
}

}  // namespace cairn::stereo
