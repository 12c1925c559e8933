// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace cairn::cli {

/// A file that comes with the project ("config/worlds/room.yaml"): installed under share/cairn
/// beside the program's bin folder, else in the source tree that the program was built in.
[[nodiscard]] std::filesystem::path shared_file(const std::filesystem::path& name);

}  // namespace cairn::cli
