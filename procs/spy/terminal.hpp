// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "core/result.hpp"
#include "procs/spy/view.hpp"

namespace cairn::spy {

/// The terminal that the program runs on, as a full screen; given back as it was when this ends.
/// One at a time.
class Terminal {
 public:
  /// An error where the terminal's kind is not known.
  [[nodiscard]] static Result<std::unique_ptr<Terminal>> open();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;
  ~Terminal();

  /// Follows the window as it is resized.
  [[nodiscard]] ScreenSize size() const;
  void paint(const std::vector<StyledLine>& lines);
  /// Waits up to `timeout_ms` for a key.
  [[nodiscard]] Key key(int timeout_ms);

 private:
  explicit Terminal(void* screen) : screen_{screen} {}
  void* screen_;
};

}  // namespace cairn::spy
