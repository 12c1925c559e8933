// SPDX-License-Identifier: Apache-2.0
#include "house/source_tree.hpp"

#include <gtest/gtest.h>

namespace cairn::house {
namespace {

TEST(SourceTree, CommentsAreNoCode) {
  EXPECT_EQ(code_of("a; // b\nc; /* d\n e */ f;"), "a;     \nc;     \n      f;");
}

TEST(SourceTree, LiteralsAreNoCodeButIncludesAre) {
  EXPECT_EQ(code_of("f(\"a\\\"b\", 'c');"), "f(      ,    );");
  EXPECT_EQ(code_of("#include \"a/b.hpp\"\n"), "#include \"a/b.hpp\"\n");
  EXPECT_EQ(code_of("f(R\"x(a \" // b)x\");"), "f(               );");
}

TEST(SourceTree, AQuoteBetweenDigitsBeginsNoLiteral) {
  EXPECT_EQ(code_of("n = 1'000; m = 2'000;"), "n = 1'000; m = 2'000;");
}

TEST(SourceTree, AnUnclosedCommentOrLiteralEndsWithTheFile) {
  EXPECT_EQ(code_of("a /* b"), "a     ");
  EXPECT_EQ(code_of("a \"b\\"), "a    ");
  EXPECT_EQ(code_of("a R\"("), "a    ");
}

TEST(SourceTree, AFileBelongsToItsTopTwoFolders) {
  EXPECT_EQ(folder_of("lib/stereo/sgm/cost.cpp"), "lib/stereo");
  EXPECT_EQ(folder_of("lib/CMakeLists.txt"), "");
  EXPECT_EQ(folder_of("README.md"), "");
}

TEST(SourceTree, TheProjectIsReadWhole) {
  const SourceTree tree = read_source_tree(CAIRN_SOURCE_DIR);
  EXPECT_TRUE(tree.contains("CMakeLists.txt"));
  EXPECT_TRUE(tree.contains("lib/core/result.hpp"));
  EXPECT_TRUE(tree.contains("lcmtypes/header_t.lcm"));
  EXPECT_TRUE(tree.contains("tests/house/source_tree_test.cpp"));
}

}  // namespace
}  // namespace cairn::house
