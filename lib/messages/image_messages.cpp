// SPDX-License-Identifier: Apache-2.0
#include "messages/image_messages.hpp"

#include <turbojpeg.h>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

namespace cairn::messages {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::string size_text(const cv::Mat& image) {
  return std::to_string(image.cols) + "x" + std::to_string(image.rows);
}

bool size_in_range(int width_px, int height_px) {
  return width_px > 0 && height_px > 0 && width_px <= kMaxImageSide_px &&
         height_px <= kMaxImageSide_px;
}

Result<void> check_images(const cv::Mat& left, const cv::Mat& right) {
  if (left.type() != CV_8UC1 || right.type() != CV_8UC1) {
    return fail("STEREO_FRAME: images must be grey, one byte a pixel");
  }
  if (left.size() != right.size()) {
    return fail("STEREO_FRAME: left image is " + size_text(left) + ", right " + size_text(right));
  }
  if (!size_in_range(left.cols, left.rows)) {
    return fail("STEREO_FRAME: image size " + size_text(left) + " is out of range");
  }
  return {};
}

Bytes raw_bytes(const cv::Mat& image) {
  Bytes bytes;
  bytes.reserve(image.total());
  for (int row = 0; row < image.rows; ++row) {
    const std::uint8_t* begin = image.ptr(row);
    bytes.insert(bytes.end(), begin, begin + image.cols);
  }
  return bytes;
}

void set_images(stereo_frame_t& message, Bytes left, Bytes right) {
  message.left_size = static_cast<std::int32_t>(left.size());
  message.right_size = static_cast<std::int32_t>(right.size());
  message.left = std::move(left);
  message.right = std::move(right);
}

/// Large steps while far over the budget, so that few attempts are enough.
int quality_step_down(int size_bytes, int budget_bytes) {
  const double excess = static_cast<double>(size_bytes) / budget_bytes;
  if (excess > 1.5) return 15;
  if (excess > 1.2) return 6;
  return excess > 1.08 ? 3 : 1;
}

struct CloseTurboJpeg {
  void operator()(void* handle) const { tjDestroy(handle); }
};
using TurboJpeg = std::unique_ptr<void, CloseTurboJpeg>;

Result<cv::Mat> decode_jpeg(void* decoder, const Bytes& jpeg, const stereo_frame_t& message,
                            const std::string& name) {
  const auto size_bytes = static_cast<unsigned long>(jpeg.size());
  int width_px = 0;
  int height_px = 0;
  int subsampling = 0;
  int colour_space = 0;
  if (tjDecompressHeader3(decoder, jpeg.data(), size_bytes, &width_px, &height_px, &subsampling,
                          &colour_space) != 0) {
    return fail("STEREO_FRAME " + name + ": " + tjGetErrorStr2(decoder));
  }
  if (colour_space != TJCS_GRAY) return fail("STEREO_FRAME " + name + ": JPEG is not grey");
  if (width_px != message.width_px || height_px != message.height_px) {
    return fail("STEREO_FRAME " + name + ": JPEG is " + std::to_string(width_px) + "x" +
                std::to_string(height_px) + ", message says " + std::to_string(message.width_px) +
                "x" + std::to_string(message.height_px));
  }
  cv::Mat image(height_px, width_px, CV_8UC1);
  if (tjDecompress2(decoder, jpeg.data(), size_bytes, image.data, width_px,
                    static_cast<int>(image.step), height_px, TJPF_GRAY,
                    TJFLAG_ACCURATEDCT | TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) != 0) {
    return fail("STEREO_FRAME " + name + ": " + tjGetErrorStr2(decoder));
  }
  return image;
}

Result<cv::Mat> copy_raw(const Bytes& bytes, const stereo_frame_t& message,
                         const std::string& name) {
  const auto expected =
      static_cast<std::size_t>(message.width_px) * static_cast<std::size_t>(message.height_px);
  if (bytes.size() != expected) {
    return fail("STEREO_FRAME " + name + ": " + std::to_string(bytes.size()) +
                " bytes, the stated size needs " + std::to_string(expected));
  }
  cv::Mat image(message.height_px, message.width_px, CV_8UC1);
  std::copy(bytes.begin(), bytes.end(), image.data);
  return image;
}

Result<StereoImages> pair(Result<cv::Mat> left, Result<cv::Mat> right) {
  if (!left) return fail(left.error().message);
  if (!right) return fail(right.error().message);
  return StereoImages{std::move(*left), std::move(*right)};
}

}  // namespace

struct FrameEncoder::Compressor {
  TurboJpeg handle{tjInitCompress()};
  Bytes buffer;

