// SPDX-License-Identifier: Apache-2.0
#include "procs/supervisor/printed_lines.hpp"

#include <algorithm>
#include <fstream>
#include <utility>

namespace cairn {
namespace {

/// Of more at once, the end is looked at.
constexpr std::uintmax_t kMost_bytes = 65'536;

std::string printable(std::string line) {
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  }
  if (line.size() > PrintedLines::kLongestLine) line.resize(PrintedLines::kLongestLine);
  return line;
}

}  // namespace

PrintedLines::PrintedLines(std::filesystem::path file) : file_{std::move(file)} {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file_, error);
  if (!error) position_ = size;
}

std::vector<std::string> PrintedLines::take() {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file_, error);
  if (error || size == position_) return {};
  if (size < position_) position_ = 0;  // somebody has emptied it
  if (size - position_ > kMost_bytes) {
    position_ = size - kMost_bytes;
    rest_.clear();
  }
  std::ifstream stream(file_, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(position_));
  std::string printed(static_cast<std::size_t>(size - position_), '\0');
  stream.read(printed.data(), static_cast<std::streamsize>(printed.size()));
  printed.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, stream.gcount())));
  position_ += printed.size();
  rest_ += printed;
  std::vector<std::string> lines;
  std::size_t passed_over = 0;
  std::size_t begin = 0;
  for (std::size_t end = rest_.find('\n'); end != std::string::npos;
       end = rest_.find('\n', begin)) {
    if (lines.size() < kMostLines) {
      lines.push_back(printable(rest_.substr(begin, end - begin)));
    } else {
      ++passed_over;
    }
    begin = end + 1;
  }
  rest_.erase(0, begin);
  if (rest_.size() > kLongestLine) rest_.resize(kLongestLine);
  if (passed_over > 0) lines.push_back("and " + std::to_string(passed_over) + " lines more");
  return lines;
}

}  // namespace cairn
