// SPDX-License-Identifier: Apache-2.0
// A libFuzzer target for what a wheel controller, or whatever is on its line, may send: first bytes
// through the parser, then through all that a motor process makes of them.
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <vector>

#include "motor/memory_link.hpp"
#include "motor/motor_control.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cairn;
  auto [far, near] = motor::make_memory_links();
  motor::MotorControl control({}, {}, motor::WheelLine("fuzzed", motor::open_once(std::move(near))),
                              false, 0);
  HostTime now_us = 0;
  for (std::size_t at = 0; at < size;) {
    now_us += 1 + 1000 * data[at];
    const std::size_t portion = std::min<std::size_t>(size - at, 100);
    if (!far->write({data + at, portion})) return 0;
    at += portion;
    control.clock(now_us, 1, now_us, now_us);
    (void)control.gate().permit({{now_us, 1, static_cast<std::int32_t>(at)}, 0.5, now_us}, now_us);
    (void)control.gate().drive(
        {{now_us, 2, static_cast<std::int32_t>(at)}, motor::Driver::kPlanner, 0, 0.3, 0.1}, now_us);
    for (const motor::WheelReading& reading : control.tick(now_us)) {
      if (!std::isfinite(reading.left_measured_mps) || !std::isfinite(reading.right_measured_mps))
        std::abort();
    }
    motor::FrameParser parser;
    const auto sent = far->read();
    if (!sent) return 0;
    for (const std::uint8_t byte : *sent) (void)parser.take(byte);
    if (parser.counts().damaged + parser.counts().unknown > 0) std::abort();
  }
  return 0;
}
