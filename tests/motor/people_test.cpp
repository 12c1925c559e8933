// SPDX-License-Identifier: Apache-2.0
// What people type: the CLI's words about the wheels, with the real motor program behind them.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "motor_group.hpp"

namespace cairn::testing {
namespace {

using nlohmann::json;

struct Outcome {
  int exit_code = -1;
  std::string printed;
};

class PeopleAtTheTerminal : public MotorGroup {
 protected:
  /// A word of the CLI, while this goes on listening.
  Outcome type(const std::string& words) {
    const std::string name = "cli-" + std::to_string(++words_);
    std::vector<std::string> command{CAIRN_BINARY_DIR "/bin/cairn-cli"};
    for (std::size_t at = 0; at < words.size();) {
      const std::size_t end = std::min(words.find(' ', at), words.size());
      command.push_back(words.substr(at, end - at));
      at = end + 1;
    }
    start(name, command);
    EXPECT_TRUE(until([&] { return children_.at(name).exit_code().has_value(); }));
    return {children_.at(name).exit_code().value_or(-1), output(name)};
  }
  int words_ = 0;
};

TEST_F(PeopleAtTheTerminal, HazardM26_StopIsZeroWithin100MsOfItsSendingAndARealReleaseEndsIt) {
  start_all();
  Distribution whole("cairn stop, from its start");
  Distribution said("cairn stop, by what it says");
  for (int trial = 0; trial < trial_count(); ++trial) {
    Outcome stopped;
    measure(whole, [&] { stopped = type("stop"); });
    if (HasFatalFailure()) return;
    EXPECT_EQ(stopped.exit_code, 0) << stopped.printed;
    int took_ms = -1;
    ASSERT_EQ(std::sscanf(stopped.printed.c_str(), "stopped: latched after %d ms", &took_ms), 1)
        << stopped.printed;
    said.add(took_ms * kMs);
    EXPECT_EQ(wheels_->gate, wheel_state_t::GATE_LATCHED);
    const Outcome released = type("release");
    EXPECT_EQ(released.exit_code, 0) << released.printed;
  }
  said.print();
  judge(whole, 1000);
}

TEST_F(PeopleAtTheTerminal, StopAndReleaseFailClearlyWhereNobodyAnswers) {
  for (const std::string word : {"stop", "release"}) {
    const HostTime from_us = clock_.now_us();
    const Outcome outcome = type(word);
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.printed.find("motor is not heard"), std::string::npos) << outcome.printed;
    EXPECT_GE(clock_.now_us() - from_us, 2 * kMicrosecondsPerSecond);
  }
}

TEST_F(PeopleAtTheTerminal, AStopWorksWithoutAWheelController) {
  start_motor();
  EXPECT_EQ(type("stop").exit_code, 0);
  EXPECT_TRUE(motor::LatchFile(latch_).load().latched);
  EXPECT_EQ(type("release").exit_code, 0);
  EXPECT_FALSE(motor::LatchFile(latch_).load().latched);
}

TEST_F(PeopleAtTheTerminal, TuneFindsTheTracksAndMovesNothingUnasked) {
  bench_.emplace(device_);
  const std::string tune = "motor tune --set device=" + device_.string() +
                           " --set latch_file=" + latch_.string() + " --json";
  const Outcome unasked = type(tune);
  EXPECT_EQ(unasked.exit_code, 1);
  EXPECT_NE(unasked.printed.find("--yes-the-tracks-are-off-the-ground"), std::string::npos);
  EXPECT_EQ(bench_->last_driven_us(), 0);
  const std::string asked = tune + " --yes-the-tracks-are-off-the-ground";
  ASSERT_TRUE(motor::LatchFile(latch_).save({true, "test"}));
  EXPECT_NE(type(asked).printed.find("latched: STOP by test"), std::string::npos);
  EXPECT_EQ(bench_->last_driven_us(), 0);
  ASSERT_TRUE(motor::LatchFile(latch_).save({false, "test"}));
  const Outcome tuned = type(asked);
  const HostTime ended_us = clock_.now_us();
  ASSERT_EQ(tuned.exit_code, 0) << tuned.printed;
  const json found = json::parse(tuned.printed);
  EXPECT_NEAR(found["left"]["full_duty_mps"].get<double>(), 0.8, 0.04);
  EXPECT_NEAR(found["right"]["full_duty_mps"].get<double>(), 0.8, 0.04);
  EXPECT_NEAR(found["left"]["response_s"].get<double>(), 0.16, 0.04);
  // Its own last word stops the tracks, not the controller's watchdog 200 ms later.
  EXPECT_TRUE(until([this] { return !bench_->driven(); }));
  EXPECT_LE(bench_->last_driven_us(), ended_us + 100'000);
}

TEST_F(PeopleAtTheTerminal, TuneDoesNotTakeTheWheelsFromARunningMotor) {
  start_all();
  ASSERT_TRUE(until([this] { return moves(); }));
  const Outcome outcome =
      type("motor tune --set device=" + device_.string() + " --set latch_file=" + latch_.string() +
           " --yes-the-tracks-are-off-the-ground");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.printed.find("is in use by another program"), std::string::npos)
      << outcome.printed;
  EXPECT_TRUE(moves());
}

/// cairn drive on a terminal, and somebody at its keys.
class Keyboard {
 public:
  Keyboard() {
    winsize size{24, 120, 0, 0};
    pid_ = ::forkpty(&keys_, nullptr, nullptr, &size);
    if (pid_ == 0) {
      ::execl(CAIRN_BINARY_DIR "/bin/cairn-cli", "cairn-cli", "drive", "--forward", "0.3",
              static_cast<char*>(nullptr));
      ::_exit(127);
    }
    ::fcntl(keys_, F_SETFL, O_NONBLOCK);
  }
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;
  ~Keyboard() {
    ::kill(pid_, SIGKILL);
    if (!ended_) ::waitpid(pid_, nullptr, 0);
    ::close(keys_);
  }
  void press(const std::string& key) { (void)!::write(keys_, key.data(), key.size()); }
  const std::string& seen() {
    std::array<char, 4096> bytes{};
    for (ssize_t got = 0; (got = ::read(keys_, bytes.data(), bytes.size())) > 0;)
      seen_.append(bytes.data(), static_cast<std::size_t>(got));
    return seen_;
  }
  bool ended(int& exit_code) {
    (void)seen();
    int status = 0;
    if (ended_ || ::waitpid(pid_, &status, WNOHANG) != pid_) return ended_;
    exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    return ended_ = true;
  }

