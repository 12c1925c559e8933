// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

namespace {

TEST(Readme, NamesBothCommands) {
  std::ifstream file(CAIRN_SOURCE_DIR "/README.md");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find("./cairn demo"), std::string::npos);
  EXPECT_NE(text.find("./cairn test"), std::string::npos);
}

}  // namespace
