// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/output_lines.hpp"

#include <algorithm>
#include <fstream>

namespace cairn::cli {
namespace {

constexpr std::streamoff kBlock_bytes = 65'536;

}  // namespace

std::vector<std::string> last_lines(const std::filesystem::path& file, std::size_t count) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  if (!stream || count == 0) return {};
  std::streamoff position = stream.tellg();
  std::string text;
  // One more newline than lines: the one before the first of them.
  while (position > 0 &&
         static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) <= count) {
    const std::streamoff size = std::min(kBlock_bytes, position);
    position -= size;
    std::string block(static_cast<std::size_t>(size), '\0');
    stream.seekg(position);
    stream.read(block.data(), size);
    text.insert(0, block);
  }
  std::vector<std::string> lines;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  if (lines.size() > count)
    lines.erase(lines.begin(), lines.end() - static_cast<std::ptrdiff_t>(count));
  return lines;
}

}  // namespace cairn::cli
