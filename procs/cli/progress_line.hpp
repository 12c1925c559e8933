// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "core/time.hpp"

namespace cairn::cli {

/// Shows people how far a long run is, on standard error: on a terminal one line that is written
/// over, elsewhere a line every 10 s of host time.
class ProgressLine {
 public:
  ProgressLine();
  /// A line that is left over goes.
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  /// Whether `show` would show anything now; saves making the text.
  [[nodiscard]] bool due(HostTime now_us) const;
  void show(const std::string& text, HostTime now_us);

 private:
  bool terminal_;
  HostTime next_us_ = 0;
};

}  // namespace cairn::cli
