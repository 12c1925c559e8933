// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace cairn::house {

/// Path relative to the project, with '/', to the file's text. Ordered, so that findings are too.
using SourceTree = std::map<std::string, std::string>;

/// "path:line: what is wrong", one each.
using Findings = std::vector<std::string>;

/// Every C++, CMake, preset and message file under lib, procs, tests, lcmtypes and in the root of
/// `project`, without what tools fetched or built there.
SourceTree read_source_tree(const std::filesystem::path& project);

/// `text` with comments and the insides of string and character literals blanked, lines kept. Names
/// in an #include stay.
std::string code_of(std::string_view text);

/// The lines of `text`, without their ends.
std::vector<std::string> lines_of(std::string_view text);

/// The folder that a file belongs to, for example "lib/stereo"; empty for a file that is in none.
std::string folder_of(std::string_view path);

/// True for C++ headers and sources.
bool is_cpp(std::string_view path);

/// All findings as one text to print.
std::string joined(const Findings& findings);

}  // namespace cairn::house
