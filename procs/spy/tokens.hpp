// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cairn::spy {

/// A word, a number or one punctuation mark of an .lcm file.
struct Token {
  std::string text;
  int line = 0;  ///< from 1
};

/// An .lcm file taken apart. Never fails: what belongs nowhere becomes a token that no rule takes.
struct Tokens {
  std::vector<Token> tokens;
  std::vector<std::string> comments;  ///< by line - 1: the text behind "//", empty without one
};

[[nodiscard]] Tokens tokenize(std::string_view text);

}  // namespace cairn::spy
