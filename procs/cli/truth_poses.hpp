// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bus/node.hpp"
#include "evaluation/trajectory.hpp"

namespace cairn::cli {

/// Stands in for a localizer that is never wrong: answers each DISPARITY with the POSE that the
/// recording's truth has for it. For mapping experiments (`--poses truth`) alone; no robot runs it.
class TruthPoses {
 public:
  TruthPoses(evaluation::Trajectory truth, bus::Node& node);

 private:
  void answer(Utime utime);

  evaluation::Trajectory truth_;
  bus::Node& node_;
};

}  // namespace cairn::cli
