// SPDX-License-Identifier: Apache-2.0
#include "house/rules.hpp"

#include <cctype>
#include <initializer_list>

namespace cairn::house {
namespace {

using Words = std::initializer_list<std::string_view>;

bool in_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

bool contains_word(const std::string& line, std::string_view word) {
  for (size_t at = line.find(word); at != std::string::npos; at = line.find(word, at + 1)) {
    const size_t after = at + word.size();
    if ((at == 0 || !in_word(line[at - 1])) && (after == line.size() || !in_word(line[after]))) {
      return true;
    }
  }
  return false;
}

void find_words(const std::string& path, const std::string& text, Words words, std::string_view why,
                Findings& findings) {
  const std::vector<std::string> lines = lines_of(text);
  for (size_t i = 0; i < lines.size(); ++i) {
    for (const std::string_view word : words) {
      if (!contains_word(lines[i], word)) continue;
      findings.push_back(path + ":" + std::to_string(i + 1) + ": " + std::string(word) + ": " +
                         std::string(why));
    }
  }
}

std::string without_hash_comments(const std::string& text) {
  std::string code;
  for (const std::string& line : lines_of(text)) code += line.substr(0, line.find('#')) + "\n";
  return code;
}

}  // namespace

Findings long_mains(const SourceTree& tree) {
  Findings findings;
  for (const auto& [path, text] : tree) {
    const size_t lines = lines_of(text).size();
    if (!path.starts_with("procs/") || !path.ends_with("/main.cpp") || lines <= 40) continue;
    findings.push_back(path + ":41: " + std::to_string(lines) +
                       " lines; over 40 it does more than wire");
  }
  return findings;
}

Findings machine_bound_flags(const SourceTree& tree) {
  Findings findings;
  for (const auto& [path, text] : tree) {
    if (is_cpp(path) || path.ends_with(".lcm")) continue;
    find_words(path, without_hash_comments(text), {"march=native", "mcpu=native"},
               "breaks on the next machine; choose at run time", findings);
  }
  return findings;
}

Findings clock_reads_in_science(const SourceTree& tree) {
  Findings findings;
  for (const auto& [path, text] : tree) {
    if (!is_cpp(path) || !path.starts_with("lib/") || path.starts_with("lib/bus/")) continue;
    find_words(path, code_of(text),
               {"steady_clock::now", "system_clock::now", "high_resolution_clock::now",
                "clock_gettime", "gettimeofday"},
               "a clock is read inside the science; time comes with the message", findings);
  }
  return findings;
}

Findings sleeping_tests(const SourceTree& tree) {
  Findings findings;
  for (const auto& [path, text] : tree) {
    if (!is_cpp(path) || !path.starts_with("tests/")) continue;
    find_words(path, code_of(text), {"sleep_for", "sleep_until", "usleep", "nanosleep"},
               "a test that sleeps is slow on a good day and wrong on a bad one", findings);
  }
  return findings;
}

Findings left_for_later(const SourceTree& tree) {
  Findings findings;
  for (const auto& [path, text] : tree) {
    if (path.starts_with("tests/")) continue;
    find_words(path, text, {"TODO", "FIXME", "XXX", "HACK"}, "left for later", findings);
  }
  return findings;
}

Findings without_licence(const SourceTree& tree) {
  Findings findings;
  for (const auto& [path, text] : tree) {
    if (!is_cpp(path) || text.starts_with("// SPDX-License-Identifier: Apache-2.0\n")) continue;
    findings.push_back(path + ":1: must begin with // SPDX-License-Identifier: Apache-2.0");
  }
  return findings;
}

}  // namespace cairn::house
