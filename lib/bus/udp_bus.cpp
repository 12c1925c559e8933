// SPDX-License-Identifier: Apache-2.0
#include "bus/udp_bus.hpp"

#include <poll.h>

#include <cerrno>
#include <lcm/lcm-cpp.hpp>

namespace cairn::bus {
namespace {

/// LCM keeps the oldest messages when a queue is full, so the queue must never fill: it is drained
/// between two pieces of work, and this is room for more traffic than a second of any channel.
constexpr int kQueueCapacity = 1024;

class UdpBus : public Bus {
 public:
  explicit UdpBus(std::unique_ptr<lcm::LCM> lcm) : lcm_{std::move(lcm)} {}

  Result<void> publish(std::string_view channel, std::span<const std::uint8_t> bytes) override {
    if (lcm_->publish(std::string(channel), bytes.data(), static_cast<unsigned>(bytes.size())) ==
        0) {
      return {};
    }
    return fail(std::string(channel) + ": LCM could not send " + std::to_string(bytes.size()) +
                " bytes");
  }

  Result<void> subscribe(std::string_view channel) override {
    // LCM hands a message to every subscription that fits; here it comes once.
    if (has_all_) return {};
    const bool all = channel == kAllChannels;
    const std::string pattern = all ? ".*" : std::string(channel);
    lcm::Subscription* subscription = lcm_->subscribe(pattern, &UdpBus::keep, this);
    if (subscription == nullptr) return fail(pattern + ": LCM could not subscribe");
    subscription->setQueueCapacity(kQueueCapacity);
    if (all) {
      for (lcm::Subscription* single : singles_) lcm_->unsubscribe(single);
      singles_.clear();
    } else {
      singles_.push_back(subscription);
    }
    has_all_ = all;
    return {};
  }

  void receive(std::int64_t timeout_us, std::vector<RawMessage>& into) override {
    pollfd readable{lcm_->getFileno(), POLLIN, 0};
    timespec wait{timeout_us / 1'000'000, (timeout_us % 1'000'000) * 1000};
    while (::ppoll(&readable, 1, &wait, nullptr) > 0) {
      if (lcm_->handle() != 0) break;
      wait = {0, 0};
      if (inbox_.size() >= kQueueCapacity) break;
    }
    for (RawMessage& message : inbox_) into.push_back(std::move(message));
    inbox_.clear();
  }

 private:
  /// Called by LCM from C: nothing may be thrown out of it.
  void keep(const lcm::ReceiveBuffer* buffer, const std::string& channel) noexcept {
    try {
      const auto* data = static_cast<const std::uint8_t*>(buffer->data);
      inbox_.push_back(RawMessage{channel, {data, data + buffer->data_size}});
    } catch (const std::bad_alloc&) {
      // The gap in the sender's sequence counts this message as lost.
    }
  }

  std::unique_ptr<lcm::LCM> lcm_;
  std::vector<lcm::Subscription*> singles_;
  bool has_all_ = false;
  std::vector<RawMessage> inbox_;
};

}  // namespace

Result<std::unique_ptr<Bus>> open_udp_bus(const UdpUrl& url, std::string* warning) {
  const auto checked = check_network(url);
  if (!checked) return tl::make_unexpected(checked.error());
  if (warning != nullptr) *warning = *checked;
  auto lcm = std::make_unique<lcm::LCM>(url.text());
  if (!lcm->good()) return fail(url.text() + ": LCM could not open it");
  return std::make_unique<UdpBus>(std::move(lcm));
}

}  // namespace cairn::bus
