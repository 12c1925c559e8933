// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <string>

namespace {

TEST(Readme, NamesBothCommands) {
  std::ifstream file(CAIRN_SOURCE_DIR "/README.md");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_TRUE(text.find("./cairn demo") != std::string::npos) << "README.md must name it";
  EXPECT_TRUE(text.find("./cairn test") != std::string::npos) << "README.md must name it";
}

}  // namespace
