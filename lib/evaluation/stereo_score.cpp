// SPDX-License-Identifier: Apache-2.0
#include "evaluation/stereo_score.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"

namespace cairn::evaluation {
namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{1} << 28;
constexpr std::uint64_t kMaxPixels = std::uint64_t{1} << 26;
constexpr std::uint8_t kMaskThreshold = 250;

/// Width times height of a PNG's header; nothing if these bytes do not begin a PNG.
std::optional<std::uint64_t> png_pixels(const std::vector<std::uint8_t>& bytes) {
  constexpr std::array<std::uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (bytes.size() < 24 || !std::equal(kSignature.begin(), kSignature.end(), bytes.begin())) {
    return std::nullopt;
  }
  const auto big_endian = [&](std::size_t at) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = (value << 8) | bytes[at + i];
    return value;
  };
  return big_endian(16) * big_endian(20);
}

Result<cv::Mat> read_png(const std::filesystem::path& file, cv::ImreadModes mode) {
  const auto bytes = read_file(file, kMaxFileBytes);
  if (!bytes) return tl::make_unexpected(bytes.error());
  const auto pixels = png_pixels(*bytes);
  if (!pixels) return fail(file.string() + ": is not a PNG");
  if (*pixels == 0 || *pixels > kMaxPixels) {
    return fail(file.string() + ": " + std::to_string(*pixels) + " pixels");
  }
  cv::Mat image;
  try {
    image = cv::imdecode(*bytes, mode);
  } catch (const cv::Exception& problem) {
    return fail(file.string() + ": cannot be decoded: " + problem.err);
  }
  if (image.empty()) return fail(file.string() + ": cannot be decoded");
  return image;
}

/// One answered pixel with truth.
struct PixelError {
  float error_px;
  float confidence;
};

struct Counts {
  std::size_t truth = 0;
  std::size_t bad1 = 0;
  std::size_t bad2 = 0;
  std::size_t d1 = 0;
  double sum_px = 0;
  double sum_px2 = 0;
  std::vector<PixelError> answered;
};

Counts count_errors(const StereoCase& images) {
  Counts counts;
  for (int row = 0; row < images.truth_px.rows; ++row) {
    for (int col = 0; col < images.truth_px.cols; ++col) {
      const float truth_px = images.truth_px(row, col);
      if (!(truth_px > 0) || (!images.mask.empty() && images.mask(row, col) != 255)) continue;
      ++counts.truth;
      const float answer_px = images.answer_px(row, col);
      if (!(answer_px > 0)) continue;
      const float error_px = std::abs(answer_px - truth_px);
      counts.bad1 += error_px > 1.0F;
      counts.bad2 += error_px > 2.0F;
      counts.d1 += error_px > 3.0F && error_px > 0.05F * truth_px;
      counts.sum_px += error_px;
      counts.sum_px2 += static_cast<double>(error_px) * error_px;
      counts.answered.push_back(
          {error_px, images.confidence.empty() ? 0.0F : images.confidence(row, col)});
    }
  }
  return counts;
}

/// Share of errors over 2 px among the `kept` surest (a count that need not be whole).
double bad2_of_surest(std::vector<PixelError> pixels, double kept) {
  std::sort(pixels.begin(), pixels.end(),
            [](const PixelError& a, const PixelError& b) { return a.confidence > b.confidence; });
  kept = std::min(kept, static_cast<double>(pixels.size()));
  double bad = 0;
  double room = kept;
  for (std::size_t begin = 0; begin < pixels.size() && room > 0;) {
    std::size_t end = begin;
    std::size_t bad_here = 0;
    while (end < pixels.size() && pixels[end].confidence == pixels[begin].confidence) {
      bad_here += pixels[end++].error_px > 2.0F;
    }
    const auto count = static_cast<double>(end - begin);
    const double taken = std::min(count, room);
    bad += static_cast<double>(bad_here) * taken / count;
    room -= taken;
    begin = end;
  }
  return bad / kept;
}

/// The value that a share `quantile` of all lies at or below.
double quantile_px(std::vector<PixelError> pixels, double quantile) {
  const auto rank = static_cast<std::size_t>(
      std::max(1.0, std::ceil(quantile * static_cast<double>(pixels.size()))));
  const auto nth = pixels.begin() + static_cast<std::ptrdiff_t>(rank - 1);
  std::nth_element(pixels.begin(), nth, pixels.end(), [](const PixelError& a, const PixelError& b) {
    return a.error_px < b.error_px;
  });
  return nth->error_px;
}

Result<void> check_case(const StereoCase& images, bool needs_confidence) {
  const cv::Size size = images.truth_px.size();
  const auto of_size = [&](const cv::Mat& image) { return image.empty() || image.size() == size; };
  if (images.truth_px.empty()) return fail("stereo score: there is no truth image");
  if (images.answer_px.size() != size || !of_size(images.mask) || !of_size(images.confidence)) {
    return fail("stereo score: the images are not all of the truth's size, " +
                std::to_string(size.width) + "x" + std::to_string(size.height));
  }
  if (needs_confidence && images.confidence.empty()) {
    return fail("stereo score: bad2_at_density needs a confidence image");
  }
  return {};
}

}  // namespace

Result<cv::Mat_<float>> read_disparity_png(const std::filesystem::path& file) {
  const auto raw = read_png(file, cv::IMREAD_UNCHANGED);
  if (!raw) return tl::make_unexpected(raw.error());
  if (raw->type() != CV_16UC1) return fail(file.string() + ": is not a 16-bit grey image");
  cv::Mat_<float> disparity_px;
  raw->convertTo(disparity_px, CV_32F, 1.0 / 256.0);
  return disparity_px;
}

Result<cv::Mat_<std::uint8_t>> read_mask_png(const std::filesystem::path& file) {
  const auto raw = read_png(file, cv::IMREAD_GRAYSCALE);
  if (!raw) return tl::make_unexpected(raw.error());
  return cv::Mat_<std::uint8_t>(*raw >= kMaskThreshold);
}

Result<StereoScore> score_stereo(const StereoCase& images, std::optional<double> at_density) {
  if (const auto ok = check_case(images, at_density.has_value()); !ok) {
    return tl::make_unexpected(ok.error());
  }
  const Counts counts = count_errors(images);
  if (counts.truth == 0) return fail("stereo score: no pixel in the mask has a true disparity");
  const auto truth = static_cast<double>(counts.truth);
  const auto answered = static_cast<double>(counts.answered.size());
  StereoScore score;
  score.truth_pixels = counts.truth;
  score.answered_pixels = counts.answered.size();
  score.density = answered / truth;
  score.bad2_invalid = (static_cast<double>(counts.bad2) + truth - answered) / truth;
  if (counts.answered.empty()) return score;
  score.bad1 = static_cast<double>(counts.bad1) / answered;
  score.bad2 = static_cast<double>(counts.bad2) / answered;
  score.d1 = static_cast<double>(counts.d1) / answered;
  score.epe_px = counts.sum_px / answered;
  score.rms_px = std::sqrt(counts.sum_px2 / answered);
  score.median_px = quantile_px(counts.answered, 0.5);
  score.p95_px = quantile_px(counts.answered, 0.95);
  if (at_density && *at_density > 0) {
    score.bad2_at_density = bad2_of_surest(counts.answered, *at_density * truth);
  }
  return score;
}

}  // namespace cairn::evaluation
