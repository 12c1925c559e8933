// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/shared_files.hpp"

#include "core/start_program.hpp"

namespace cairn::cli {

std::filesystem::path shared_file(const std::filesystem::path& name) {
  const std::filesystem::path installed = program_folder().parent_path() / "share" / "cairn" / name;
  return std::filesystem::exists(installed) ? installed
                                            : std::filesystem::path(CAIRN_SOURCE_DIR) / name;
}

}  // namespace cairn::cli
