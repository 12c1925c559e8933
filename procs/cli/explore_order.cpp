// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/explore_order.hpp"

#include "bus/channels.hpp"

namespace cairn::cli {

namespace channels = bus::channels;

namespace {

constexpr std::int64_t kTellAgain_us = 500'000;

}  // namespace

ExploreOrder::ExploreOrder(bus::Node& node, std::int64_t goal_id) : node_{node}, goal_id_{goal_id} {
  node.on<channels::PlanState>([this](const plan_state_t& state) { hear(state); });
  node.every_host(kTellAgain_us, [this] { tell_again_if_unheard(); });
}

void ExploreOrder::hear(const plan_state_t& state) {
  heard_ = state.goal_id == goal_id_;
  now_ = state.reason;
  if (!heard_ || end_) return;
  if (state.state == plan_state_t::STATE_ARRIVED) end_ = End{true, state.reason};
  if (state.state == plan_state_t::STATE_REFUSED) end_ = End{false, state.reason};
}

void ExploreOrder::tell_again_if_unheard() {
  if (heard_ || end_) return;
  goal_t goal{};
  goal.goal_id = goal_id_;
  goal.action = goal_t::ACTION_EXPLORE;
  goal.who = node_.process();
  node_.publish<channels::Goal>(goal, node_.data_time());
}

}  // namespace cairn::cli
