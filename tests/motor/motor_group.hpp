// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "bus/node.hpp"
#include "core/child_process.hpp"
#include "motor/latch_file.hpp"
#include "network_namespace.hpp"
#include "temporary_folder.hpp"
#include "wheel_bench.hpp"

namespace cairn::testing {

namespace channels = bus::channels;
namespace fs = std::filesystem;

inline constexpr std::int64_t kMs = 1000;
inline constexpr std::int64_t kLongest_us = 20 * kMicrosecondsPerSecond;

/// How often a hazard is tried: CAIRN_TRIALS of the environment, else 12.
[[nodiscard]] inline int trial_count() {
  const char* wanted = std::getenv("CAIRN_TRIALS");
  return wanted != nullptr ? std::atoi(wanted) : 12;
}

/// All times of one hazard, the worst of which counts.
class Distribution {
 public:
  explicit Distribution(std::string name) : name_{std::move(name)} {}
  void add(std::int64_t duration_us) { all_ms_.push_back(static_cast<double>(duration_us) / 1e3); }
  [[nodiscard]] double worst_ms() const {
    return *std::max_element(all_ms_.begin(), all_ms_.end());
  }
  void print() {
    std::sort(all_ms_.begin(), all_ms_.end());
    std::printf("%s, %zu times: median %.0f ms, worst %.0f ms; all:", name_.c_str(), all_ms_.size(),
                all_ms_[all_ms_.size() / 2], all_ms_.back());
    for (const double ms : all_ms_) std::printf(" %.0f", ms);
    std::printf("\n");
  }

 private:
  std::string name_;
  std::vector<double> all_ms_;
};

/// The real motor program on a real bus and a pseudo-terminal, in a network namespace of its own,
/// with programs that play the clock, planner and guard.
class MotorGroup : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!enter_network_namespace() || !add_multicast_route()) GTEST_SKIP() << kNoNamespace;
    bus_ = bus::open_bus("").value();
    node_ = std::make_unique<bus::Node>("test", *bus_, clock_, StateFolder{}, 1);
    node_->on<channels::WheelState>([this](const wheel_state_t& heard) {
      wheels_ = heard;
      heard_us_ = clock_.now_us();
    });
    node_->on<channels::ProcessStatus>([this](const process_status_t& heard) {
      if (heard.process == "motor") status_ = heard;
    });
    ASSERT_TRUE(node_->wiring());
  }
  void TearDown() override { children_.clear(); }

  void start(const std::string& name, std::vector<std::string> command) {
    auto child = ChildProcess::start(command, folder_.path() / (name + ".txt"));
    ASSERT_TRUE(child) << child.error().message;
    children_.erase(name);
    children_.emplace(name, std::move(*child));
  }
  void start_motor() {
    start("motor", {CAIRN_BINARY_DIR "/bin/cairn-motor", "--set", "device=" + device_.string(),
                    "--set", "latch_file=" + latch_.string()});
  }
  void start_voice(const std::string& name, std::vector<std::string> words) {
    words.insert(words.begin(), CAIRN_BINARY_DIR "/bin/motor_voice");
    start(name, words);
  }
  void start_all() {
    bench_.emplace(device_);
    start_voice("clock", {"clock"});
    start_voice("planner", {"drive", "0.3", "0.1"});
    start_voice("guard", {"clearance"});
    start_motor();
  }
  void signal(const std::string& name, int number) { children_.at(name).signal(number); }

  /// Listens until it is so; false after a long time without.
  bool until(const std::function<bool()>& so, std::int64_t longest_us = kLongest_us) {
    const HostTime from_us = clock_.now_us();
    while (!so()) {
      if (clock_.now_us() - from_us > longest_us) return false;
      node_->spin_once(kMs);
    }
    return true;
  }
  void listen_for(std::int64_t duration_us) {
    (void)until([] { return false; }, duration_us);
  }
  [[nodiscard]] bool moves() const { return bench_->driven() && bench_->speed_mps() > 0.2; }
  [[nodiscard]] bool latched_since(HostTime from_us) const {
    return wheels_ && heard_us_ > from_us && wheels_->header.sent_steady_us > from_us &&
           wheels_->gate == wheel_state_t::GATE_LATCHED;
  }
  void say(std::int8_t action) {
    stop_t message{};
    message.action = action;
    message.person = 1;
    message.who = "test";
    node_->publish<channels::Stop>(message, 0);
  }
  std::string output(const std::string& name) const {
    std::ifstream stream(folder_.path() / (name + ".txt"));
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  /// Makes the robot drive, lets `happen` happen, and measures until its last drive.
  void measure(Distribution& times, const std::function<void()>& happen) {
    ASSERT_TRUE(until([this] { return moves(); })) << output("motor");
    listen_for(static_cast<std::int64_t>(random_() % 100'000));
    ASSERT_TRUE(bench_->driven());
    const HostTime from_us = clock_.now_us();
    happen();
    listen_for(400 * kMs);
    ASSERT_TRUE(until([this] { return !bench_->driven(); }));
    times.add(std::max<std::int64_t>(0, bench_->last_driven_us() - from_us));
  }
  void judge(Distribution& times, double limit_ms) const {
    times.print();
    std::printf("the bench looked away for at most %.0f ms\n",
                1e-3 * static_cast<double>(bench_->longest_gap_us()));
    EXPECT_LE(times.worst_ms(), limit_ms);
  }

  TemporaryFolder folder_;
  fs::path device_ = folder_.path() / "wheels";
  fs::path latch_ = folder_.path() / "latch";
  bus::SteadyClock clock_;
  std::unique_ptr<bus::Bus> bus_;
  std::unique_ptr<bus::Node> node_;
  std::optional<WheelBench> bench_;
  std::map<std::string, ChildProcess> children_;
  std::optional<wheel_state_t> wheels_;
  HostTime heard_us_ = 0;
  process_status_t status_{};
  std::mt19937 random_{20240229};
};

}  // namespace cairn::testing
