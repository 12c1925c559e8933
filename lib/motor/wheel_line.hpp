// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/time.hpp"
#include "motor/byte_link.hpp"
#include "motor/wheel_protocol.hpp"

namespace cairn::motor {

/// The host's end of the line to a wheel controller. Opens it; where nothing good comes over it,
/// says what is wrong, closes it, and opens it anew after waits that double. Host time is passed
/// in.
class WheelLine {
 public:
  static constexpr std::int64_t kSilence_us = 150'000;     ///< without a report: no controller
  static constexpr std::int64_t kPatience_us = 1'000'000;  ///< so long before a line is reopened
  static constexpr std::int64_t kFirstWait_us = 50'000;
  static constexpr std::int64_t kLongestWait_us = 1'000'000;

  struct Counts {
    std::int64_t opened = 0;
    std::int64_t not_opened = 0;
    std::int64_t lost = 0;       ///< closed again, for whatever reason
    std::int64_t senseless = 0;  ///< whole reports that cannot be true
    std::int64_t bytes = 0;      ///< that came
    LineCounts frames;
  };

  struct News {
    bool anew = false;  ///< the reports are the first of a controller that was not there before
    std::vector<ReportFrame> reports;  ///< all of one start of it; its clock rises
  };

  /// `name` is what people know the line by.
  WheelLine(std::string name, OpenLine open) : name_{std::move(name)}, open_{std::move(open)} {}

  /// Takes in what has come. To be called every few milliseconds.
  [[nodiscard]] News poll(HostTime now_us);

  /// A controller is there: two reports of one start of it have come, the last one not over
  /// kSilence_us ago.
  [[nodiscard]] bool connected() const { return connected_; }

  /// What keeps it from being there, in words that stay the same while it does; empty while it is.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }

  /// Sends it, with the next number, if a controller is there.
  void drive(double left, double right);

  /// Sends a stop, whether or not anybody is known to be there.
  void stop();

  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  void open(HostTime now_us);
  void close(HostTime now_us, const std::string& why);
  void take(const std::vector<std::uint8_t>& bytes, HostTime now_us, News& news);
  void take(const ReportFrame& report, HostTime now_us, News& news);
  void write(const WireFrame& frame);
  [[nodiscard]] std::string what_is_wrong() const;

  std::string name_;
  OpenLine open_;
  std::unique_ptr<ByteLink> link_;
  std::string write_error_;
  FrameParser parser_;
  Counts counts_;
  Counts counts_at_opening_;
  std::string trouble_ = "not opened yet";
  bool connected_ = false;
  std::optional<ReportFrame> last_report_;  ///< since the opening
  HostTime heard_us_ = 0;                   ///< the last report, or the opening
  HostTime retry_us_ = 0;
  std::int64_t wait_us_ = kFirstWait_us;
  std::uint32_t number_ = 0;
};

}  // namespace cairn::motor
