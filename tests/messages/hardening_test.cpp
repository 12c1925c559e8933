// SPDX-License-Identifier: Apache-2.0
// What lcmtypes/harden.cmake must have done to every generated header; another lcm-gen, or another
// harden.cmake, does not get past this.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <sstream>

#include "fuzz/lcm_schema.hpp"

namespace cairn {
namespace {

namespace fs = std::filesystem;

const testing::LcmSchema& schema() {
  static const testing::LcmSchema types(fs::path(CAIRN_SOURCE_DIR) / "lcmtypes");
  return types;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  EXPECT_TRUE(in) << file << " is missing";
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string raw_header(const std::string& type) {
  return text_of(fs::path(CAIRN_BINARY_DIR) / "lcmtypes/raw/cairn" / (type + ".hpp"));
}

std::string hardened_header(const std::string& type) {
  return text_of(fs::path(CAIRN_BINARY_DIR) / "lcmtypes/include/cairn" / (type + ".hpp"));
}

/// The lines without the spaces before them.
std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    lines.push_back(line.substr(std::min(line.size(), line.find_first_not_of(' '))));
  }
  return lines;
}

/// What stands between `before` and `after`; empty if that is not there.
std::string between(const std::string& line, const std::string& before, const std::string& after) {
  const auto found = line.find(before);
  if (found == std::string::npos) return {};
  const auto begin = found + before.size();
  return line.substr(begin, line.find(after, begin) - begin);
}

std::ptrdiff_t count_of(const std::string& text, const std::string& words) {
  std::ptrdiff_t found = 0;
  for (auto at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++found;
  return found;
}

std::string counts_agree_body(const std::string& header) {
  const auto begin = header.find("inline bool counts_agree() const {");
  if (begin == std::string::npos) return {};
  return header.substr(begin, header.find("return true;", begin) - begin);
}

TEST(Hardening, EveryTypeHasAHeader) {
  ASSERT_GT(schema().types().size(), 30U);
  for (const auto& [type, fields] : schema().types()) {
    EXPECT_NE(hardened_header(type).find("class " + type), std::string::npos) << type;
    EXPECT_NE(raw_header(type).find("class " + type), std::string::npos) << type;
  }
}

TEST(Hardening, EveryResizeIsGuarded) {
  std::ptrdiff_t all = 0;
  for (const auto& [type, fields] : schema().types()) {
    const std::string hardened = hardened_header(type);
    std::ptrdiff_t guarded = 0;
    for (const std::string& line : lines_of(hardened)) {
      if (line.find(".resize(") == std::string::npos) continue;
      const std::string count = between(line, ".resize(static_cast<size_t>(", "))");
      const std::string guard = "if (static_cast<int64_t>(" + count +
                                ") < 0 || static_cast<int64_t>(" + count +
                                ") > static_cast<int64_t>(maxlen) - pos) return -1; this->";
      ASSERT_FALSE(count.empty()) << type << ": " << line;
      EXPECT_EQ(line.substr(0, guard.size()), guard) << type;
      EXPECT_EQ(count_of(line, ".resize("), 1) << type;
      ++guarded;
    }
    EXPECT_EQ(guarded, count_of(raw_header(type), ".resize(")) << type;
    all += guarded;
  }
  EXPECT_GT(all, 20);
}

TEST(Hardening, AsManyResizesAsVariableArrays) {
  for (const auto& [type, fields] : schema().types()) {
    const auto arrays =
        std::count_if(fields.begin(), fields.end(),
                      [](const testing::LcmField& field) { return field.variable(); });
    EXPECT_EQ(count_of(raw_header(type), ".resize("), arrays) << type;
  }
}

TEST(Hardening, EveryStringIsGuarded) {
  std::ptrdiff_t all = 0;
  for (const auto& [type, fields] : schema().types()) {
    const auto strings =
        std::count_if(fields.begin(), fields.end(),
                      [](const testing::LcmField& field) { return field.type == "string"; });
    std::ptrdiff_t guarded = 0;
    std::string line_before;
    for (const std::string& line : lines_of(hardened_header(type))) {
      if (line.find(".assign(") != std::string::npos) {
        const std::string length = between(line, "offset + pos, ", " - 1);");
        EXPECT_EQ(line_before,
                  "if (" + length + " < 1 || " + length + " > maxlen - pos) return -1;")
            << type;
        ++guarded;
      }
      line_before = line;
    }
    EXPECT_EQ(count_of(raw_header(type), ".assign("), strings) << type;
    EXPECT_EQ(guarded, strings) << type;
    all += strings;
  }
  EXPECT_GT(all, 10);
}

TEST(Hardening, CountsAgreeLooksAtEveryVariableArrayAndEveryPart) {
  for (const auto& [type, fields] : schema().types()) {
    const std::string body = counts_agree_body(hardened_header(type));
    ASSERT_FALSE(body.empty()) << type << " has no counts_agree()";
    for (const testing::LcmField& field : fields) {
      if (field.variable()) {
        const std::string check = "if (static_cast<int64_t>(this->" + field.name +
                                  ".size()) != static_cast<int64_t>(this->" +
                                  field.dimensions.at(0) + ")) return false;";
        EXPECT_NE(body.find(check), std::string::npos) << type << "." << field.name;
      }
      if (!schema().is_struct(field.type)) continue;
      const std::string part = field.dimensions.empty()
                                   ? "if (!this->" + field.name + ".counts_agree()) return false;"
                                   : "for (const auto& element : this->" + field.name +
                                         ") if (!element.counts_agree()) return false;";
      EXPECT_NE(body.find(part), std::string::npos) << type << "." << field.name;
    }
  }
}

}  // namespace
}  // namespace cairn
