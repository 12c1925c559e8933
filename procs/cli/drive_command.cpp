// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>
#include <random>

#include "bus/node.hpp"
#include "bus/stop_signal.hpp"
#include "procs/cli/command.hpp"
#include "procs/cli/stop_robot.hpp"
#include "procs/cli/teleop.hpp"

namespace cairn::cli {
namespace {

namespace channels = bus::channels;

constexpr std::int64_t kCommandPeriod_us = 100'000;
constexpr std::int64_t kStopPeriod_us = 50'000;
constexpr std::int64_t kLook_us = 10'000;
constexpr std::int64_t kHeard_us = 500'000;

struct Options {
  double forward_mps = 0.2;
  double turn_radps = 0.6;
  std::string lcm_url;
};

/// The terminal that we run on, key by key; given back as it was.
class KeyTerminal {
 public:
  [[nodiscard]] static std::optional<std::unique_ptr<KeyTerminal>> open() {
    termios before{};
    if (::isatty(STDIN_FILENO) == 0 || ::tcgetattr(STDIN_FILENO, &before) != 0) return std::nullopt;
    return std::unique_ptr<KeyTerminal>(new KeyTerminal(before));
  }
  KeyTerminal(const KeyTerminal&) = delete;
  KeyTerminal& operator=(const KeyTerminal&) = delete;
  ~KeyTerminal() { ::tcsetattr(STDIN_FILENO, TCSANOW, &before_); }

  /// What was typed since the last call; false: the terminal is gone.
  [[nodiscard]] bool read(Teleop& teleop, HostTime now_us) const {
    std::array<std::uint8_t, 256> bytes{};
    int waiting = 0;
    if (::ioctl(STDIN_FILENO, FIONREAD, &waiting) != 0) return false;
    if (waiting <= 0) return true;
    const ssize_t got = ::read(STDIN_FILENO, bytes.data(), bytes.size());
    if (got <= 0) return got < 0 && errno == EINTR;
    teleop.type({bytes.data(), static_cast<std::size_t>(got)}, now_us);
    return true;
  }

 private:
  explicit KeyTerminal(const termios& before) : before_{before} {
    termios by_key = before;
    by_key.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
    by_key.c_cc[VMIN] = 0;
    by_key.c_cc[VTIME] = 0;
    ::tcsetattr(STDIN_FILENO, TCSANOW, &by_key);
  }
  termios before_;
};

/// Sends a person's orders at 10 Hz, and at once when they change.
class Driving {
 public:
  Driving(const Options& options, bus::Bus& bus)
      : bus_{bus}, teleop_{options.forward_mps, options.turn_radps} {
    std::random_device random;
    lease_ = 1 + static_cast<std::int64_t>(random() >> 1);
    node_.emplace("drive", bus_, clock_, StateFolder{}, random());
    node_->on<channels::WheelState>([this](const wheel_state_t& heard) {
      wheels_ = heard;
      heard_us_ = clock_.now_us();
    });
    node_->on<channels::ProcessStatus>([this](const process_status_t& status) {
      if (status.process == "motor") motors_reason_ = status.reason;
    });
    node_->every_host(kCommandPeriod_us, [this] {
      command();
      show();
    });
    node_->every_host(kStopPeriod_us, [this] { stop_until_latched(); });
  }

  int run(bus::StopSignal& signal, const KeyTerminal& terminal) {
    if (!node_->wiring()) return failed(node_->wiring().error().message);
    while (!signal.arrived() && terminal.read(teleop_, clock_.now_us()) && !teleop_.quit()) {
      if (teleop_.take_stop()) {
        stopping_ = true;
        stop_us_ = clock_.now_us();
        stop_until_latched();
      }
      if (teleop_.forward_mps(clock_.now_us()) != forward_mps_ ||
          teleop_.turn_radps(clock_.now_us()) != turn_radps_)
        command();
      node_->spin_once(kLook_us);
    }
    send(0, 0);
    std::cout << "\n";
    return 0;
  }

 private:
  void command() {
    send(teleop_.forward_mps(clock_.now_us()), teleop_.turn_radps(clock_.now_us()));
  }

  void send(double forward_mps, double turn_radps) {
    forward_mps_ = forward_mps;
    turn_radps_ = turn_radps;
    drive_command_t message{};
    message.source = drive_command_t::SOURCE_PERSON;
    message.lease = lease_;
    message.forward_mps = forward_mps;
    message.turn_radps = turn_radps;
    node_->publish<channels::DriveCommand>(message, node_->data_time());
  }

  void stop_until_latched() {
    if (!stopping_) return;
    stopping_ = !(wheels_ && wheels_->header.sent_steady_us > stop_us_ &&
                  wheels_->gate == wheel_state_t::GATE_LATCHED);
    if (!stopping_) return;
    stop_t message{};
    message.action = stop_t::ACTION_STOP;
    message.person = 1;
    message.who = person_at_the_terminal();
    node_->publish<channels::Stop>(message, node_->data_time());
  }

  void show() const {
    std::array<char, 160> line{};
    if (!wheels_ || clock_.now_us() - heard_us_ > kHeard_us) {
      std::snprintf(line.data(), line.size(), "motor is not heard");
    } else {
      const char* gate = wheels_->gate == wheel_state_t::GATE_LATCHED   ? "LATCHED (cairn release)"
                         : wheels_->gate == wheel_state_t::GATE_DRIVING ? "driving"
                                                                        : "idle";
      std::snprintf(line.data(), line.size(),
                    "told %+.2f m/s %+.2f rad/s  tracks %+.2f %+.2f  %s  %.60s", forward_mps_,
                    turn_radps_, wheels_->left_measured_mps, wheels_->right_measured_mps, gate,
                    motors_reason_.c_str());
    }
    std::cout << "\r\033[K" << line.data() << std::flush;
  }

  bus::Bus& bus_;
  bus::SteadyClock clock_;
  Teleop teleop_;
  std::int64_t lease_ = 0;
  std::optional<bus::Node> node_;
  std::optional<wheel_state_t> wheels_;
  HostTime heard_us_ = 0;
  std::string motors_reason_;
  double forward_mps_ = 0;
  double turn_radps_ = 0;
  bool stopping_ = false;
  HostTime stop_us_ = 0;
};

int drive(const Options& options) {
  bus::StopSignal signal;
  const auto terminal = KeyTerminal::open();
  if (!terminal) return failed("drive: needs a terminal to read keys from");
  const auto bus = bus::open_bus(options.lcm_url);
  if (!bus) return failed(bus.error().message);
  std::cout << "Hold the arrows or W A S D to drive; space: STOP; q: quit. It stops "
            << Teleop::kHold_us / 1000
            << " ms after a key is let go,\nand waits so long for a key's first repetition. While "
               "this runs, the planner does not drive.\n";
  return Driving(options, **bus).run(signal, **terminal);
}

}  // namespace

void add_drive(CLI::App& app, Run& run) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("drive", "drive by the keys of this terminal");
  command->add_option("--forward", options->forward_mps, "speed [m/s]")
      ->check(CLI::Range(0.01, 5.0))
      ->capture_default_str();
  command->add_option("--turn", options->turn_radps, "turning speed [rad/s]")
      ->check(CLI::Range(0.01, 10.0))
      ->capture_default_str();
  command->add_option("--lcm-url", options->lcm_url, "bus of the robot");
  command->footer("Example:\n  cairn drive --forward 0.15");
  command->callback([&run, options] { run = [options] { return drive(*options); }; });
}

}  // namespace cairn::cli
