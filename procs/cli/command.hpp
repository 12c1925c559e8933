// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace cairn::cli {

inline constexpr int kExitFailure = 1;
inline constexpr int kExitUsage = 2;

/// Each adds one word of the command line to `app`; when that word is given, `run` is set to what
/// it does, which gives the exit code.
using Run = std::function<int()>;
void add_demo(CLI::App& app, Run& run);
void add_replay(CLI::App& app, Run& run);
void add_record(CLI::App& app, Run& run);
void add_stereo(CLI::App& app, Run& run);
void add_eval(CLI::App& app, Run& run);
void add_map(CLI::App& app, Run& run);
void add_spy(CLI::App& app, Run& run);
void add_up(CLI::App& app, Run& run);
void add_keep(CLI::App& app, Run& run);
void add_down(CLI::App& app, Run& run);
void add_ps(CLI::App& app, Run& run);
void add_process_words(CLI::App& app,
                       Run& run);  ///< start, stop, restart; stop without a name: STOP
void add_output(CLI::App& app, Run& run);
void add_release(CLI::App& app, Run& run);
void add_drive(CLI::App& app, Run& run);
void add_motor(CLI::App& app, Run& run);

/// Prints why, and gives the exit code of a failure.
int failed(const std::string& message);

}  // namespace cairn::cli
