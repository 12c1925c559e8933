// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sched.h>

#include <cstdlib>

namespace cairn::testing {

/// Moves this process into a network namespace of its own with nothing but a loopback device that
/// is up; false where the machine does not allow it. Must be called before the process has threads.
[[nodiscard]] inline bool enter_network_namespace() {
  return ::unshare(CLONE_NEWNET) == 0 && std::system("ip link set lo up") == 0;
}

/// What makes multicast work there.
[[nodiscard]] inline bool add_multicast_route() {
  return std::system("ip route add 224.0.0.0/4 dev lo") == 0;
}

inline constexpr const char* kNoNamespace =
    "needs a network namespace of its own (root or CAP_SYS_ADMIN, and iproute2): not tested here";

}  // namespace cairn::testing
