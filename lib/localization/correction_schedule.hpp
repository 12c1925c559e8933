// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "core/geometry.hpp"
#include "core/time.hpp"
#include "localization/odometry_chain.hpp"
#include "localization/pose_belief.hpp"

namespace cairn::localization {

/// How sure the robot is of where it is. Values are what goes over the bus.
enum class Certainty : std::uint8_t {
  kLost = 0,       ///< no idea
  kAmbiguous = 1,  ///< several places look alike
  kTracking = 2,   ///< sure
};

/// What a frame's view of the map says about the pose.
struct Correction {
  Utime utime = 0;  ///< of the frame
  PoseBelief pose;  ///< at that frame
  Certainty certainty = Certainty::kTracking;
};

/// Which correction is in use at which frame: that of frame k from frame k + 2 on, however early it
/// was there (DESIGN rule 4), or as soon as it is there, if that is later.
class CorrectionSchedule {
 public:
  static constexpr std::size_t kEffectFrames = 2;

  /// The next frame, in order: moves what is known of the pose, and lets take effect what is due.
  void move(Utime utime, const Motion& motion);

  /// False if the frame at which this should have taken effect has passed already.
  bool put(const Correction& correction);

  /// Begins anew with this in use, from the last frame on.
  void start(const Correction& correction);

  [[nodiscard]] const Correction& in_use() const { return in_use_; }
  /// The pose at the last frame by the correction in use and the motion since.
  [[nodiscard]] const PoseBelief& pose() const { return pose_; }

 private:
  static constexpr std::size_t kFramesKept = 256;
  struct Frame {
    Utime utime = 0;
    Motion motion;  ///< since the frame before
  };

  void use(const Correction& correction);

  std::deque<Frame> frames_;
  std::deque<Correction> waiting_;
  Correction in_use_;
  PoseBelief pose_;
};

}  // namespace cairn::localization
