// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace cairn::cli {

/// Sends STOP until motor says that it is latched, prints how long that took, and gives the exit
/// code; fails with the reason after 2 s.
[[nodiscard]] int stop_robot(const std::string& lcm_url);

/// Ends the latch, as the person who typed it: the robot may move by what it is told from now on.
/// Prints what came of it, and gives the exit code; fails with the reason after 2 s.
[[nodiscard]] int release_robot(const std::string& lcm_url);

/// Who types here, as STOP and the latch name them: "anna at the terminal".
[[nodiscard]] std::string person_at_the_terminal();

}  // namespace cairn::cli
