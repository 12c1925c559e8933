// SPDX-License-Identifier: Apache-2.0
#include "procs/simulator/feedback_gate.hpp"

#include <algorithm>

namespace cairn {
namespace {

constexpr std::size_t kFramesToPose = 2;
constexpr std::size_t kFramesToMap = 8;

}  // namespace

FeedbackGate::FeedbackGate(bool waits_for_disparity)
    : streams_{Stream{"DISPARITY", kFramesToPose, waits_for_disparity},
               Stream{"POSE", kFramesToPose}, Stream{"MAP_DELTA", kFramesToMap}} {}

void FeedbackGate::frame_taken(Utime utime) {
  waiting_since_us_.reset();
  taken_.push_front(utime);
  if (taken_.size() > kFramesToMap) taken_.pop_back();
}

void FeedbackGate::hear(Stream& stream, Utime utime) {
  stream.awaited = true;
  stream.newest = std::max(stream.newest, utime);
}

bool FeedbackGate::lacks(const Stream& stream) const {
  return stream.awaited && taken_.size() >= stream.frames_ago &&
         stream.newest < taken_[stream.frames_ago - 1];
}

std::optional<std::string> FeedbackGate::waits_for(HostTime now_us) {
  std::string missing;
  for (const Stream& stream : streams_) {
    if (lacks(stream)) missing += (missing.empty() ? "" : ", ") + std::string(stream.name);
  }
  if (missing.empty()) {
    waiting_since_us_.reset();
    return std::nullopt;
  }
  if (!waiting_since_us_) waiting_since_us_ = now_us;
  if (now_us - *waiting_since_us_ < kPatience_us) return missing;
  for (Stream& stream : streams_) {
    if (lacks(stream)) stream.awaited = false;
  }
  return std::nullopt;
}

}  // namespace cairn
