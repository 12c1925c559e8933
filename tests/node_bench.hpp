// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "bus/in_process_bus.hpp"
#include "bus/node.hpp"

namespace cairn::testing {

/// A node under test on a bus in memory, and a peer who plays everybody else. Time passes only as
/// the test says.
class NodeBench : public ::testing::Test {
 protected:
  /// A new life of the node under test: a new session on the same bus. Whatever rests on the one
  /// before must be gone by now.
  bus::Node& start_node(const std::string& name, StateFolder state = {}) {
    node_ = std::make_unique<bus::Node>(name, hub_.make_endpoint(), clock_, std::move(state),
                                        ++session_);
    return *node_;
  }

  /// The node takes all that was sent, then the peer takes what came of it.
  void spin() {
    hub_.deliver();
    take_all(*node_);
    hub_.deliver();
    take_all(peer_);
  }

  void send_clock(Utime utime) {
    cairn::clock_t tick{};
    tick.rate = 1;
    peer_.publish<bus::channels::Clock>(tick, utime);
  }

  bus::ManualClock clock_;
  bus::InProcessHub hub_;
  bus::Node peer_{"peer", hub_.make_endpoint(), clock_, StateFolder{}, 1000};
  std::int64_t session_ = 0;
  std::unique_ptr<bus::Node> node_;

 private:
  static void take_all(bus::Node& node) {
    do {
      node.spin_once(0);
    } while (node.has_work());
  }
};

}  // namespace cairn::testing
