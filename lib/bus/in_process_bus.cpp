// SPDX-License-Identifier: Apache-2.0
#include "bus/in_process_bus.hpp"

namespace cairn::bus {

class InProcessHub::Endpoint : public Bus {
 public:
  Result<void> publish(std::string_view channel, std::span<const std::uint8_t> bytes) override {
    outbox.push_back(RawMessage{std::string(channel), {bytes.begin(), bytes.end()}});
    return {};
  }
  Result<void> subscribe(std::string_view channel) override {
    wanted.emplace(channel);
    return {};
  }
  void receive(std::int64_t, std::vector<RawMessage>& into) override {
    for (RawMessage& message : inbox) into.push_back(std::move(message));
    inbox.clear();
  }
  [[nodiscard]] bool wants(const std::string& channel) const {
    return wanted.contains(channel) || wanted.contains(kAllChannels);
  }

  std::set<std::string, std::less<>> wanted;
  std::vector<RawMessage> inbox;
  std::vector<RawMessage> outbox;
};

Bus& InProcessHub::make_endpoint() {
  return *endpoints_.emplace_back(std::make_shared<Endpoint>());
}

bool InProcessHub::deliver() {
  bool any = false;
  for (const auto& sender : endpoints_) {
    for (const RawMessage& message : sender->outbox) {
      for (const auto& receiver : endpoints_) {
        if (!receiver->wants(message.channel)) continue;
        receiver->inbox.push_back(message);
        any = true;
      }
    }
    sender->outbox.clear();
  }
  return any;
}

bool InProcessHub::waiting(std::size_t endpoint) const {
  return !endpoints_[endpoint]->inbox.empty();
}

}  // namespace cairn::bus
