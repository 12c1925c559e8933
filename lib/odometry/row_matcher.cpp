// SPDX-License-Identifier: Apache-2.0
#include "odometry/row_matcher.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace cairn::odometry {
namespace {

constexpr int kHalf = 5;
constexpr int kSide = 2 * kHalf + 1;
constexpr int kArea = kSide * kSide;
constexpr float kMinContrast = 2.0F;  // standard deviation, grey levels
constexpr double kMinScore = 0.8;
constexpr double kRivalMargin = 0.05;
constexpr int kRivalDistance_px = 3;
constexpr int kMaxFitSteps = 10;
constexpr double kFitDone_px = 0.003;
constexpr double kMaxFitShift_px = 1.0;
constexpr double kMaxRoundTrip_px = 0.5;
constexpr int kRoundTripReach_px = 8;

/// kSide rows of `width` bilinear samples; the first is at (x, y), the step is 1 px.
class Strip {
 public:
  explicit Strip(int width) : width_{width}, samples_(static_cast<std::size_t>(width * kSide)) {}

  /// False if a sample would lie outside the image.
  bool sample(const cv::Mat& image, double x, double y) {
    const int x0 = static_cast<int>(std::floor(x));
    const int y0 = static_cast<int>(std::floor(y));
    if (x0 < 0 || y0 < 0 || x0 + width_ + 1 > image.cols || y0 + kSide + 1 > image.rows) {
      return false;
    }
    const auto fx = static_cast<float>(x - x0);
    const auto fy = static_cast<float>(y - y0);
    const float w00 = (1 - fx) * (1 - fy);
    const float w01 = fx * (1 - fy);
    const float w10 = (1 - fx) * fy;
    const float w11 = fx * fy;
    for (int row = 0; row < kSide; ++row) {
      const std::uint8_t* a = image.ptr<std::uint8_t>(y0 + row) + x0;
      const std::uint8_t* b = image.ptr<std::uint8_t>(y0 + row + 1) + x0;
      float* out = &samples_[static_cast<std::size_t>(row * width_)];
      for (int i = 0; i < width_; ++i) {
        out[i] = w00 * static_cast<float>(a[i]) + w01 * static_cast<float>(a[i + 1]) +
                 w10 * static_cast<float>(b[i]) + w11 * static_cast<float>(b[i + 1]);
      }
    }
    return true;
  }

  [[nodiscard]] const float* row(int r) const {
    return &samples_[static_cast<std::size_t>(r * width_)];
  }
  [[nodiscard]] int width() const { return width_; }

 private:
  int width_;
  std::vector<float> samples_;
};

/// A window less its mean, and what is left of it as a standard deviation.
struct Template {
  std::array<float, kArea> value;
  float contrast = 0;
};

Template normalise(const Strip& window, int first_col) {
  Template result;
  float sum = 0;
  for (int r = 0; r < kSide; ++r) {
    for (int c = 0; c < kSide; ++c) {
      const float value = window.row(r)[first_col + c];
      result.value[static_cast<std::size_t>(r * kSide + c)] = value;
      sum += value;
    }
  }
  const float mean = sum / kArea;
  float squares = 0;
  for (float& value : result.value) {
    value -= mean;
    squares += value * value;
  }
  result.contrast = std::sqrt(squares / kArea);
  return result;
}

/// Correlation of the template with each window of the strip, left to right.
std::vector<float> correlations(const Template& pattern, const Strip& strip) {
  const int count = strip.width() - kSide + 1;
  std::vector<float> product(static_cast<std::size_t>(count), 0.0F);
  std::vector<float> column_sum(static_cast<std::size_t>(strip.width()), 0.0F);
  std::vector<float> column_squares(column_sum.size(), 0.0F);
  for (int r = 0; r < kSide; ++r) {
    const float* row = strip.row(r);
    for (int i = 0; i < strip.width(); ++i) {
      column_sum[static_cast<std::size_t>(i)] += row[i];
      column_squares[static_cast<std::size_t>(i)] += row[i] * row[i];
    }
    for (int c = 0; c < kSide; ++c) {
      const float weight = pattern.value[static_cast<std::size_t>(r * kSide + c)];
      for (int i = 0; i < count; ++i) product[static_cast<std::size_t>(i)] += weight * row[i + c];
    }
  }
  for (std::size_t i = 0; i < product.size(); ++i) {
    float sum = 0;
    float squares = 0;
    for (std::size_t c = 0; c < kSide; ++c) {
      sum += column_sum[i + c];
      squares += column_squares[i + c];
    }
    const float variance = squares / kArea - sum * sum / (kArea * kArea);
    const float contrast = std::sqrt(std::max(variance, 0.0F));
    product[i] =
        contrast < kMinContrast ? -1.0F : product[i] / (kArea * contrast * pattern.contrast);
  }
  return product;
}

bool has_rival(const std::vector<float>& scores, std::size_t best) {
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const auto distance = i > best ? i - best : best - i;
    if (distance >= kRivalDistance_px && scores[i] > scores[best] - kRivalMargin) return true;
  }
  return false;
}

