// SPDX-License-Identifier: Apache-2.0
// One of those whom a motor process listens to, as a program of its own, so that a test can freeze
// and kill it: voice clock | drive FORWARD_MPS TURN_RADPS | clearance | flood RATE_HZ.
#include <cstdlib>
#include <random>
#include <string>

#include "bus/node.hpp"
#include "bus/stop_signal.hpp"

namespace {

using namespace cairn;
namespace channels = bus::channels;

constexpr std::int64_t kMs = 1000;

void speak_as_clock(bus::Node& node) {
  node.every_host(20 * kMs, [&node] {
    cairn::clock_t tick{};
    tick.rate = 1;
    node.set_data_time(node.host_time());
    node.publish<channels::Clock>(tick, node.host_time());
  });
}

void speak_as_driver(bus::Node& node, double forward_mps, double turn_radps) {
  node.every_host(100 * kMs, [&node, forward_mps, turn_radps] {
    drive_command_t command{};
    command.source = drive_command_t::SOURCE_PLANNER;
    command.forward_mps = forward_mps;
    command.turn_radps = turn_radps;
    node.publish<channels::DriveCommand>(command, node.data_time());
  });
}

void speak_as_guard(bus::Node& node) {
  node.every_host(50 * kMs, [&node] {
    clearance_t clearance{};
    clearance.max_forward_mps = 0.5;
    clearance.reason = "free";
    clearance.disparity_utime = node.data_time();
    node.publish<channels::Clearance>(clearance, node.data_time());
  });
}

// What motor listens to and refuses, and what it does not listen to. Not CLEARANCE: one that makes
// no sense would stop the robot.
void flood(bus::Node& node, double rate_hz) {
  constexpr std::int64_t kPeriod_us = 2 * kMs;
  node.every_host(kPeriod_us, [&node, rate_hz] {
    for (double left = rate_hz * 1e-6 * kPeriod_us; left > 0; left -= 3) {
      drive_command_t command{};
      command.source = drive_command_t::SOURCE_PLANNER;
      command.forward_mps = 99;
      node.publish<channels::DriveCommand>(command, 0);
      cairn::clock_t tick{};
      tick.rate = -1;
      node.publish<channels::Clock>(tick, node.data_time());
      node.publish<channels::Pose>(pose_t{}, 0);
    }
  });
}

}  // namespace

int main(int argc, char** argv) {
  bus::StopSignal stop;
  const std::string role = argc > 1 ? argv[1] : "";
  const auto opened = bus::open_bus("");
  if (!opened) return EXIT_FAILURE;
  const bus::SteadyClock clock;
  bus::Node node("voice", **opened, clock, {}, std::random_device{}());
  if (role == "clock") speak_as_clock(node);
  if (role == "drive" && argc > 3) speak_as_driver(node, std::atof(argv[2]), std::atof(argv[3]));
  if (role == "clearance") speak_as_guard(node);
  if (role == "flood" && argc > 2) flood(node, std::atof(argv[2]));
  while (!stop.arrived()) node.spin_once(50 * kMs);
  return EXIT_SUCCESS;
}
