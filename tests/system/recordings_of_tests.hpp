// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

namespace cairn::testing {

/// The first frames, 15 a second, of a drive round a rendered room with true poses, as a dataset in
/// a new or empty folder.
void render_room(const std::filesystem::path& folder, std::size_t frames);

/// 60 of them: rendered once per build folder, then kept.
[[nodiscard]] std::filesystem::path rendered_room();

/// The real street, where there is one.
[[nodiscard]] std::optional<std::filesystem::path> real_street();

inline constexpr const char* kNoStreet =
    "no street recording: set CAIRN_DATA to a folder with sequence/kitti_1";

/// A program of the project.
[[nodiscard]] std::string program(const std::string& name);

}  // namespace cairn::testing
