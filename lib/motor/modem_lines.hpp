// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace cairn::motor {

/// libserialport asks every port for its modem control lines and gives up on one that has none, as
/// a pseudo-terminal has. A program that calls this answers for such terminals that all lines are
/// on; every other request, and every port that has lines, gets the kernel's own answer.
void answer_for_missing_modem_lines();

}  // namespace cairn::motor
