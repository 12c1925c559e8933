// SPDX-License-Identifier: Apache-2.0
// What lcmtypes/harden.cmake must have done to every generated header; another lcm-gen, or another
// harden.cmake, does not get past this.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <regex>
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

std::ptrdiff_t count(const std::string& text, const std::regex& pattern) {
  return std::distance(std::sregex_iterator(text.begin(), text.end(), pattern), {});
}

std::ptrdiff_t count(const std::string& text, const std::string& words) {
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
  const std::regex guarded(
      R"(if \(static_cast<int64_t>\(([\w>-]+)\) < 0 \|\| static_cast<int64_t>\(\1\) > static_cast<int64_t>\(maxlen\) - pos\) return -1; this->\w+(\[a\d+\])*\.resize\(static_cast<size_t>\(\1\)\);)");
  std::ptrdiff_t all = 0;
  for (const auto& [type, fields] : schema().types()) {
    const std::string hardened = hardened_header(type);
    const std::ptrdiff_t expected = count(raw_header(type), ".resize(");
    EXPECT_EQ(count(hardened, guarded), expected) << type;
    EXPECT_EQ(count(hardened, ".resize("), expected) << type;
    all += expected;
  }
  EXPECT_GT(all, 20);
}

TEST(Hardening, AsManyResizesAsVariableArrays) {
  for (const auto& [type, fields] : schema().types()) {
    const auto arrays =
        std::count_if(fields.begin(), fields.end(),
                      [](const testing::LcmField& field) { return field.variable(); });
    EXPECT_EQ(count(raw_header(type), ".resize("), arrays) << type;
  }
}

TEST(Hardening, EveryStringIsGuarded) {
  const std::regex guarded(
      R"(if \((__\w+_len__) < 1 \|\| \1 > maxlen - pos\) return -1;\s*this->\w+(\[a\d+\])*\.assign\(\(\(const char\*\)buf\) \+ offset \+ pos, \1 - 1\);)");
  std::ptrdiff_t all = 0;
  for (const auto& [type, fields] : schema().types()) {
    const auto strings =
        std::count_if(fields.begin(), fields.end(),
                      [](const testing::LcmField& field) { return field.type == "string"; });
    const std::string hardened = hardened_header(type);
    EXPECT_EQ(count(raw_header(type), ".assign("), strings) << type;
    EXPECT_EQ(count(hardened, ".assign("), strings) << type;
    EXPECT_EQ(count(hardened, guarded), strings) << type;
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
