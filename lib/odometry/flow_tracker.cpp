// SPDX-License-Identifier: Apache-2.0
#include "odometry/flow_tracker.hpp"

#include <opencv2/video/tracking.hpp>

namespace cairn::odometry {
namespace {

constexpr int kWindow_px = 15;
constexpr int kLevels = 3;  // besides the full size
constexpr float kMaxRoundTrip_px = 0.5F;

const cv::TermCriteria kUntil{cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 30, 0.01};

std::vector<std::uint8_t> flow(const Pyramid& from, const Pyramid& to,
                               const std::vector<cv::Point2f>& points_px,
                               std::vector<cv::Point2f>& reached_px) {
  std::vector<std::uint8_t> status;
  cv::calcOpticalFlowPyrLK(from, to, points_px, reached_px, status, cv::noArray(),
                           {kWindow_px, kWindow_px}, kLevels, kUntil, cv::OPTFLOW_USE_INITIAL_FLOW);
  return status;
}

}  // namespace

Pyramid make_pyramid(const cv::Mat& image) {
  Pyramid pyramid;
  cv::buildOpticalFlowPyramid(image, pyramid, {kWindow_px, kWindow_px}, kLevels);
  return pyramid;
}

std::vector<FlowPoint> track(const Pyramid& from, const Pyramid& to,
                             const std::vector<cv::Point2f>& points_px,
                             const std::vector<cv::Point2f>& expected_px) {
  std::vector<FlowPoint> result(points_px.size());
  if (points_px.empty()) return result;
  std::vector<cv::Point2f> there = expected_px;
  const auto went = flow(from, to, points_px, there);
  // The way back starts as far from its end as the way there started from its own.
  std::vector<cv::Point2f> back(points_px.size());
  for (std::size_t i = 0; i < back.size(); ++i) back[i] = points_px[i] + there[i] - expected_px[i];
  const auto returned = flow(to, from, there, back);
  for (std::size_t i = 0; i < result.size(); ++i) {
    const cv::Point2f gap = back[i] - points_px[i];
    result[i].at_px = there[i];
    result[i].found =
        went[i] != 0 && returned[i] != 0 && gap.dot(gap) <= kMaxRoundTrip_px * kMaxRoundTrip_px;
  }
  return result;
}

}  // namespace cairn::odometry
