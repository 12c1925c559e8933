// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

namespace cairn::testing {

/// Bytes that operator new has given out since the program's start. A program that links
/// allocation_meter.cpp is counted; its tests run in one thread.
[[nodiscard]] std::size_t allocated_bytes();

}  // namespace cairn::testing
