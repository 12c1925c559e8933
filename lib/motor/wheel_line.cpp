// SPDX-License-Identifier: Apache-2.0
#include "motor/wheel_line.hpp"

#include <algorithm>
#include <cstdlib>

namespace cairn::motor {
namespace {

/// Beyond this a count or a clock is no count and no clock; differences below it cannot overflow.
constexpr std::int64_t kMaxSensible = std::int64_t{1} << 53;

bool sensible(std::int64_t number) { return number >= -kMaxSensible && number <= kMaxSensible; }

bool sensible(const ReportFrame& report) {
  return sensible(report.left_ticks) && sensible(report.right_ticks) && report.device_us >= 0 &&
         report.device_us <= kMaxSensible;
}

}  // namespace

WheelLine::News WheelLine::poll(HostTime now_us) {
  News news;
  if (link_ == nullptr && now_us >= retry_us_) open(now_us);
  if (link_ == nullptr) return news;
  const auto bytes = link_->read();
  if (!bytes) {
    close(now_us, bytes.error().message);
    return news;
  }
  take(*bytes, now_us, news);
  if (now_us - heard_us_ > kSilence_us) {
    connected_ = false;
    trouble_ = what_is_wrong();
  }
  if (!write_error_.empty()) {
    close(now_us, write_error_);
  } else if (now_us - heard_us_ > kPatience_us) {
    close(now_us, trouble_);
  }
  return news;
}

void WheelLine::open(HostTime now_us) {
  auto opened = open_();
  if (!opened) {
    ++counts_.not_opened;
    trouble_ = opened.error().message;
    retry_us_ = now_us + wait_us_;
    wait_us_ = std::min(2 * wait_us_, kLongestWait_us);
    return;
  }
  ++counts_.opened;
  link_ = std::move(*opened);
  write_error_.clear();
  parser_ = FrameParser{};
  counts_at_opening_ = counts_;
  heard_us_ = now_us;
  stop();
}

void WheelLine::close(HostTime now_us, const std::string& why) {
  ++counts_.lost;
  link_.reset();
  connected_ = false;
  last_report_.reset();
  trouble_ = why;
  retry_us_ = now_us + wait_us_;
  wait_us_ = std::min(2 * wait_us_, kLongestWait_us);
}

void WheelLine::take(const std::vector<std::uint8_t>& bytes, HostTime now_us, News& news) {
  counts_.bytes += static_cast<std::int64_t>(bytes.size());
  for (const std::uint8_t byte : bytes) {
    if (parser_.take(byte) == FrameParser::Kind::kReport) take(parser_.report(), now_us, news);
  }
  const LineCounts& before = counts_at_opening_.frames;
  const LineCounts& now = parser_.counts();
  counts_.frames = {before.good + now.good, before.damaged + now.damaged,
                    before.other_version + now.other_version, before.unknown + now.unknown};
}

// A controller that started anew obeys any number; one that goes on obeys those that are higher
// than what its last host, perhaps a former self of this one, has sent.
void WheelLine::take(const ReportFrame& report, HostTime now_us, News& news) {
  const bool known = last_report_ && last_report_->session == report.session;
  if (!sensible(report) || (known && report.device_us <= last_report_->device_us)) {
    ++counts_.senseless;
    return;
  }
  last_report_ = report;
  if (!known) {
    connected_ = false;
    return;
  }
  if (!connected_) {
    news.anew = true;
    news.reports.clear();
  }
  if (!connected_ || static_cast<std::int32_t>(report.last_number - number_) > 0)
    number_ = report.last_number;
  news.reports.push_back(report);
  heard_us_ = now_us;
  connected_ = true;
  trouble_.clear();
  wait_us_ = kFirstWait_us;
}

std::string WheelLine::what_is_wrong() const {
  const Counts& before = counts_at_opening_;
  const LineCounts& frames = parser_.counts();
  if (counts_.bytes == before.bytes) return name_ + ": nothing comes from the wheel controller";
  if (frames.other_version > 0)
    return name_ + ": the wheel controller speaks version " +
           std::to_string(parser_.other_version()) + " of the protocol, and motor version " +
           std::to_string(kProtocolVersion) + "; put the firmware on it that belongs to this motor";
  if (frames.good == 0)
    return name_ + ": what comes is no frame; is it a wheel controller, and is `baud` right?";
  if (counts_.senseless > before.senseless)
    return name_ + ": the wheel controller sends readings that cannot be true";
  return name_ + ": the wheel controller has fallen silent";
}

void WheelLine::drive(double left, double right) {
  if (!connected_) return;
  write(to_wire(DriveFrame{++number_, left, right}));
}

void WheelLine::stop() { write(to_wire(StopFrame{})); }

// A line that takes nothing more is closed with the next poll.
void WheelLine::write(const WireFrame& frame) {
  if (link_ == nullptr) return;
  if (auto written = link_->write(frame.bytes()); !written) write_error_ = written.error().message;
}

}  // namespace cairn::motor
