// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "bus/bus.hpp"

namespace cairn::bus {

/// Buses for nodes in one process, without sockets. What an endpoint publishes waits in its own
/// outbox until `deliver()`, which hands all outboxes out in the order in which the endpoints were
/// made: so the order of messages does not depend on how many threads the nodes ran on. Between two
/// deliveries each endpoint may be used from a thread of its own; making endpoints and delivering
/// are for one thread alone.
class InProcessHub {
 public:
  /// The endpoint lives as long as the hub.
  [[nodiscard]] Bus& make_endpoint();

  /// True if anything was delivered.
  bool deliver();

  /// True if the endpoint (by order of making) has messages that it has not received.
  [[nodiscard]] bool waiting(std::size_t endpoint) const;

 private:
  class Endpoint;
  std::vector<std::shared_ptr<Endpoint>> endpoints_;
};

}  // namespace cairn::bus
