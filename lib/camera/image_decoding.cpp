// SPDX-License-Identifier: Apache-2.0
#include "camera/image_decoding.hpp"

#include <algorithm>
#include <exception>
#include <initializer_list>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "core/atomic_file.hpp"

namespace cairn::camera {
namespace {

constexpr std::size_t kMaxImage_bytes = std::size_t{256} << 20;
constexpr std::size_t kMaxPixels = std::size_t{1} << 27;

std::size_t big_endian(std::span<const std::uint8_t> bytes) {
  std::size_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8 | byte;
  return value;
}

bool starts_with(std::span<const std::uint8_t> bytes, std::initializer_list<std::uint8_t> start) {
  return bytes.size() >= start.size() && std::equal(start.begin(), start.end(), bytes.begin());
}

Result<void> check_pixels(std::size_t width_px, std::size_t height_px) {
  if (width_px * height_px <= kMaxPixels) return {};
  return fail("claims to have " + std::to_string(width_px) + " x " + std::to_string(height_px) +
              " pixels");
}

/// Size and end-of-image marker (ITU-T T.81, annex B): decoders fill what is missing with grey.
Result<void> check_jpeg(std::span<const std::uint8_t> bytes) {
  std::size_t at = 2;
  bool scan = false;
  while (!scan && at + 4 <= bytes.size() && bytes[at] == 0xff) {
    const std::uint8_t marker = bytes[at + 1];
    const bool tables = marker == 0xc4 || marker == 0xc8 || marker == 0xcc;
    if (marker >= 0xc0 && marker <= 0xcf && !tables && at + 9 <= bytes.size()) {
      auto checked =
          check_pixels(big_endian(bytes.subspan(at + 7, 2)), big_endian(bytes.subspan(at + 5, 2)));
      if (!checked) return checked;
    }
    scan = marker == 0xda;
    at += 2 + big_endian(bytes.subspan(at + 2, 2));
  }
  constexpr std::uint8_t kEndOfImage[] = {0xff, 0xd9};
  if (!scan || at >= bytes.size() ||
      std::search(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end(),
                  std::begin(kEndOfImage), std::end(kEndOfImage)) == bytes.end()) {
    return fail("is cut off: the end of the JPEG is missing");
  }
  return {};
}

/// What decoders let pass: a size that would take all memory, a JPEG that ends early.
Result<void> check_header(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return fail("is empty");
  if (bytes.size() > kMaxImage_bytes) return fail("is too large");
  if (starts_with(bytes, {0xff, 0xd8})) return check_jpeg(bytes);
  if (starts_with(bytes, {0x89, 'P', 'N', 'G'}) && bytes.size() >= 24) {
    return check_pixels(big_endian(bytes.subspan(16, 4)), big_endian(bytes.subspan(20, 4)));
  }
  return {};
}

/// As stored: depth and channels are the file's.
Result<cv::Mat> decode(std::span<const std::uint8_t> bytes) {
  if (const auto checked = check_header(bytes); !checked) {
    return tl::make_unexpected(checked.error());
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