  Result<Bytes> compress(const cv::Mat& image, int quality) {
    buffer.resize(tjBufSize(image.cols, image.rows, TJSAMP_GRAY));
    unsigned char* out = buffer.data();
    auto size_bytes = static_cast<unsigned long>(buffer.size());
    if (tjCompress2(handle.get(), image.data, image.cols, static_cast<int>(image.step), image.rows,
                    TJPF_GRAY, &out, &size_bytes, TJSAMP_GRAY, quality,
                    TJFLAG_ACCURATEDCT | TJFLAG_NOREALLOC) != 0) {
      return fail(std::string("STEREO_FRAME: JPEG: ") + tjGetErrorStr2(handle.get()));
    }
    return Bytes(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(size_bytes));
  }
};

FrameEncoder::FrameEncoder(ImageEncoding encoding, int budget_bytes)
    : encoding_(encoding),
      budget_bytes_(budget_bytes),
      compressor_(std::make_unique<Compressor>()) {}
FrameEncoder::~FrameEncoder() = default;
FrameEncoder::FrameEncoder(FrameEncoder&&) noexcept = default;
FrameEncoder& FrameEncoder::operator=(FrameEncoder&&) noexcept = default;

void FrameEncoder::set_quality(int quality) {
  quality_ = std::clamp(quality, kMinQuality, kMaxQuality);
}

Result<stereo_frame_t> FrameEncoder::encode(const camera::Frame& frame,
                                            std::uint64_t calibration_id) {
  if (const auto sound = check_images(frame.left, frame.right); !sound) {
    return fail(sound.error().message);
  }
  stereo_frame_t message{};
  message.header.utime = frame.utime;
  message.frame_index = frame.index;
  message.calibration_id = static_cast<std::int64_t>(calibration_id);
  message.width_px = frame.left.cols;
  message.height_px = frame.left.rows;
  message.exposure_us = frame.exposure_us;
  const auto encoded =
      encoding_ == ImageEncoding::kRaw ? encode_raw(frame, message) : encode_jpeg(frame, message);
  if (!encoded) return fail(encoded.error().message);
  return message;
}

Result<void> FrameEncoder::encode_raw(const camera::Frame& frame, stereo_frame_t& message) const {
  message.encoding = stereo_frame_t::ENCODING_RAW;
  set_images(message, raw_bytes(frame.left), raw_bytes(frame.right));
  if (message.getEncodedSize() <= budget_bytes_) return {};
  return fail("STEREO_FRAME: two raw images of " + size_text(frame.left) + " need " +
              std::to_string(message.getEncodedSize()) + " bytes, the budget is " +
              std::to_string(budget_bytes_) + "; send JPEG, smaller images, or raise the budget");
}

Result<void> FrameEncoder::encode_jpeg(const camera::Frame& frame, stereo_frame_t& message) {
  message.encoding = stereo_frame_t::ENCODING_JPEG;
  for (int quality = quality_;;) {
    auto left = compressor_->compress(frame.left, quality);
    if (!left) return fail(left.error().message);
    auto right = compressor_->compress(frame.right, quality);
    if (!right) return fail(right.error().message);
    set_images(message, std::move(*left), std::move(*right));
    message.jpeg_quality = static_cast<std::int8_t>(quality);

    const int size_bytes = message.getEncodedSize();
    if (size_bytes <= budget_bytes_) {
      const bool well_under = size_bytes < budget_bytes_ / 10 * 9;
      set_quality(well_under ? quality + 1 : quality);
      return {};
    }
    if (quality == kMinQuality) {
      return fail("STEREO_FRAME: two images of " + size_text(frame.left) + " need " +
                  std::to_string(size_bytes) + " bytes at the lowest JPEG quality (" +
                  std::to_string(kMinQuality) + "), the budget is " +
                  std::to_string(budget_bytes_) +
                  "; send smaller images or raise the budget (cairn doctor checks what the "
                  "network buffers carry)");
    }
    quality = std::max(kMinQuality, quality - quality_step_down(size_bytes, budget_bytes_));
  }
}

Result<StereoImages> to_images(const stereo_frame_t& message) {
  if (!size_in_range(message.width_px, message.height_px)) {
    return fail("STEREO_FRAME: image size " + std::to_string(message.width_px) + "x" +
                std::to_string(message.height_px) + " is out of range");
  }
  if (message.encoding == stereo_frame_t::ENCODING_RAW) {
    return pair(copy_raw(message.left, message, "left"), copy_raw(message.right, message, "right"));
  }
  if (message.encoding != stereo_frame_t::ENCODING_JPEG) {
    return fail("STEREO_FRAME encoding: " + std::to_string(message.encoding) + " is unknown");
  }
  const TurboJpeg decoder(tjInitDecompress());
  return pair(decode_jpeg(decoder.get(), message.left, message, "left"),
              decode_jpeg(decoder.get(), message.right, message, "right"));
}

}  // namespace cairn::messages
