// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/plan_state_t.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "bus/node.hpp"

namespace cairn::cli {

/// Has planner explore, and hears how it goes. What planner forgot, or never heard, it is told
/// again: so it may die at any moment.
class ExploreOrder {
 public:
  /// How it ended.
  struct End {
    bool explored = false;  ///< nothing that can be reached is unknown any more
    std::string reason;     ///< as planner says it
  };

  /// `goal_id` tells this order from all others.
  ExploreOrder(bus::Node& node, std::int64_t goal_id);

  [[nodiscard]] const std::optional<End>& end() const { return end_; }
  /// What planner says it is doing; empty: nothing yet.
  [[nodiscard]] const std::string& now() const { return now_; }

 private:
  void hear(const plan_state_t& state);
  void tell_again_if_unheard();

  bus::Node& node_;
  std::int64_t goal_id_;
  bool heard_ = false;
  std::string now_;
  std::optional<End> end_;
};

}  // namespace cairn::cli
