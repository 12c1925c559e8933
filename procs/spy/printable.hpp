// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cairn::spy {

/// Text from anybody, safe to show: control characters and what is not UTF-8 become \xNN, so that
/// no message can move the cursor or change the terminal.
[[nodiscard]] std::string printable(std::string_view text);

/// How many columns printable text takes, one for each character.
[[nodiscard]] std::size_t width_of(std::string_view text);

/// Printable text cut to `width` columns; "..." at its end shows that it was.
[[nodiscard]] std::string shortened(std::string_view text, std::size_t width);

}  // namespace cairn::spy
