// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "procs/cli/run_plan.hpp"

namespace cairn::cli {

/// Makes plan.out (default out/replay) ready for a new run: what an earlier run left there of this
/// program's own files is removed; a folder that holds anything else is refused, so that nobody's
/// files are lost.
[[nodiscard]] Result<void> prepare_run_folder(RunPlan& plan);

}  // namespace cairn::cli
