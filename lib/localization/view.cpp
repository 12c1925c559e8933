// SPDX-License-Identifier: Apache-2.0
#include "localization/view.hpp"

#include <algorithm>
#include <cmath>

#include "stereo/depth_noise.hpp"

namespace cairn::localization {
namespace {

constexpr int kTries = 6;
/// A surface's disparity changes evenly from pixel to pixel; by more than this it is an edge.
constexpr int kMostUneven_16ths = 24;

/// SplitMix64 (Steele, Lea and Flood 2014).
std::uint64_t next_random(std::uint64_t& state) {
  std::uint64_t x = state += 0x9e3779b97f4a7c15ULL;
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ x >> 27) * 0x94d049bb133111ebULL;
  return x ^ x >> 31;
}

/// True if the two neighbours at `-step` and `+step` are there and the three disparities lie on a
/// line.
bool even(const stereo::DisparityImage& image, int row, int col, int down, int right) {
  const int before = image.disparity_16ths(row - down, col - right);
  const int here = image.disparity_16ths(row, col);
  const int after = image.disparity_16ths(row + down, col + right);
  return before != 0 && after != 0 && std::abs(before - 2 * here + after) <= kMostUneven_16ths;
}

}  // namespace

View make_view(const stereo::DisparityImage& image, const ViewConfig& config, std::uint64_t seed) {
  View view;
  view.utime = image.utime;
  view.eye_m = image.camera.T_body_camera.translation();
  if (image.rows() < 3 || image.cols() < 3) return view;
  std::uint64_t random = seed ^ static_cast<std::uint64_t>(image.utime);
  const double side = std::sqrt(static_cast<double>(image.rows()) * image.cols() / config.points);
  const int down = std::max(1, static_cast<int>(std::lround(image.rows() / side)));
  const int across = std::max(1, config.points / down);
  const auto pick = [&random](int from, int to) {
    return from + static_cast<int>(next_random(random) % static_cast<std::uint64_t>(to - from));
  };
  view.beams.reserve(static_cast<std::size_t>(down * across));
  for (int i = 0; i < down; ++i) {
    const int top = 1 + (image.rows() - 2) * i / down;
    const int bottom = std::max(top + 1, 1 + (image.rows() - 2) * (i + 1) / down);
    for (int j = 0; j < across; ++j) {
      const int left = 1 + (image.cols() - 2) * j / across;
      const int right = std::max(left + 1, 1 + (image.cols() - 2) * (j + 1) / across);
      for (int attempt = 0; attempt < kTries; ++attempt) {
        const int row = pick(top, bottom);
        const int col = pick(left, right);
        if (!image.valid(row, col) || image.code(row, col) < config.min_confidence) continue;
        if (!even(image, row, col, 1, 0) || !even(image, row, col, 0, 1)) continue;
        const Eigen::Vector3d in_camera = image.point_camera(row, col);
        const double range_m = in_camera.norm();
        if (!(range_m >= config.min_range_m && range_m <= config.max_range_m)) continue;
        Beam beam;
        beam.point_m = image.camera.T_body_camera * in_camera;
        beam.along = (beam.point_m - view.eye_m) / range_m;
        beam.range_m = range_m;
        beam.sigma_m =
            stereo::depth_sigma_m(image.camera, in_camera.z(), config.disparity_sigma_px) *
            range_m / in_camera.z();
        view.beams.push_back(beam);
        break;
      }
    }
  }
  return view;
}

}  // namespace cairn::localization
