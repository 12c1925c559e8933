// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/teleop.hpp"

#include <utility>

namespace cairn::cli {
namespace {

constexpr char kEscape = 27;

}  // namespace

void Teleop::type(std::span<const std::uint8_t> bytes, HostTime now_us) {
  for (const std::uint8_t byte : bytes) press(static_cast<char>(byte), now_us);
}

// An arrow key is ESC [ A to D, or ESC O A to D.
void Teleop::press(char key, HostTime now_us) {
  if (key == kEscape) {
    escape_ = key;
  } else if (escape_.size() == 1 && (key == '[' || key == 'O')) {
    escape_ += key;
  } else if (escape_.size() == 2) {
    escape_.clear();
    constexpr const char* kLetters = "wsda";
    if (key >= 'A' && key <= 'D') press_letter(kLetters[key - 'A'], now_us);
  } else {
    escape_.clear();
    press_letter(key, now_us);
  }
}

void Teleop::press_letter(char key, HostTime now_us) {
  switch (key) {
    case 'w':
    case 'W':
    case 's':
    case 'S':
      forward_ = key == 'w' || key == 'W' ? 1 : -1;
      forward_us_ = now_us;
      break;
    case 'a':
    case 'A':
    case 'd':
    case 'D':
      turn_ = key == 'a' || key == 'A' ? 1 : -1;
      turn_us_ = now_us;
      break;
    case ' ':
      stop_ = true;
      [[fallthrough]];
    default:
      forward_ = turn_ = 0;
      quit_ = quit_ || key == 'q' || key == 'Q';
      break;
  }
}

double Teleop::forward_mps(HostTime now_us) const {
  return now_us - forward_us_ < kHold_us ? forward_ * forward_step_mps_ : 0;
}

double Teleop::turn_radps(HostTime now_us) const {
  return now_us - turn_us_ < kHold_us ? turn_ * turn_step_radps_ : 0;
}

bool Teleop::take_stop() { return std::exchange(stop_, false); }

}  // namespace cairn::cli
