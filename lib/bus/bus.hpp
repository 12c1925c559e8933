// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace cairn::bus {

struct RawMessage {
  std::string channel;
  std::vector<std::uint8_t> bytes;
};

/// Carries bytes under channel names. Three of them: UDP multicast (live), a recording (replay),
/// in-process (lockstep, tests). One thread receives; any thread may publish.
class Bus {
 public:
  virtual ~Bus() = default;

  [[nodiscard]] virtual Result<void> publish(std::string_view channel,
                                             std::span<const std::uint8_t> bytes) = 0;

  /// Wants the messages of this channel, or of all ("*"). An error says what the network lacks and
  /// what mends it.
  [[nodiscard]] virtual Result<void> subscribe(std::string_view channel) = 0;

  /// Appends all messages that are there, in the order of arrival; waits up to `timeout_us` for the
  /// first.
  virtual void receive(std::int64_t timeout_us, std::vector<RawMessage>& into) = 0;

  /// True where nothing will ever come any more: the recording is at its end.
  [[nodiscard]] virtual bool ended() const { return false; }
};

inline constexpr std::string_view kAllChannels = "*";

/// What an empty URL stands for: LCM_DEFAULT_URL if that is set, else
/// udpm://239.255.76.67:7667?ttl=0. Any other stands for itself.
[[nodiscard]] std::string effective_url(const std::string& url);

/// The bus that a URL names: udpm://GROUP:PORT[?ttl=0&recv_buf_size=N] or
/// file:///RECORDING[?out=RECORDING]; an empty one as under effective_url.
[[nodiscard]] Result<std::unique_ptr<Bus>> open_bus(const std::string& url);

}  // namespace cairn::bus
