// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/time.hpp"

namespace cairn::cli {

/// What the keys of a terminal say: arrows or WASD drive for as long as they are held, the space
/// bar stops, q quits. A terminal tells of a held key by repeating it: a way that no key has named
/// for kHold_us is let go of. Host time is passed in.
class Teleop {
 public:
  static constexpr std::int64_t kHold_us = 300'000;

  Teleop(double forward_mps, double turn_radps)
      : forward_step_mps_{forward_mps}, turn_step_radps_{turn_radps} {}

  /// Bytes as the terminal sends them; a key's may come in several portions.
  void type(std::span<const std::uint8_t> bytes, HostTime now_us);

  [[nodiscard]] double forward_mps(HostTime now_us) const;
  [[nodiscard]] double turn_radps(HostTime now_us) const;
  /// The space bar was pressed since the last call.
  [[nodiscard]] bool take_stop();
  [[nodiscard]] bool quit() const { return quit_; }

 private:
  void press(char key, HostTime now_us);
  void press_letter(char key, HostTime now_us);

  double forward_step_mps_;
  double turn_step_radps_;
  std::string escape_;  ///< the beginning of an arrow key
  int forward_ = 0;
  int turn_ = 0;
  HostTime forward_us_ = 0;
  HostTime turn_us_ = 0;
  bool stop_ = false;
  bool quit_ = false;
};

}  // namespace cairn::cli
