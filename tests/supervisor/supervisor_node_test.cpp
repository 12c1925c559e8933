// SPDX-License-Identifier: Apache-2.0
// H-SUP-2: what comes over the bus is refused where it makes no sense. No process is started here.
#include "procs/supervisor/supervisor_node.hpp"

#include <gtest/gtest.h>

#include <random>

#include "bus/codec.hpp"
#include "bus/in_process_bus.hpp"
#include "temporary_folder.hpp"

namespace cairn {
namespace {

namespace channels = bus::channels;

class SupervisorOnABus : public ::testing::Test {
 protected:
  SupervisorOnABus() {
    clock_.set(1'000'000'000);
    GroupConfig group;
    group.group = "test";
    for (const char* name : {"stereo", "mapper"}) {
      group.processes.emplace_back();
      group.processes.back().name = name;
      group.processes.back().at_start = false;
    }
    supervisor_ =
        std::make_unique<SupervisorNode>(group, folder_.path(), StateFolder{}, std::nullopt, node_);
    person_.on<channels::GroupState>([this](const group_state_t& state) { state_ = state; });
    person_.on<channels::ProcessStatus>([this](const process_status_t& status) {
      if (status.process == "supervisor") status_ = status;
    });
    go_on(3'000'000);
  }

  void go_on(std::int64_t duration_us) {
    for (std::int64_t done_us = 0; done_us <= duration_us; done_us += 20'000) {
      clock_.set(clock_.now_us() + 20'000);
      spin();
    }
  }
  void spin() {
    for (int i = 0; i < 4; ++i) {
      hub_.deliver();
      node_.spin_once(0);
      person_.spin_once(0);
    }
  }
  std::int64_t refused() { return node_.counts().at("GROUP_COMMAND").refused; }
  std::string last_refusal() { return node_.counts().at("GROUP_COMMAND").last_refusal; }

  void tell(std::int8_t action, const std::string& process) {
    group_command_t command{};
    command.action = action;
    command.process = process;
    person_.publish<channels::GroupCommand>(command, 0);
    spin();
  }
  void send(const group_command_t& command) {
    ASSERT_TRUE(person_bus_.publish("GROUP_COMMAND", bus::encode(command).value()));
    spin();
  }
  void status(const std::string& process, int pid) {
    process_status_t status{};
    status.process = process;
    status.pid = pid;
    person_.publish<channels::ProcessStatus>(status, 0);
    spin();
  }

  testing::TemporaryFolder folder_;
  bus::ManualClock clock_;
  bus::InProcessHub hub_;
  bus::Bus& bus_ = hub_.make_endpoint();
  bus::Bus& person_bus_ = hub_.make_endpoint();
  bus::Node node_{"supervisor", bus_, clock_, {}, 1};
  bus::Node person_{"cli", person_bus_, clock_, {}, 2};
  std::unique_ptr<SupervisorNode> supervisor_;
  std::optional<group_state_t> state_;
  std::optional<process_status_t> status_;
};

TEST_F(SupervisorOnABus, TellsTheWholeStateEverySecond) {
  ASSERT_TRUE(state_);
  EXPECT_EQ(state_->group, "test");
  EXPECT_EQ(state_->run, folder_.path());
  ASSERT_EQ(state_->count, 2);
  EXPECT_EQ(state_->processes[1].process, "mapper");
  EXPECT_EQ(state_->processes[1].actual, process_state_t::ACTUAL_STOPPED);
  EXPECT_FALSE(state_->processes[1].wanted);
  EXPECT_EQ(state_->processes[1].reason, "is not started with the group");
  int heard = 0;
  person_.on<channels::GroupState>([&](const group_state_t&) { ++heard; });
  go_on(10'000'000);
  EXPECT_NEAR(heard, 10, 1);
}

TEST_F(SupervisorOnABus, RefusesWhatMakesNoSense) {
  tell(group_command_t::ACTION_STOP, "maper");
  EXPECT_EQ(last_refusal(), "the group has no process maper");
  tell(0, "mapper");
  EXPECT_EQ(last_refusal(), "action 0 is not known");
  tell(100, "mapper");
  EXPECT_EQ(last_refusal(), "action 100 is not known");
  tell(group_command_t::ACTION_END, "mapper");
  EXPECT_EQ(last_refusal(), "ACTION_END: is for the whole group");
  EXPECT_EQ(refused(), 4);
  EXPECT_FALSE(node_.stopping());
  tell(group_command_t::ACTION_STOP, "mapper");
  EXPECT_EQ(refused(), 4);
  EXPECT_EQ(state_->processes[1].reason, "is not started with the group")
      << "nothing has changed that is told at once";
}

TEST_F(SupervisorOnABus, RefusesWhatIsOldOrRepeatedOrFromTheFuture) {
  group_command_t command{};
  command.action = group_command_t::ACTION_END;
  command.header.session = 77;
  command.header.sent_steady_us = clock_.now_us() - 5'100'000;
  send(command);
  EXPECT_EQ(last_refusal(), "was not sent within the last 5 s") << "a recording is played";
  command.header.sent_steady_us = clock_.now_us() + 1'000'000;
  send(command);
  EXPECT_EQ(refused(), 2);
  command.action = group_command_t::ACTION_STOP;
  command.header.sent_steady_us = clock_.now_us();
  command.header.sequence = 5;
  send(command);
  EXPECT_EQ(refused(), 2);
  send(command);
  EXPECT_EQ(last_refusal(), "was obeyed before");
  command.header.sequence = 4;
  command.action = group_command_t::ACTION_END;
  send(command);
  EXPECT_EQ(refused(), 4);
  EXPECT_FALSE(node_.stopping());
  command.header.sequence = 6;
  send(command);
  EXPECT_TRUE(node_.stopping());
}

TEST_F(SupervisorOnABus, SeededCorruptionsOfACommandEndNothing) {
  group_command_t command{};
  command.action = group_command_t::ACTION_START;
  command.process = "nobody-of-this-name";
  command.header.session = 9;
  command.header.sent_steady_us = clock_.now_us();
  const auto good = bus::encode(command).value();
  std::mt19937 random(1);
  for (int trial = 0; trial < 2'000; ++trial) {
    auto bytes = good;
    for (std::size_t i = 0; i < 1 + random() % 3; ++i) {
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    }
    ASSERT_TRUE(person_bus_.publish("GROUP_COMMAND", bytes));
    spin();
  }
  EXPECT_EQ(refused(), 2'000);
  EXPECT_FALSE(node_.stopping());
  for (const process_state_t& process : state_->processes) EXPECT_FALSE(process.wanted);
}

TEST_F(SupervisorOnABus, SaysThatAStrangerUsesTheNameOfOneOfItsProcesses) {
  status("mapper", 4'000'000);
  go_on(1'500'000);
  ASSERT_TRUE(status_);
  EXPECT_EQ(status_->health, process_status_t::HEALTH_ILL);
  EXPECT_EQ(status_->reason, "another mapper (pid 4000000) is on this bus");
  go_on(5'000'000);
  EXPECT_EQ(status_->health, process_status_t::HEALTH_OK);
  EXPECT_FALSE(node_.stopping());
}

TEST(SupervisorStart, IsRefusedWhereAnotherGroupIsOnTheBus) {
  const testing::TemporaryFolder folder;
  bus::ManualClock clock;
  clock.set(1'000'000'000);
  bus::InProcessHub hub;
  bus::Bus& bus = hub.make_endpoint();
  bus::Bus& other_bus = hub.make_endpoint();
  bus::Node node("supervisor", bus, clock, {}, 1);
  bus::Node other("mapper", other_bus, clock, {}, 2);
  GroupConfig group;
  group.processes.resize(1);
  group.processes[0].name = "stereo";
  SupervisorNode supervisor(group, folder.path(), {}, std::nullopt, node);
  for (int i = 0; i < 100 && !node.stopping(); ++i) {
    clock.set(clock.now_us() + 20'000);
    other.spin_once(0);
    hub.deliver();
    node.spin_once(0);
  }
  EXPECT_TRUE(node.stopping());
  const auto finished = supervisor.finish();
  ASSERT_FALSE(finished);
  EXPECT_TRUE(finished.error().message.starts_with("another group's mapper (pid "));
  EXPECT_NE(finished.error().message.find("./cairn down"), std::string::npos);
  EXPECT_NE(finished.error().message.find("--lcm-url udpm://"), std::string::npos);
}

}  // namespace
}  // namespace cairn
