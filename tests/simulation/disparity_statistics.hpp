// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <opencv2/core.hpp>
#include <string>

#include "stereo/disparity_image.hpp"

namespace cairn::simulation {

/// What disparities of one kind of place are worth, against the truth.
struct DisparityStatistics {
  double places = 0;
  double answers = 0;
  double bad = 0;   ///< off by over 2 px
  double sure = 0;  ///< answers with a confidence of 1 or more
  double sure_bad = 0;
  double sum = 0;  ///< of the errors that are not bad
  double sum_of_squares = 0;

  [[nodiscard]] double density() const { return answers / places; }
  [[nodiscard]] double bad_share() const { return bad / answers; }
  [[nodiscard]] double sure_share() const { return sure / answers; }
  [[nodiscard]] double sure_bad_share() const { return sure_bad / std::max(1.0, sure); }
  [[nodiscard]] double bias_px() const { return sum / (answers - bad); }
  [[nodiscard]] double sigma_px() const {
    return std::sqrt(sum_of_squares / (answers - bad) - bias_px() * bias_px());
  }

  void add(bool answered, double error_px, int confidence) {
    ++places;
    if (!answered) return;
    ++answers;
    const bool wrong = std::abs(error_px) > 2;
    bad += wrong ? 1 : 0;
    sure += confidence >= 1 ? 1 : 0;
    sure_bad += confidence >= 1 && wrong ? 1 : 0;
    if (wrong) return;
    sum += error_px;
    sum_of_squares += error_px * error_px;
  }
};

/// Sorts a disparity image's cells, 4 px apart, by where they are: `near` (nearer than 190 px),
/// `outside` (the right picture), `covered` (from the right eye), `edge` (within 16 px of a jump of
/// over 3 px in 4, along row or column), `floor` (disparity changes by over 0.6 px per row) and
/// `plain`. `truth_px` is of the image's own camera, 4 px apart.
class DisparityComparison {
 public:
  void add(const stereo::DisparityImage& seen, const cv::Mat_<float>& truth_px) {
    constexpr int kApart_px = 4;
    const int every = kApart_px / seen.step_px;
    for (int row = kReach; row < truth_px.rows - kReach; ++row) {
      double leftmost_px = 1e9;
      for (int col = truth_px.cols - 1; col >= 0; --col) {
        const double right_px = static_cast<double>(col * kApart_px) - truth_px(row, col);
        const bool covered = right_px > leftmost_px - 0.5;
        leftmost_px = std::min(leftmost_px, right_px);
        if (col < kReach || col >= truth_px.cols - kReach || truth_px(row, col) <= 2) continue;
        const std::string kind = kind_of(truth_px, row, col, right_px < 0, covered);
        const int r = row * every;
        const int c = col * every;
        const bool answered = seen.valid(r, c);
        const double error_px = answered ? seen.disparity_px(r, c) - truth_px(row, col) : 0;
        kinds_[kind].add(answered, error_px, seen.code(r, c));
      }
    }
  }

  [[nodiscard]] const DisparityStatistics& of(const std::string& kind) { return kinds_[kind]; }
  static constexpr std::array<const char*, 6> kKinds{"plain",   "floor",   "edge",
                                                     "covered", "outside", "near"};

 private:
  static constexpr int kReach = 5;

  static std::string kind_of(const cv::Mat_<float>& truth, int row, int col, bool outside,
                             bool covered) {
    const float here = truth(row, col);
    if (here >= 190) return "near";
    if (outside) return "outside";
    if (covered) return "covered";
    for (int k = 1; k < kReach; ++k) {
      for (const int sign : {-1, 1}) {
        const int at = col + sign * k;
        if (std::abs(truth(row, at) - truth(row, at - sign)) > 3) return "edge";
        const int to = row + sign * k;
        if (k > 1 &&
            std::abs(truth(to, col) - 2 * truth(to - sign, col) + truth(to - 2 * sign, col)) > 3) {
          return "edge";
        }
      }
    }
    return std::abs(truth(row + 1, col) - truth(row - 1, col)) > 0.6 * 8 ? "floor" : "plain";
  }

  std::map<std::string, DisparityStatistics> kinds_;
};

}  // namespace cairn::simulation
