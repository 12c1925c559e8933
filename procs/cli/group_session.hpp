// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "bus/node.hpp"
#include "procs/cli/group_client.hpp"

namespace cairn::cli {

/// What a word about a running group has: a bus, and who listens there.
class GroupSession {
 public:
  /// An error names what the network lacks.
  [[nodiscard]] static Result<std::unique_ptr<GroupSession>> open(const std::string& lcm_url);

  GroupSession(std::string url, std::unique_ptr<bus::Bus> bus);

  /// Listens until a supervisor is heard. An error: none is.
  [[nodiscard]] Result<void> find_supervisor();

  [[nodiscard]] bus::Node& node() { return node_; }
  [[nodiscard]] GroupClient& group() { return client_; }
  [[nodiscard]] const std::string& url() const { return url_; }

 private:
  std::string url_;
  std::unique_ptr<bus::Bus> bus_;
  bus::SteadyClock clock_;
  bus::Node node_;
  GroupClient client_;
};

}  // namespace cairn::cli
