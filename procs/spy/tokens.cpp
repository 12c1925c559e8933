// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/tokens.hpp"

#include <algorithm>
#include <cctype>

namespace cairn::spy {
namespace {

bool in_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.' || c == '-' ||
         c == '+';
}

}  // namespace

Tokens tokenize(std::string_view text) {
  Tokens result;
  result.comments.emplace_back();
  std::size_t at = 0;
  const auto new_line = [&] { result.comments.emplace_back(); };
  while (at < text.size()) {
    const std::string_view rest = text.substr(at);
    if (rest.starts_with("//")) {
      const std::string_view comment = rest.substr(2, rest.find('\n') - 2);
      result.comments.back() = comment;
      at += 2 + comment.size();
    } else if (rest.starts_with("/*")) {
      const std::size_t end = std::min(rest.find("*/", 2), rest.size());
      for (const char c : rest.substr(0, end)) {
        if (c == '\n') new_line();
      }
      at += std::min(end + 2, rest.size());
    } else if (rest[0] == '\n') {
      new_line();
      ++at;
    } else if (std::isspace(static_cast<unsigned char>(rest[0])) != 0) {
      ++at;
    } else {
      std::size_t size = 0;
      while (size < rest.size() && in_word(rest[size])) ++size;
      size = std::max<std::size_t>(size, 1);
      result.tokens.push_back(
          {std::string(rest.substr(0, size)), static_cast<int>(result.comments.size())});
      at += size;
    }
  }
  return result;
}

}  // namespace cairn::spy
