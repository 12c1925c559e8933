// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "core/result.hpp"

namespace cairn::bus {

struct UdpUrl {
  std::string group = "239.255.76.67";
  int port = 7667;
  int ttl = 0;  ///< 0: packets stay on this machine
  int recv_buf_size =
      2'097'152;  ///< asked of the kernel, which gives at most net.core.rmem_max [bytes]

  /// In LCM's form.
  [[nodiscard]] std::string text() const;
};

/// udpm://GROUP:PORT[?ttl=N&recv_buf_size=N]; the error says which part is wrong and what it may
/// be.
[[nodiscard]] Result<UdpUrl> parse_udp_url(const std::string& url);

/// Tries what LCM is about to do (bind, join the group, find a route, get a receive buffer) and
/// says in words what is missing and the command that mends it. The value is a warning, empty where
/// all is well.
[[nodiscard]] Result<std::string> check_network(const UdpUrl& url);

}  // namespace cairn::bus
