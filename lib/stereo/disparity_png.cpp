// SPDX-License-Identifier: Apache-2.0
#include "stereo/disparity_png.hpp"

#include <algorithm>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "core/atomic_file.hpp"

namespace cairn::stereo {
namespace {

constexpr int k256thsPer16th = 16;
constexpr int kMax16ths = 65535 / k256thsPer16th;
constexpr std::size_t kMaxFileBytes = std::size_t{1} << 28;
constexpr std::uint8_t kFullConfidence = 3;
constexpr std::size_t kHeaderBytes = 24;
constexpr std::uint32_t kMaxSide_px = 1 << 14;

std::uint32_t big_endian_32(const std::uint8_t* bytes) {
  return std::uint32_t{bytes[0]} << 24 | std::uint32_t{bytes[1]} << 16 |
         std::uint32_t{bytes[2]} << 8 | std::uint32_t{bytes[3]};
}

/// Looks at the header first, so that a forged size does not make the decoder ask for memory.
bool has_sane_header(const std::vector<std::uint8_t>& bytes) {
  constexpr std::uint8_t kSignature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (bytes.size() < kHeaderBytes) return false;
  if (!std::equal(std::begin(kSignature), std::end(kSignature), bytes.begin())) return false;
  const std::uint32_t width = big_endian_32(&bytes[16]);
  const std::uint32_t height = big_endian_32(&bytes[20]);
  return width >= 1 && width <= kMaxSide_px && height >= 1 && height <= kMaxSide_px;
}

Result<cv::Mat_<std::uint16_t>> read_256ths(const std::filesystem::path& path) {
  const auto bytes = read_file(path, kMaxFileBytes);
  if (!bytes) return tl::make_unexpected(bytes.error());
  if (!has_sane_header(*bytes)) return fail(path.string() + ": not a PNG of a usable size");
  try {
    const cv::Mat image = cv::imdecode(*bytes, cv::IMREAD_UNCHANGED);
    if (image.empty()) return fail(path.string() + ": a damaged PNG");
    if (image.type() != CV_16UC1) return fail(path.string() + ": not a 16-bit grey PNG");
    return cv::Mat_<std::uint16_t>(image);
  } catch (const cv::Exception& exception) {
    return fail(path.string() + ": " + exception.what());
  }
}

}  // namespace

Result<void> write_disparity_png(const std::filesystem::path& path, const DisparityImage& image) {
  if (image.disparity_16ths.empty()) return fail(path.string() + ": no disparities to write");
  cv::Mat_<std::uint16_t> png(image.disparity_16ths.size());
  for (int row = 0; row < png.rows; ++row) {
    for (int col = 0; col < png.cols; ++col) {
      const int disparity = image.disparity_16ths(row, col);
      if (disparity > kMax16ths) {
        return fail(path.string() + ": a disparity of " + std::to_string(disparity / 16) +
                    " px does not fit; the format ends below 256");
      }
      png(row, col) = static_cast<std::uint16_t>(disparity * k256thsPer16th);
    }
  }
  try {
    std::vector<std::uint8_t> bytes;
    if (!cv::imencode(".png", png, bytes)) return fail(path.string() + ": cannot encode");
    return write_file_atomically(path, bytes);
  } catch (const cv::Exception& exception) {
    return fail(path.string() + ": " + exception.what());
  }
}

Result<DisparityImage> read_disparity_png(const std::filesystem::path& path,
                                          const RectifiedCamera& camera, int step_px) {
  if (step_px < 1) return fail("step_px: must be at least 1, is " + std::to_string(step_px));
  const auto png = read_256ths(path);
  if (!png) return tl::make_unexpected(png.error());
  const cv::Size expected{(camera.width_px + step_px - 1) / step_px,
                          (camera.height_px + step_px - 1) / step_px};
  if (png->size() != expected) {
    return fail(path.string() + ": " + std::to_string(png->cols) + "x" + std::to_string(png->rows) +
                " px, expected " + std::to_string(expected.width) + "x" +
                std::to_string(expected.height));
  }
  DisparityImage image;
  image.step_px = step_px;
  image.camera = camera;
  image.disparity_16ths = cv::Mat_<std::uint16_t>::zeros(expected);
  image.code = cv::Mat_<std::uint8_t>(expected, static_cast<std::uint8_t>(Reason::kNoData));
  for (int row = 0; row < png->rows; ++row) {
    for (int col = 0; col < png->cols; ++col) {
      const int value = (*png)(row, col);
      if (value == 0) continue;
      const int rounded = std::max(1, (value + k256thsPer16th / 2) / k256thsPer16th);
      image.disparity_16ths(row, col) = static_cast<std::uint16_t>(rounded);
      image.code(row, col) = kFullConfidence;
    }
  }
  return image;
}

Result<cv::Mat_<float>> read_disparity_png_px(const std::filesystem::path& path) {
  const auto png = read_256ths(path);
  if (!png) return tl::make_unexpected(png.error());
  cv::Mat_<float> disparity_px;
  png->convertTo(disparity_px, CV_32F, 1.0 / 256.0);
  return disparity_px;
}

}  // namespace cairn::stereo