double parabola_offset(const std::vector<float>& scores, std::size_t best) {
  if (best == 0 || best + 1 == scores.size()) return 0;
  const double before = static_cast<double>(scores[best - 1]);
  const double after = static_cast<double>(scores[best + 1]);
  const double curvature = before - 2 * static_cast<double>(scores[best]) + after;
  if (curvature >= 0) return 0;
  return std::clamp(0.5 * (before - after) / curvature, -0.5, 0.5);
}

/// Moves x (the window's first column) so that the window of `image` fits the template best.
std::optional<double> fit_column(const Template& pattern, const cv::Mat& image, double x,
                                 double y) {
  const double start = x;
  Strip strip(kSide + 2);
  for (int step = 0; step < kMaxFitSteps; ++step) {
    if (!strip.sample(image, x - 1, y)) return std::nullopt;
    const Template window = normalise(strip, 1);
    if (window.contrast < kMinContrast) return std::nullopt;
    const float gain = pattern.contrast / window.contrast;
    float slope_squares = 0;
    float slope_error = 0;
    float slope_sum = 0;
    for (int r = 0; r < kSide; ++r) {
      for (int c = 0; c < kSide; ++c) {
        const auto i = static_cast<std::size_t>(r * kSide + c);
        const float slope = gain * 0.5F * (strip.row(r)[c + 2] - strip.row(r)[c]);
        slope_squares += slope * slope;
        slope_sum += slope;
        slope_error += slope * (pattern.value[i] - gain * window.value[i]);
      }
    }
    slope_squares -= slope_sum * slope_sum / kArea;
    if (!(slope_squares > 0)) return std::nullopt;
    const double move = static_cast<double>(slope_error / slope_squares);
    x += move;
    if (!(std::abs(x - start) <= kMaxFitShift_px)) return std::nullopt;
    if (std::abs(move) < kFitDone_px) return x;
  }
  return x;
}

struct Found {
  double u_px;
  double score;
};

/// Where the window around (u, v) of `from` lies in `to`, its centre between u_min and u_max.
std::optional<Found> find_on_row(const cv::Mat& from, const cv::Mat& to, double u, double v,
                                 double u_min, double u_max) {
  Strip window(kSide);
  if (!window.sample(from, u - kHalf, v - kHalf)) return std::nullopt;
  const Template pattern = normalise(window, 0);
  if (pattern.contrast < kMinContrast) return std::nullopt;

  const double lowest = kHalf + 1;
  const double highest = to.cols - kHalf - 3;
  const double first = std::max(u_min, lowest);
  const double last = std::min(u_max, highest);
  if (last < first) return std::nullopt;
  const int count = static_cast<int>(std::floor(last - first)) + 1;
  Strip strip(count + kSide - 1);
  if (!strip.sample(to, first - kHalf, v - kHalf)) return std::nullopt;
  const std::vector<float> scores = correlations(pattern, strip);
  const auto best =
      static_cast<std::size_t>(std::max_element(scores.begin(), scores.end()) - scores.begin());
  const double score = static_cast<double>(scores[best]);
  if (score < kMinScore || has_rival(scores, best)) return std::nullopt;

  const double start = first + static_cast<double>(best) + parabola_offset(scores, best);
  const auto fitted = fit_column(pattern, to, start - kHalf, v - kHalf);
  if (!fitted) return std::nullopt;
  return Found{*fitted + kHalf, score};
}

}  // namespace

std::optional<RowMatch> RowMatcher::match(double u_px, double v_px, double min_disparity_px,
                                          double max_disparity_px) const {
  const auto found =
      find_on_row(left_, right_, u_px, v_px, u_px - max_disparity_px, u_px - min_disparity_px);
  if (!found) return std::nullopt;
  return RowMatch{u_px - found->u_px, found->score};
}

std::optional<RowMatch> RowMatcher::match_both_ways(double u_px, double v_px,
                                                    double min_disparity_px,
                                                    double max_disparity_px) const {
  const auto there = match(u_px, v_px, min_disparity_px, max_disparity_px);
  if (!there) return std::nullopt;
  const auto back = find_on_row(right_, left_, u_px - there->disparity_px, v_px,
                                u_px - kRoundTripReach_px, u_px + kRoundTripReach_px);
  if (!back || std::abs(back->u_px - u_px) > kMaxRoundTrip_px) return std::nullopt;
  return there;
}

}  // namespace cairn::odometry
