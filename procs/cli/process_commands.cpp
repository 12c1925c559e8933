// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>

#include "procs/cli/command.hpp"
#include "procs/cli/group_session.hpp"
#include "procs/cli/stop_robot.hpp"

namespace cairn::cli {
namespace {

constexpr std::int64_t kTellAgain_us = 2 * kMicrosecondsPerSecond;
constexpr std::int64_t kLongestStart_us = 60 * kMicrosecondsPerSecond;
/// The longest grace time that a group file may give, and what the end itself takes.
constexpr std::int64_t kLongestStop_us = 620 * kMicrosecondsPerSecond;

/// One process of a running group, for a word that is about it.
struct Subject {
  std::unique_ptr<GroupSession> session;
  std::string name;
  std::int32_t pid_before = 0;

  [[nodiscard]] GroupClient& group() const { return session->group(); }
  [[nodiscard]] const process_state_t* state() const { return group().find(name); }
};

Result<Subject> find(const std::string& process, const std::string& lcm_url) {
  auto session = GroupSession::open(lcm_url);
  if (!session) return tl::make_unexpected(session.error());
  if (auto found = (*session)->find_supervisor(); !found) {
    return tl::make_unexpected(found.error());
  }
  Subject subject{std::move(*session), process};
  if (subject.state() != nullptr) {
    subject.pid_before = subject.state()->pid;
    return subject;
  }
  std::string names;
  for (const process_state_t& one : subject.group().state()->processes) {
    names += (names.empty() ? "" : ", ") + one.process;
  }
  return fail("the group has no process '" + process + "'; it has " + names);
}

bool is_up(const Subject& subject) {
  const process_state_t* state = subject.state();
  return state != nullptr && state->actual == process_state_t::ACTUAL_RUNNING &&
         subject.group().status(subject.name) != nullptr;
}

bool has_failed(const Subject& subject) {
  const process_state_t* state = subject.state();
  return state != nullptr && state->actual == process_state_t::ACTUAL_FAILED;
}

int say_how_it_is(const Subject& subject) {
  const process_state_t* state = subject.state();
  if (state == nullptr) return failed("the supervisor is not heard any more");
  if (is_up(subject)) {
    std::cout << subject.name << ": running (pid " << state->pid << ")\n";
    return 0;
  }
  return failed(subject.name + ": " + (state->reason.empty() ? "does not run yet" : state->reason) +
                "; ./cairn output " + subject.name + " shows what it said");
}

int start(const Subject& subject) {
  if (is_up(subject)) {
    std::cout << subject.name << ": runs already (pid " << subject.pid_before << ")\n";
    return 0;
  }
  subject.group().tell(group_command_t::ACTION_START, subject.name);
  // One that had failed is told so once more before it is wanted.
  subject.group().wait_until([&] { return !has_failed(subject); }, kTellAgain_us);
  subject.group().wait_until([&] { return is_up(subject) || has_failed(subject); },
                             kLongestStart_us);
  return say_how_it_is(subject);
}

int restart(const Subject& subject) {
  const auto is_new = [&] { return is_up(subject) && subject.state()->pid != subject.pid_before; };
  subject.group().tell(group_command_t::ACTION_RESTART, subject.name);
  subject.group().wait_until([&] { return !has_failed(subject); }, kTellAgain_us);
  subject.group().wait_until([&] { return is_new() || has_failed(subject); },
                             kLongestStart_us + kLongestStop_us);
  return say_how_it_is(subject);
}

int stop(const Subject& subject) {
  const auto is_down = [&] {
    const process_state_t* state = subject.state();
    return state != nullptr && state->pid == 0 && !state->wanted;
  };
  subject.group().tell(group_command_t::ACTION_STOP, subject.name);
  if (!subject.group().wait_until(is_down, kLongestStop_us)) {
    return failed(subject.name + ": still runs");
  }
  std::cout << subject.name << ": " << subject.state()->reason << "; ./cairn start " << subject.name
            << " runs it again\n";
  return 0;
}

void add_word(CLI::App& app, Run& run, const char* word, const char* help,
              int (*act)(const Subject&)) {
  auto process = std::make_shared<std::string>();
  auto lcm_url = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(word, help);
  command->add_option("process", *process, "its name, as cairn ps shows it")->required();
  command->add_option("--lcm-url", *lcm_url, "bus of the group");
  command->footer(std::string("Example:\n  cairn ") + word + " mapper");
  command->callback([&run, process, lcm_url, act] {
    run = [process, lcm_url, act] {
      const auto subject = find(*process, *lcm_url);
      return subject ? act(*subject) : failed(subject.error().message);
    };
  });
}

void add_stop(CLI::App& app, Run& run) {
  auto process = std::make_shared<std::string>();
  auto lcm_url = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("stop",
                         "STOP the robot: it holds still, over every restart, until a person "
                         "releases it; with a name: end that process");
  command->add_option("process", *process,
                      "a process of the group, to be ended until it is started again");
  command->add_option("--lcm-url", *lcm_url, "bus of the robot");
  command->footer("Example:\n  cairn stop\n  cairn stop mapper");
  command->callback([&run, process, lcm_url] {
    run = [process, lcm_url] {
      if (process->empty()) return stop_robot(*lcm_url);
      const auto subject = find(*process, *lcm_url);
      return subject ? stop(*subject) : failed(subject.error().message);
    };
  });
}

}  // namespace

void add_process_words(CLI::App& app, Run& run) {
  add_word(app, run, "start", "run a process of the group", start);
  add_stop(app, run);
  add_word(app, run, "restart", "end a process of the group and run it again", restart);
}

}  // namespace cairn::cli
