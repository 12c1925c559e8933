// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "bus/bus.hpp"
#include "bus/udp_url.hpp"

namespace cairn::bus {

/// LCM over UDP multicast. A warning about the machine's set-up goes to `warning`, if it is not
/// null.
[[nodiscard]] Result<std::unique_ptr<Bus>> open_udp_bus(const UdpUrl& url,
                                                        std::string* warning = nullptr);

}  // namespace cairn::bus
