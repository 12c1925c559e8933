// SPDX-License-Identifier: Apache-2.0
#include "localization/correction_schedule.hpp"

namespace cairn::localization {

void CorrectionSchedule::move(Utime utime, const Motion& motion) {
  if (!frames_.empty() && utime <= frames_.back().utime) {  // data time was set back
    frames_.clear();
    waiting_.clear();
  }
  frames_.push_back({utime, motion});
  if (frames_.size() > kFramesKept) frames_.pop_front();
  pose_ = moved(pose_, motion);
  if (frames_.size() <= kEffectFrames) return;
  const Utime due = frames_[frames_.size() - 1 - kEffectFrames].utime;
  std::optional<Correction> newest;
  while (!waiting_.empty() && waiting_.front().utime <= due) {
    newest = waiting_.front();
    waiting_.pop_front();
  }
  if (newest) use(*newest);
}

bool CorrectionSchedule::put(const Correction& correction) {
  if (!waiting_.empty() && correction.utime <= waiting_.back().utime) return true;
  waiting_.push_back(correction);
  return frames_.size() <= kEffectFrames ||
         frames_[frames_.size() - 1 - kEffectFrames].utime < correction.utime;
}

void CorrectionSchedule::start(const Correction& correction) {
  waiting_.clear();
  use(correction);
}

void CorrectionSchedule::use(const Correction& correction) {
  in_use_ = correction;
  pose_ = correction.pose;
  for (const Frame& frame : frames_) {
    if (frame.utime > correction.utime) pose_ = moved(pose_, frame.motion);
  }
}

}  // namespace cairn::localization
