// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "bus/bus.hpp"

namespace cairn::bus {

/// Plays a recording's messages one at a time, in their order, as fast as they are received. What
/// is published goes into the recording `out` (stamped with the time of the message being played),
/// or nowhere if `out` is empty.
[[nodiscard]] Result<std::unique_ptr<Bus>> open_recording_bus(const std::filesystem::path& in,
                                                              const std::filesystem::path& out);

}  // namespace cairn::bus
