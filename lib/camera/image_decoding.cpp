// SPDX-License-Identifier: Apache-2.0
#include "camera/image_decoding.hpp"

#include <algorithm>
#include <exception>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/atomic_file.hpp"

namespace cairn::camera {
namespace {

constexpr std::size_t kMaxImage_bytes = std::size_t{256} << 20;

/// Whether a JPEG reaches its end-of-image marker (ITU-T T.81, annex B). Decoders fill what is
/// missing with grey.
bool jpeg_is_whole(std::span<const std::uint8_t> bytes) {
  constexpr std::uint8_t kStartOfScan = 0xda;
  std::size_t at = 2;
  while (at + 4 <= bytes.size() && bytes[at] == 0xff) {
    const bool scan = bytes[at + 1] == kStartOfScan;
    at += 2 + std::size_t{bytes[at + 2]} * 256 + bytes[at + 3];
    if (scan) break;
  }
  if (at >= bytes.size()) return false;
  constexpr std::uint8_t kEndOfImage[] = {0xff, 0xd9};
  const auto scan = bytes.subspan(at);
  return std::search(scan.begin(), scan.end(), std::begin(kEndOfImage), std::end(kEndOfImage)) !=
         scan.end();
}

/// As stored: depth and channels are the file's.
Result<cv::Mat> decode(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return fail("is empty");
  if (bytes.size() > kMaxImage_bytes) return fail("is too large");
  if (bytes.size() > 2 && bytes[0] == 0xff && bytes[1] == 0xd8 && !jpeg_is_whole(bytes)) {
    return fail("is cut off: the end of the JPEG is missing");
  }
  try {
    const cv::Mat encoded(1, static_cast<int>(bytes.size()), CV_8UC1,
                          const_cast<std::uint8_t*>(bytes.data()));
    cv::Mat image = cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
    if (image.empty()) return fail("is not a whole image");
    return image;
  } catch (const std::exception& problem) {
    return fail(std::string("is not an image: ") + problem.what());
  }
}

Result<cv::Mat> as_grey(const cv::Mat& image) {
  if (image.depth() != CV_8U) {
    return fail("has " + std::to_string(8 * image.elemSize1()) +
                " bits a channel; a camera image needs 8 (is it a depth image?)");
  }
  cv::Mat grey;
  switch (image.channels()) {
    case 1:
      return image;
    case 3:
      cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
      return grey;
    case 4:
      cv::cvtColor(image, grey, cv::COLOR_BGRA2GRAY);
      return grey;
    default:
      return fail("has " + std::to_string(image.channels()) + " channels");
  }
}

Result<cv::Mat> read_image(const std::filesystem::path& file) {
  const auto bytes = read_file(file, kMaxImage_bytes);
  if (!bytes) return tl::make_unexpected(bytes.error());
  auto image = decode(*bytes);
  if (!image) return fail(file.string() + ": " + image.error().message);
  return image;
}

}  // namespace

Result<cv::Mat> decode_grey(std::span<const std::uint8_t> bytes) {
  return decode(bytes).and_then(as_grey);
}

Result<cv::Mat> read_grey_image(const std::filesystem::path& file) {
  const auto image = read_image(file);
  if (!image) return image;
  auto grey = as_grey(*image);
  if (!grey) return fail(file.string() + ": " + grey.error().message);
  return grey;
}

Result<cv::Mat> read_depth_image(const std::filesystem::path& file, double scale_m,
                                 const std::vector<int>& invalid) {
  const auto image = read_image(file);
  if (!image) return image;
  if (image->type() != CV_16UC1) {
    return fail(file.string() + ": a depth image needs one channel of 16 bits, this has " +
                std::to_string(image->channels()) + " of " +
                std::to_string(8 * image->elemSize1()));
  }
  cv::Mat depth_m(image->size(), CV_32FC1);
  for (int y = 0; y < image->rows; ++y) {
    const auto* values = image->ptr<std::uint16_t>(y);
    auto* row_m = depth_m.ptr<float>(y);
    for (int x = 0; x < image->cols; ++x) {
      const bool valid = std::find(invalid.begin(), invalid.end(), int{values[x]}) == invalid.end();
      row_m[x] = valid ? static_cast<float>(values[x] * scale_m) : 0.0F;
    }
  }
  return depth_m;
}

}  // namespace cairn::camera
