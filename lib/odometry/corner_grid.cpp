// SPDX-License-Identifier: Apache-2.0
#include "odometry/corner_grid.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace cairn::odometry {
namespace {

constexpr int kBlock_px = 3;
constexpr int kCornersPerCell = 4;
/// Strength of the weaker gradient that makes a corner [grey levels per px].
constexpr double kMinGradient_per_px = 1.5;
/// cornerMinEigenVal of a gradient of 1 grey level per px: 9 px of (8 / (4 * 3 * 255))^2.
constexpr double kResponseOfUnitGradient = 9.0 * 64.0 / (3060.0 * 3060.0);

struct Candidate {
  float response;
  int x;
  int y;
};

bool stronger(const Candidate& a, const Candidate& b) {
  if (a.response != b.response) return a.response > b.response;
  return a.y != b.y ? a.y < b.y : a.x < b.x;
}

bool is_local_maximum(const cv::Mat_<float>& response, int x, int y) {
  const float centre = response(y, x);
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      if (response(y + dy, x + dx) > centre) return false;
    }
  }
  return true;
}

/// The image's cells, row by row, each with a list of what falls into it.
class Cells {
 public:
  Cells(cv::Size image, int target)
      : side_px_{std::max(8, static_cast<int>(std::lround(std::sqrt(
                                 static_cast<double>(image.area()) * kCornersPerCell / target))))},
        cols_{(image.width + side_px_ - 1) / side_px_},
        candidates_(static_cast<std::size_t>(cols_ * ((image.height + side_px_ - 1) / side_px_))),
        filled_(candidates_.size()) {}

  [[nodiscard]] std::size_t of(int x, int y) const {
    return static_cast<std::size_t>(y / side_px_ * cols_ + x / side_px_);
  }
  [[nodiscard]] std::size_t count() const { return candidates_.size(); }
  std::vector<Candidate>& candidates(std::size_t cell) { return candidates_[cell]; }
  int& filled(std::size_t cell) { return filled_[cell]; }

 private:
  int side_px_;
  int cols_;
  std::vector<std::vector<Candidate>> candidates_;
  std::vector<int> filled_;
};

}  // namespace

std::vector<cv::Point2f> spread_corners(const cv::Mat& image, const std::vector<cv::Point2f>& taken,
                                        int target, int min_distance_px, int margin_px) {
  cv::Mat_<float> response;
  cv::cornerMinEigenVal(image, response, kBlock_px);
  Cells cells(image.size(), target);
  cv::Mat_<std::uint8_t> is_free(image.size(), std::uint8_t{255});
  for (const cv::Point2f& point : taken) {
    const cv::Point at{cvRound(point.x), cvRound(point.y)};
    if (!cv::Rect({0, 0}, image.size()).contains(at)) continue;
    cv::circle(is_free, at, min_distance_px, 0, cv::FILLED);
    ++cells.filled(cells.of(at.x, at.y));
  }
  const auto threshold =
      static_cast<float>(kResponseOfUnitGradient * kMinGradient_per_px * kMinGradient_per_px);
  const int margin = std::max(1, margin_px);
  for (int y = margin; y < image.rows - margin; ++y) {
    for (int x = margin; x < image.cols - margin; ++x) {
      if (response(y, x) < threshold || is_free(y, x) == 0 || !is_local_maximum(response, x, y)) {
        continue;
      }
      cells.candidates(cells.of(x, y)).push_back({response(y, x), x, y});
    }
  }
  std::vector<cv::Point2f> corners;
  for (std::size_t cell = 0; cell < cells.count(); ++cell) {
    auto& candidates = cells.candidates(cell);
    std::sort(candidates.begin(), candidates.end(), stronger);
    for (const Candidate& candidate : candidates) {
      if (cells.filled(cell) >= kCornersPerCell) break;
      if (is_free(candidate.y, candidate.x) == 0) continue;
      cv::circle(is_free, {candidate.x, candidate.y}, min_distance_px, 0, cv::FILLED);
      ++cells.filled(cell);
      corners.emplace_back(static_cast<float>(candidate.x), static_cast<float>(candidate.y));
    }
  }
  return corners;
}

}  // namespace cairn::odometry
