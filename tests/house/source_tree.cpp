// SPDX-License-Identifier: Apache-2.0
#include "house/source_tree.hpp"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <sstream>

namespace cairn::house {
namespace fs = std::filesystem;
namespace {

bool is_read(const fs::path& path) {
  const std::string name = path.filename().string();
  return is_cpp(name) || name.ends_with(".lcm") || name.ends_with(".cmake") ||
         name == "CMakeLists.txt" || name == "CMakePresets.json";
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

bool in_include(std::string_view text, size_t position) {
  const size_t line_start = text.rfind('\n', position) + 1;
  const size_t first = text.find_first_not_of(" \t", line_start);
  return first < position && text[first] == '#';
}

bool in_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

/// Where the literal or comment that begins at `start` ends (one past its last character); `start`
/// itself when none begins there.
size_t end_of_blank(std::string_view text, size_t start) {
  const auto past = [&](std::string_view mark, size_t from) {
    const size_t found = text.find(mark, from);
    return found == std::string_view::npos ? text.size() : found + mark.size();
  };
  const std::string_view rest = text.substr(start);
  if (rest.starts_with("//")) return std::min(text.find('\n', start), text.size());
  if (rest.starts_with("/*")) return past("*/", start + 2);
  if (rest.starts_with("R\"") && (start == 0 || !in_word(text[start - 1]))) {
    const std::string_view delimiter = rest.substr(2, rest.find('(') - 2);
    return past(")" + std::string(delimiter) + "\"", start + 2);
  }
  const bool is_string = rest.starts_with('"') && !in_include(text, start);
  const bool is_character = rest.starts_with('\'') && (start == 0 || !in_word(text[start - 1]));
  if (!is_string && !is_character) return start;
  for (size_t i = start + 1; i < text.size() && text[i] != '\n'; ++i) {
    if (text[i] == '\\') {
      ++i;
    } else if (text[i] == text[start]) {
      return i + 1;
    }
  }
  return text.size();
}

}  // namespace

SourceTree read_source_tree(const fs::path& project) {
  SourceTree tree;
  const auto add = [&](const fs::path& path) {
    tree[path.lexically_relative(project).generic_string()] = text_of(path);
  };
  for (const auto& entry : fs::directory_iterator(project)) {
    if (entry.is_regular_file() && is_read(entry.path())) add(entry.path());
  }
  for (const char* top : {"lib", "procs", "tests", "lcmtypes"}) {
    for (auto it = fs::recursive_directory_iterator(project / top); it != end(it); ++it) {
      if (it->path().filename() == "node_modules") it.disable_recursion_pending();
      if (it->is_regular_file() && is_read(it->path())) add(it->path());
    }
  }
  return tree;
}

std::string code_of(std::string_view text) {
  std::string code(text);
  for (size_t i = 0; i < text.size();) {
    const size_t blank_end = end_of_blank(text, i);
    for (size_t k = i; k < blank_end; ++k) {
      if (code[k] != '\n') code[k] = ' ';
    }
    i = std::max(blank_end, i + 1);
  }
  return code;
}

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  std::istringstream stream{std::string(text)};
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string folder_of(std::string_view path) {
  const size_t first = path.find('/');
  if (first == std::string_view::npos) return {};
  const size_t second = path.find('/', first + 1);
  if (second == std::string_view::npos) return {};
  return std::string(path.substr(0, second));
}

bool is_cpp(std::string_view path) { return path.ends_with(".hpp") || path.ends_with(".cpp"); }

std::string joined(const Findings& findings) {
  std::string text;
  for (const std::string& finding : findings) text += finding + "\n";
  return text;
}

}  // namespace cairn::house