 private:
  int keys_ = -1;
  pid_t pid_ = 0;
  bool ended_ = false;
  std::string seen_;
};

TEST_F(PeopleAtTheTerminal, HazardM27_AKeyLetGoIsZeroWithin400MsAndSpaceStopsAndQQuits) {
  bench_.emplace(device_);
  start_voice("clock", {"clock"});
  start_voice("guard", {"clearance"});
  start_motor();
  Keyboard keyboard;
  ASSERT_TRUE(until([&] { return keyboard.seen().find("driving") != std::string::npos; }))
      << keyboard.seen();
  const auto hold = [&](const std::string& key) {
    HostTime pressed_us = 0;
    return until([&] {
      if (clock_.now_us() - pressed_us > 30 * kMs) {
        keyboard.press(key);
        pressed_us = clock_.now_us();
      }
      return moves();
    });
  };
  Distribution times("a key let go");
  for (int trial = 0; trial < trial_count(); ++trial) {
    ASSERT_TRUE(hold(trial % 2 == 0 ? "w" : "\x1b[A")) << keyboard.seen();
    const HostTime from_us = clock_.now_us();
    listen_for(1000 * kMs);
    EXPECT_FALSE(bench_->driven());
    times.add(bench_->last_driven_us() - from_us);
  }
  // The track brakes from 0.3 m/s at 3 m/s^2, and is driven against while it does.
  judge(times, 800);
  ASSERT_TRUE(hold("w"));
  const HostTime stopped_us = clock_.now_us();
  keyboard.press(" ");
  ASSERT_TRUE(until([&] { return latched_since(stopped_us); }));
  EXPECT_LE(bench_->last_driven_us() - stopped_us, 100 * kMs);
  keyboard.press("q");
  int exit_code = -1;
  ASSERT_TRUE(until([&] { return keyboard.ended(exit_code); }));
  EXPECT_EQ(exit_code, 0) << keyboard.seen();
}

}  // namespace
}  // namespace cairn::testing
