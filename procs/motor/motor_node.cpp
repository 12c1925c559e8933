// SPDX-License-Identifier: Apache-2.0
#include "procs/motor/motor_node.hpp"

#include <cmath>
#include <utility>

#include "messages/check.hpp"
#include "motor/plain_text.hpp"
#include "motor/serial_link.hpp"

namespace cairn {

namespace channels = bus::channels;

namespace {

constexpr std::int64_t kLookPeriod_us = 100'000;
/// A reason that changes is logged once it has stood for so long.
constexpr std::int64_t kSettled_us = 500'000;
constexpr std::int64_t kSaveAgain_us = kMicrosecondsPerSecond;

motor::SentStamp stamp_of(const header_t& header) {
  return {header.sent_steady_us, header.session, header.sequence};
}

std::int8_t to_message(motor::GateState state) {
  switch (state) {
    case motor::GateState::kDriving:
      return wheel_state_t::GATE_DRIVING;
    case motor::GateState::kLatched:
      return wheel_state_t::GATE_LATCHED;
    default:
      return wheel_state_t::GATE_IDLE;
  }
}

bus::Health health_of(motor::Hold hold) {
  switch (hold) {
    case motor::Hold::kNoController:
    case motor::Hold::kStalled:
      return bus::Health::kIll;
    case motor::Hold::kNoClock:
    case motor::Hold::kNoGuard:
    case motor::Hold::kNoSight:
      return bus::Health::kWaiting;
    default:
      return bus::Health::kOk;
  }
}

}  // namespace

Result<std::unique_ptr<MotorNode>> MotorNode::create(const Config& config, bus::Node& node) {
  return create(
      config, node,
      [device = config.device, baud = config.baud]() -> Result<std::unique_ptr<motor::ByteLink>> {
        return motor::SerialLink::open(device, baud);
      });
}

Result<std::unique_ptr<MotorNode>> MotorNode::create(const Config& config, bus::Node& node,
                                                     motor::OpenLine open) {
  const auto latch_file = motor::LatchFile::locate(config.latch_file);
  if (!latch_file) return tl::make_unexpected(latch_file.error());
  const std::string name = config.device.empty() ? "the line" : config.device;
  return std::unique_ptr<MotorNode>(new MotorNode(
      config, node, motor::WheelLine(name, std::move(open)), motor::LatchFile(*latch_file)));
}

MotorNode::MotorNode(const Config& config, bus::Node& node, motor::WheelLine line,
                     motor::LatchFile file)
    : config_{config},
      node_{node},
      latch_file_{std::move(file)},
      latch_{latch_file_.load()},
      control_{config.robot, config.pid, std::move(line), latch_.latched, node.host_time()} {
  node.on<channels::DriveCommand>([this](const drive_command_t& message) { take(message); });
  node.on<channels::Clearance>([this](const clearance_t& message) { take(message); });
  node.on<channels::Clock>([this](const cairn::clock_t& message) { take(message); });
  node.on<channels::Stop>([this](const stop_t& message) { take(message); });
  node.set_health(bus::Health::kStarting, "looks for its wheel controller");
  node.every_host(motor::MotorControl::kTick_us, [this] { tick(); });
  node.every_host(kLookPeriod_us, [this] { say_how_it_is(); });
}

Result<void> MotorNode::finish() {
  control_.leave();
  return {};
}

// ---- what comes in ----

void MotorNode::take(const drive_command_t& message) {
  if (auto good = messages::check(message); !good) {
    const bool finite = std::isfinite(message.forward_mps) && std::isfinite(message.turn_radps);
    return refuse(channels::DriveCommand::name, "command_",
                  {finite ? "malformed" : "not_finite", good.error().message});
  }
  const bool person = message.source == drive_command_t::SOURCE_PERSON;
  const motor::DriveOrder order{stamp_of(message.header),
                                person ? motor::Driver::kPerson : motor::Driver::kPlanner,
                                message.lease, message.forward_mps, message.turn_radps};
  if (auto taken = control_.gate().drive(order, node_.host_time()); !taken)
    refuse(channels::DriveCommand::name, "command_", taken.error());
}

// A guard that says what makes no sense has no say: what it allowed before is void as well.
void MotorNode::take(const clearance_t& message) {
  const auto good = messages::check(message);
  const motor::ForwardPermission permission{stamp_of(message.header),
                                            good ? message.max_forward_mps : std::nan(""),
                                            message.disparity_utime};
  const auto taken = control_.gate().permit(permission, node_.host_time());
  if (!good)
    return refuse(channels::Clearance::name, "clearance_", {"malformed", good.error().message});
  if (!taken) return refuse(channels::Clearance::name, "clearance_", taken.error());
  guards_reason_ = motor::plain_text(message.reason);
}

void MotorNode::take(const cairn::clock_t& message) {
  if (auto good = messages::check(message); !good)
    return node_.refuse(channels::Clock::name, good.error().message);
  node_.set_data_time(message.header.utime);
  control_.clock(message.header.utime, message.rate, message.header.sent_steady_us,
                 node_.host_time());
}

// STOP is obeyed whatever else is wrong with the message.
void MotorNode::take(const stop_t& message) {
  if (message.action == stop_t::ACTION_STOP) return stop(motor::plain_text(message.who));
  if (auto good = messages::check(message); !good)
    return refuse(channels::Stop::name, "release_", {"malformed", good.error().message});
  release(message);
}

void MotorNode::stop(const std::string& who) {
  const bool was_latched = control_.gate().latched();
  control_.stop(node_.host_time());
  if (was_latched) return;
  latch_ = {true, who};
  save_latch();
  node_.log(bus::Level::kWarning, "STOP by " + who);
}

void MotorNode::release(const stop_t& message) {
  const bool was_latched = control_.gate().latched();
  const auto released =
      control_.gate().release(message.person, stamp_of(message.header), node_.host_time());
  if (!released) return refuse(channels::Stop::name, "release_", released.error());
  if (!was_latched) return;
  latch_ = {false, motor::plain_text(message.who)};
  save_latch();
  node_.log(bus::Level::kWarning, "released by " + latch_.by);
}

void MotorNode::save_latch() {
  latch_tried_us_ = node_.host_time();
  const auto saved = latch_file_.save(latch_);
  latch_saved_ = saved.has_value();
  latch_error_ = saved ? "" : saved.error().message;
  if (saved) return;
  ++node_.counter("latch_not_saved");
  node_.log(bus::Level::kError, latch_error_ +
                                    "; the robot would not stand as it does now after a "
                                    "restart of motor");
}

void MotorNode::refuse(const char* channel, const char* prefix, const motor::Refusal& refusal) {
  ++node_.counter(std::string(prefix) + refusal.kind);
  node_.refuse(channel, refusal.why);
}

// ---- what goes out ----

void MotorNode::tick() {
  for (const motor::WheelReading& reading : control_.tick(node_.host_time())) publish(reading);
}

// Latched is what it says it is once a restart would find it so, too.
void MotorNode::publish(const motor::WheelReading& reading) {
  wheel_state_t message{};
  message.left_ticks = reading.left_ticks;
  message.right_ticks = reading.right_ticks;
  message.ticks_per_m = config_.robot.ticks_per_m;
  message.left_measured_mps = reading.left_measured_mps;
  message.right_measured_mps = reading.right_measured_mps;
  message.left_commanded_mps = reading.left_commanded_mps;
  message.right_commanded_mps = reading.right_commanded_mps;
  message.faults = reading.faults;
  message.gate = to_message(reading.gate);
  if (reading.gate == motor::GateState::kLatched && !latch_saved_)
    message.gate = wheel_state_t::GATE_IDLE;
  node_.publish<channels::WheelState>(std::move(message), reading.utime);
}

void MotorNode::say_how_it_is() {
  if (!latch_saved_ && node_.host_time() - latch_tried_us_ >= kSaveAgain_us) save_latch();
  const std::string why = why_it_stands();
  node_.set_health(latch_saved_ ? health_of(control_.hold()) : bus::Health::kIll, why);
  log_change(control_.hold() == motor::Hold::kNotFree ? "no clearance" : why);
  show_counts();
}

std::string MotorNode::why_it_stands() const {
  switch (control_.hold()) {
    case motor::Hold::kNone:
      return "";
    case motor::Hold::kLatched:
      return "latched: STOP by " + latch_.by + "; a person must release it (cairn release)" +
             (latch_saved_ ? "" : "; not safe over a restart: " + latch_error_);
    case motor::Hold::kNoClock:
      return "no clock: CLOCK stands still";
    case motor::Hold::kNobody:
      return "idle: nobody has told it to move";
    case motor::Hold::kSilent:
      return "idle: the driver is silent";
    case motor::Hold::kNoGuard:
      return "no clearance: guard is silent";
    case motor::Hold::kNoSight:
      return "no clearance: what guard saw is too long ago";
    case motor::Hold::kNotFree:
      return "no clearance: " + guards_reason_;
    case motor::Hold::kNoController:
      return "no wheel controller: " + control_.line().trouble();
    case motor::Hold::kStalled:
      return "stalled: a track was driven and did not move; it rests for a second";
  }
  return "";
}

void MotorNode::log_change(const std::string& why) {
  const HostTime now_us = node_.host_time();
  if (why != seen_why_) {
    seen_why_ = why;
    seen_since_us_ = now_us;
  }
  if (why == logged_why_ || now_us - seen_since_us_ < kSettled_us) return;
  logged_why_ = why;
  node_.log(bus::Level::kInfo, why.empty() ? "drives" : "holds still: " + why);
}

void MotorNode::show_counts() {
  const motor::WheelLine::Counts& counts = control_.line().counts();
  node_.counter("line_opened") = counts.opened;
  node_.counter("line_not_opened") = counts.not_opened;
  node_.counter("line_lost") = counts.lost;
  node_.counter("frames_good") = counts.frames.good;
  node_.counter("frames_damaged") = counts.frames.damaged;
  node_.counter("frames_of_other_version") = counts.frames.other_version;
  node_.counter("frames_unknown") = counts.frames.unknown;
  node_.counter("reports_senseless") = counts.senseless;
}

}  // namespace cairn
