// SPDX-License-Identifier: Apache-2.0
#include "motor/wheel_protocol.hpp"

#include <type_traits>

namespace cairn::motor {
namespace {

constexpr std::uint8_t kDriveKind = 0x01;
constexpr std::uint8_t kStopKind = 0x02;
constexpr std::uint8_t kReportKind = 0x81;
constexpr std::size_t kHeadSize = 2;
constexpr std::size_t kCrcSize = 4;
constexpr std::size_t kDrivePayload = 8;
constexpr std::size_t kStopPayload = 0;
constexpr std::size_t kReportPayload = 39;
constexpr double kFullDuty = 32767;

static_assert(kHeadSize + kReportPayload + kCrcSize + 3 <= WireFrame::kMaxSize);

// CRC-32 of IEEE 802.3: reflected polynomial 0xEDB88320, start and final XOR all ones.
std::uint32_t crc32(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

std::int16_t to_fixed(double duty) {
  if (!(duty == duty)) return 0;
  if (duty <= -1) return static_cast<std::int16_t>(-kFullDuty);
  if (duty >= 1) return static_cast<std::int16_t>(kFullDuty);
  return static_cast<std::int16_t>(duty * kFullDuty + (duty < 0 ? -0.5 : 0.5));
}

double from_fixed(std::int16_t fixed) {
  const double duty = fixed / kFullDuty;
  return duty < -1 ? -1 : duty;
}

/// A frame's content before stuffing; numbers go low byte first.
class Body {
 public:
  explicit Body(std::uint8_t kind) {
    put(kProtocolVersion);
    put(kind);
  }

  template <class Number>
  Body& put(Number number) {
    auto bits = static_cast<std::make_unsigned_t<Number>>(number);
    for (std::size_t i = 0; i < sizeof(Number); ++i) {
      bytes_[size_++] = static_cast<std::uint8_t>(bits & 0xFFU);
      if constexpr (sizeof(Number) > 1) bits = static_cast<std::make_unsigned_t<Number>>(bits >> 8);
    }
    return *this;
  }

  // Consistent overhead byte stuffing (Cheshire and Baker 1999), with a zero before and after.
  [[nodiscard]] WireFrame finish() {
    put(crc32({bytes_.data(), size_}));
    WireFrame frame;
    frame.push(0);
    std::size_t code_at = frame.size();
    std::uint8_t code = 1;
    frame.push(code);
    for (std::size_t i = 0; i < size_; ++i) {
      if (bytes_[i] != 0) {
        frame.push(bytes_[i]);
        ++code;
      } else {
        frame[code_at] = code;
        code_at = frame.size();
        code = 1;
        frame.push(code);
      }
    }
    frame[code_at] = code;
    frame.push(0);
    return frame;
  }

 private:
  std::array<std::uint8_t, WireFrame::kMaxSize> bytes_{};
  std::size_t size_ = 0;
};

/// Takes numbers off the front of bytes that are known to be enough.
class Payload {
 public:
  explicit Payload(std::span<const std::uint8_t> bytes) : bytes_{bytes} {}

  template <class Number>
  [[nodiscard]] Number take() {
    std::make_unsigned_t<Number> bits = 0;
    for (std::size_t i = sizeof(Number); i-- > 0;) {
      if constexpr (sizeof(Number) > 1) bits = static_cast<std::make_unsigned_t<Number>>(bits << 8);
      bits = static_cast<std::make_unsigned_t<Number>>(bits | bytes_[i]);
    }
    bytes_ = bytes_.subspan(sizeof(Number));
    return static_cast<Number>(bits);
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

DriveFrame read_drive(Payload payload) {
  DriveFrame frame;
  frame.number = payload.take<std::uint32_t>();
  frame.left = from_fixed(payload.take<std::int16_t>());
  frame.right = from_fixed(payload.take<std::int16_t>());
  return frame;
}

ReportFrame read_report(Payload payload) {
  ReportFrame frame;
  frame.session = payload.take<std::uint32_t>();
  frame.device_us = payload.take<std::int64_t>();
  frame.left_ticks = payload.take<std::int64_t>();
  frame.right_ticks = payload.take<std::int64_t>();
  frame.left_duty = from_fixed(payload.take<std::int16_t>());
  frame.right_duty = from_fixed(payload.take<std::int16_t>());
  frame.last_number = payload.take<std::uint32_t>();
  frame.faults = payload.take<std::uint8_t>();
  frame.firmware = payload.take<std::uint16_t>();
  return frame;
}

}  // namespace

WireFrame to_wire(const DriveFrame& frame) {
  return Body(kDriveKind)
      .put(frame.number)
      .put(to_fixed(frame.left))
      .put(to_fixed(frame.right))
      .finish();
}

WireFrame to_wire(const StopFrame&) { return Body(kStopKind).finish(); }

WireFrame to_wire(const ReportFrame& frame) {
  return Body(kReportKind)
      .put(frame.session)
      .put(frame.device_us)
      .put(frame.left_ticks)
      .put(frame.right_ticks)
      .put(to_fixed(frame.left_duty))
      .put(to_fixed(frame.right_duty))
      .put(frame.last_number)
      .put(frame.faults)
      .put(frame.firmware)
      .finish();
}

FrameParser::Kind FrameParser::take(std::uint8_t byte) {
  if (byte == 0) {
    const Kind kind = size_ == 0 ? Kind::kNone : take_frame();
    size_ = 0;
    too_long_ = false;
    return kind;
  }
  if (size_ < bytes_.size()) {
    bytes_[size_++] = byte;
  } else {
    too_long_ = true;
  }
  return Kind::kNone;
}

FrameParser::Kind FrameParser::take_frame() {
  if (too_long_ || !unstuff() || size_ < kHeadSize + kCrcSize) {
    ++counts_.damaged;
    return Kind::kNone;
  }
  const std::span<const std::uint8_t> body{bytes_.data(), size_ - kCrcSize};
  Payload crc{{bytes_.data() + body.size(), kCrcSize}};
  if (crc.take<std::uint32_t>() != crc32(body)) {
    ++counts_.damaged;
    return Kind::kNone;
  }
  const Kind kind = read_body(body);
  if (kind != Kind::kNone) ++counts_.good;
  return kind;
}

// In place: what comes out is never longer than what went in.
bool FrameParser::unstuff() {
  std::size_t out = 0;
  for (std::size_t in = 0; in < size_;) {
    const std::size_t end = in + bytes_[in];
    if (end > size_) return false;
    for (++in; in < end; ++in) bytes_[out++] = bytes_[in];
    if (in < size_) bytes_[out++] = 0;
  }
  size_ = out;
  return true;
}

FrameParser::Kind FrameParser::read_body(std::span<const std::uint8_t> body) {
  if (body[0] != kProtocolVersion) {
    ++counts_.other_version;
    other_version_ = body[0];
    return Kind::kNone;
  }
  const std::span<const std::uint8_t> payload = body.subspan(kHeadSize);
  if (body[1] == kDriveKind && payload.size() == kDrivePayload) {
    drive_ = read_drive(Payload{payload});
    return Kind::kDrive;
  }
  if (body[1] == kStopKind && payload.size() == kStopPayload) return Kind::kStop;
  if (body[1] == kReportKind && payload.size() == kReportPayload) {
    report_ = read_report(Payload{payload});
    return Kind::kReport;
  }
  ++counts_.unknown;
  return Kind::kNone;
}

}  // namespace cairn::motor
