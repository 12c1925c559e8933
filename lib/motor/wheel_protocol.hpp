// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

/// The frames between the motor process and a wheel controller; procs/motor/README.md has them byte
/// for byte. Neither heap nor exceptions: the controller's firmware runs the same lines.
namespace cairn::motor {

inline constexpr std::uint8_t kProtocolVersion = 1;

/// Host to controller: the share of full drive that each track gets, -1 (full backward) to 1.
struct DriveFrame {
  std::uint32_t number = 0;  ///< rises with every one; the difference counts, so it may wrap
  double left = 0;
  double right = 0;
};

/// Host to controller: no drive, now. Always obeyed.
struct StopFrame {};

/// Bits of ReportFrame::faults.
inline constexpr std::uint8_t kControllerStarved = 1;  ///< no good command for 200 ms: no drive
inline constexpr std::uint8_t kControllerLowBattery = 8;

/// Controller to host, 50 times a second.
struct ReportFrame {
  std::uint32_t session = 0;      ///< random per start of the controller
  std::int64_t device_us = 0;     ///< its clock, when the encoders were read
  std::int64_t left_ticks = 0;    ///< since its start, forward is positive
  std::int64_t right_ticks = 0;   ///< since its start, forward is positive
  double left_duty = 0;           ///< in effect
  double right_duty = 0;          ///< in effect
  std::uint32_t last_number = 0;  ///< of the newest DriveFrame obeyed; 0: none yet
  std::uint8_t faults = 0;        ///< bits kController*
  std::uint16_t firmware = 0;     ///< its version
};

/// Bytes as they go over the line, both delimiters included.
class WireFrame {
 public:
  static constexpr std::size_t kMaxSize = 64;
  [[nodiscard]] std::span<const std::uint8_t> bytes() const { return {bytes_.data(), size_}; }
  void push(std::uint8_t byte) { bytes_[size_++] = byte; }
  std::uint8_t& operator[](std::size_t index) { return bytes_[index]; }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  std::array<std::uint8_t, kMaxSize> bytes_{};
  std::size_t size_ = 0;
};

/// Duties beyond -1 and 1 are brought to them; what is no number is no drive.
[[nodiscard]] WireFrame to_wire(const DriveFrame& frame);
[[nodiscard]] WireFrame to_wire(const StopFrame& frame);
[[nodiscard]] WireFrame to_wire(const ReportFrame& frame);

/// What a FrameParser made of the bytes that it got.
struct LineCounts {
  std::int64_t good = 0;           ///< frames taken
  std::int64_t damaged = 0;        ///< too long, badly stuffed, or with a wrong checksum
  std::int64_t other_version = 0;  ///< whole, but of another version of the protocol
  std::int64_t unknown = 0;        ///< whole, but of no kind or length that we know
};

/// Finds whole frames in a stream of bytes that may begin anywhere and hold any junk: after damage
/// it goes on with the next frame that is whole.
class FrameParser {
 public:
  enum class Kind { kNone, kDrive, kStop, kReport };

  /// Takes one byte; says what it completed, if anything.
  [[nodiscard]] Kind take(std::uint8_t byte);

  /// Of the frame that `take` just said was complete.
  [[nodiscard]] const DriveFrame& drive() const { return drive_; }
  [[nodiscard]] const ReportFrame& report() const { return report_; }
  [[nodiscard]] const LineCounts& counts() const { return counts_; }
  /// Of the last frame that counts as `other_version`.
  [[nodiscard]] int other_version() const { return other_version_; }

 private:
  [[nodiscard]] Kind take_frame();
  [[nodiscard]] bool unstuff();
  [[nodiscard]] Kind read_body(std::span<const std::uint8_t> body);

  std::array<std::uint8_t, WireFrame::kMaxSize> bytes_{};
  std::size_t size_ = 0;
  bool too_long_ = false;
  DriveFrame drive_;
  ReportFrame report_;
  LineCounts counts_;
  std::uint8_t other_version_ = 0;
};

}  // namespace cairn::motor
