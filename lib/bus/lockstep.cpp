// SPDX-License-Identifier: Apache-2.0
#include "bus/lockstep.hpp"

#include <algorithm>
#include <atomic>
#include <thread>

namespace cairn::bus {

Node& Lockstep::add(const std::string& process, StateFolder state, Bus** bus) {
  Bus& endpoint = hub_.make_endpoint();
  if (bus != nullptr) *bus = &endpoint;
  const auto session = static_cast<std::int64_t>(nodes_.size()) + 1;
  return *nodes_.emplace_back(
      std::make_unique<Node>(process, endpoint, clock_, std::move(state), session));
}

void Lockstep::work_off(std::size_t index) {
  Node& node = *nodes_[index];
  do {
    node.spin_once(0);
  } while (node.has_work());
}

bool Lockstep::wave() {
  std::vector<std::size_t> busy;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    if (hub_.waiting(i) || nodes_[i]->has_work() ||
        nodes_[i]->next_deadline_us() <= clock_.now_us()) {
      busy.push_back(i);
    }
  }
  if (threads_ > 1 && busy.size() > 1) {
    std::atomic<std::size_t> next{0};
    std::vector<std::jthread> workers;
    for (int thread = 0; thread < threads_; ++thread) {
      workers.emplace_back([&] {
        for (std::size_t i = next++; i < busy.size(); i = next++) work_off(busy[i]);
      });
    }
  } else {
    for (const std::size_t i : busy) work_off(i);
  }
  hub_.deliver();
  return !busy.empty();
}

void Lockstep::run(const Node& source, const std::function<bool()>& go_on) {
  while (true) {
    while (wave()) {
    }
    if (go_on && !go_on()) break;
    if (source.stopping()) break;
    HostTime next = nodes_.front()->next_deadline_us();
    for (const auto& node : nodes_) next = std::min(next, node->next_deadline_us());
    clock_.set(next);
  }
  for (const auto& node : nodes_) node->publish_status();
  hub_.deliver();
  while (wave()) {
  }
}

}  // namespace cairn::bus
