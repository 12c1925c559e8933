// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/stop_robot.hpp"

#include <pwd.h>
#include <unistd.h>

#include <iostream>
#include <memory>
#include <optional>
#include <random>

#include "bus/node.hpp"
#include "procs/cli/command.hpp"

namespace cairn::cli {
namespace {

namespace channels = bus::channels;

constexpr std::int64_t kPeriod_us = 50'000;
constexpr std::int64_t kPatience_us = 2 * kMicrosecondsPerSecond;

/// Tells motor the same thing at 20 Hz until it is so.
class StopTalk {
 public:
  StopTalk(bus::Bus& bus, std::int8_t action)
      : bus_{bus}, action_{action}, who_{person_at_the_terminal()}, began_us_{clock_.now_us()} {
    say();
  }

  /// Listens, too; until the gate is latched or not, as `latched` says.
  [[nodiscard]] Result<void> until(bool latched) {
    bus::Node node("cli", bus_, clock_, {}, session_);
    node.on<channels::WheelState>([&](const wheel_state_t& wheels) {
      if (wheels.header.sent_steady_us >= began_us_) heard_ = wheels;
    });
    node.on<channels::ProcessStatus>([&](const process_status_t& status) {
      if (status.process == "motor") motors_reason_ = status.reason;
    });
    if (!node.wiring()) return node.wiring();
    node.every_host(kPeriod_us, [&] { say(); });
    const auto is_so = [&] {
      return heard_ && (heard_->gate == wheel_state_t::GATE_LATCHED) == latched;
    };
    while (!is_so() && clock_.now_us() - began_us_ < kPatience_us) node.spin_once(kPeriod_us);
    if (is_so()) return {};
    if (!heard_) return fail("motor is not heard; is the group up (./cairn ps), on this bus?");
    return fail("motor is heard and " +
                std::string(latched ? "is not latched" : "is still latched") +
                (motors_reason_.empty() ? "" : ": " + motors_reason_));
  }

  [[nodiscard]] std::string took() const {
    return std::to_string((clock_.now_us() - began_us_ + 500) / 1000) + " ms";
  }

 private:
  // Goes out before this program has so much as subscribed.
  void say() {
    stop_t message{};
    message.header.sent_steady_us = clock_.now_us();
    message.header.session = session_;
    message.header.sequence = sequence_++;
    message.action = action_;
    message.person = 1;
    message.who = who_;
    const auto bytes = bus::encode(message);
    if (!bytes) return;
    if (auto sent = bus_.publish(channels::Stop::name, *bytes); !sent)
      std::cerr << sent.error().message << "\n";
  }

  bus::SteadyClock clock_;
  bus::Bus& bus_;
  std::int8_t action_;
  std::string who_;
  std::int64_t session_ = std::random_device{}();
  std::int32_t sequence_ = 0;
  HostTime began_us_;
  std::optional<wheel_state_t> heard_;
  std::string motors_reason_;
};

}  // namespace

std::string person_at_the_terminal() {
  const passwd* user = ::getpwuid(::getuid());
  return (user != nullptr ? std::string(user->pw_name) : "somebody") + " at the terminal";
}

int stop_robot(const std::string& lcm_url) {
  const auto bus = bus::open_bus(lcm_url);
  if (!bus) return failed("not stopped: " + bus.error().message);
  StopTalk talk(**bus, stop_t::ACTION_STOP);
  if (auto done = talk.until(true); !done)
    return failed("not known to be stopped: " + done.error().message +
                  "; if it moves, switch the motors off");
  std::cout << "stopped: latched after " << talk.took()
            << ", over every restart; ./cairn release ends it\n";
  return 0;
}

int release_robot(const std::string& lcm_url) {
  const auto bus = bus::open_bus(lcm_url);
  if (!bus) return failed("not released: " + bus.error().message);
  StopTalk talk(**bus, stop_t::ACTION_RELEASE);
  if (auto done = talk.until(false); !done) return failed("not released: " + done.error().message);
  std::cout << "released; it moves by what it is told from now on\n";
  return 0;
}

void add_release(CLI::App& app, Run& run) {
  auto lcm_url = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("release", "end a STOP: the robot may move again");
  command->add_option("--lcm-url", *lcm_url, "bus of the robot");
  command->footer("Example:\n  cairn release");
  command->callback([&run, lcm_url] { run = [lcm_url] { return release_robot(*lcm_url); }; });
}

}  // namespace cairn::cli
