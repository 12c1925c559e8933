// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "core/time.hpp"
#include "motor/byte_link.hpp"

namespace cairn::motor {

/// Both ends of a line in memory; each may be used from a thread of its own. An end whose other end
/// is gone says so, as a cut line does.
///
/// With a clock, a byte can be read once the clock has moved on from where it was written: in
/// lockstep what is read then does not depend on who of a wave ran first.
[[nodiscard]] std::pair<std::unique_ptr<ByteLink>, std::unique_ptr<ByteLink>> make_memory_links(
    std::function<HostTime()> now_us = {});

}  // namespace cairn::motor
