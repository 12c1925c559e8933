// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/group_session.hpp"

#include <random>
#include <utility>

#include "bus/process.hpp"

namespace cairn::cli {
namespace {

/// A supervisor sends its state once a second.
constexpr std::int64_t kLongestSilence_us = 1'500'000;

std::int64_t random_session() {
  std::random_device device;
  return static_cast<std::int64_t>(device()) << 31 | device();
}

}  // namespace

Result<std::unique_ptr<GroupSession>> GroupSession::open(const std::string& lcm_url) {
  auto bus = bus::open_bus(lcm_url);
  if (!bus) return tl::make_unexpected(bus.error());
  auto session = std::make_unique<GroupSession>(bus::effective_url(lcm_url), std::move(*bus));
  if (!session->node().wiring()) return tl::make_unexpected(session->node().wiring().error());
  return session;
}

GroupSession::GroupSession(std::string url, std::unique_ptr<bus::Bus> bus)
    : url_{std::move(url)},
      bus_{std::move(bus)},
      node_{"cli", *bus_, clock_, {}, random_session()},
      client_{node_} {}

Result<void> GroupSession::find_supervisor() {
  if (client_.wait_until([&] { return client_.state() != nullptr; }, kLongestSilence_us)) return {};
  std::string heard;
  for (const std::string_view process : bus::kProcesses) {
    if (client_.status(std::string(process)) == nullptr) continue;
    heard += (heard.empty() ? "" : ", ") + std::string(process);
  }
  const std::string where = "no supervisor is heard on " + url_ + "; ";
  if (heard.empty()) {
    return fail(where + "is a group up (./cairn up GROUP.yaml), and on this bus (--lcm-url)?");
  }
  return fail(where + "but these processes are: " + heard +
              ". If they are a group's whose supervisor died, take them up again: ./cairn up "
              "GROUP.yaml --out RUN, with the folder of their run");
}

}  // namespace cairn::cli
