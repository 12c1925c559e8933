// SPDX-License-Identifier: Apache-2.0
// supervisor: keeps a group of processes running.
// in: PROCESS_STATUS, GROUP_COMMAND, other supervisors' GROUP_STATE   out: GROUP_STATE, LOG_LINE
#include "bus/process.hpp"
#include "procs/supervisor/supervisor_node.hpp"

int main(int argc, char** argv) {
  return cairn::bus::run_process<cairn::SupervisorNode>(argc, argv);
}
