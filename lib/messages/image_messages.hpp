// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/stereo_frame_t.hpp>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>

#include "camera/frame_source.hpp"
#include "core/result.hpp"

namespace cairn::messages {

/// Largest image side that goes over the bus [px].
inline constexpr int kMaxImageSide_px = 4096;

/// The two grey images of one capture, CV_8UC1, of equal size.
struct StereoImages {
  cv::Mat left;
  cv::Mat right;
};

enum class ImageEncoding { kRaw, kJpeg };

/// Turns captures into STEREO_FRAME messages of at most `budget_bytes` each, all bytes of the
/// message counted.
///
/// JPEG: starts from the quality of the frame before and goes down until both images fit; a frame
/// that stays under 90 % of the budget raises the quality of the next one by one. What it gives
/// depends on nothing but the sequence of frames and the quality that it starts with.
class FrameEncoder {
 public:
  static constexpr int kDefaultBudget_bytes = 115'000;
  static constexpr int kMinQuality = 20;
  static constexpr int kMaxQuality = 95;
  static constexpr int kStartQuality = 80;

  explicit FrameEncoder(ImageEncoding encoding = ImageEncoding::kJpeg,
                        int budget_bytes = kDefaultBudget_bytes);
  ~FrameEncoder();
  FrameEncoder(FrameEncoder&&) noexcept;
  FrameEncoder& operator=(FrameEncoder&&) noexcept;

  /// JPEG quality that the next frame starts with: what a restarted process sets again.
  [[nodiscard]] int quality() const { return quality_; }
  void set_quality(int quality);

  /// Refuses images that are not CV_8UC1, differ in size or are larger than kMaxImageSide_px, and a
  /// frame that does not fit the budget: raw as it is, JPEG at kMinQuality.
  [[nodiscard]] Result<stereo_frame_t> encode(const camera::Frame& frame,
                                              std::uint64_t calibration_id);

 private:
  struct Compressor;

  [[nodiscard]] Result<void> encode_raw(const camera::Frame& frame, stereo_frame_t& message) const;
  [[nodiscard]] Result<void> encode_jpeg(const camera::Frame& frame, stereo_frame_t& message);

  ImageEncoding encoding_;
  int budget_bytes_;
  int quality_ = kStartQuality;
  std::unique_ptr<Compressor> compressor_;
};

/// Refuses sizes out of range or not those of the bytes, an unknown encoding, and JPEGs that are
/// damaged (every warning of the decoder counts), not grey, or of another size than stated.
[[nodiscard]] Result<StereoImages> to_images(const stereo_frame_t& message);

}  // namespace cairn::messages
