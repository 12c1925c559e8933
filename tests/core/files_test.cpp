// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "core/atomic_file.hpp"
#include "core/state_folder.hpp"

namespace cairn {
namespace {

namespace fs = std::filesystem;

class Files : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("cairn-files-" + std::to_string(::getpid()) + "-" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static std::vector<std::uint8_t> bytes(const std::string& text) {
    return {text.begin(), text.end()};
  }

  fs::path folder_;
};

TEST_F(Files, AtomicWriteReplacesWholeAndLeavesNoTemporary) {
  const fs::path path = folder_ / "map";
  ASSERT_TRUE(write_file_atomically(path, bytes("old")));
  ASSERT_TRUE(write_file_atomically(path, bytes("newer")));
  EXPECT_EQ(read_file(path).value(), bytes("newer"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(Files, AtomicWriteIntoAMissingFolderNamesThePath) {
  const auto written = write_file_atomically(folder_ / "no" / "map", bytes("x"));
  ASSERT_FALSE(written);
  EXPECT_NE(written.error().message.find("no/map"), std::string::npos);
}

TEST_F(Files, TooLargeAFileIsRefusedWithItsSize) {
  const fs::path path = folder_ / "big";
  ASSERT_TRUE(write_file_atomically(path, std::vector<std::uint8_t>(100)));
  const auto read = read_file(path, 99);
  ASSERT_FALSE(read);
  EXPECT_NE(read.error().message.find("100 bytes"), std::string::npos);
}

TEST_F(Files, StateSurvivesAndTheNewestWins) {
  const StateFolder state = StateFolder::open(folder_ / "state").value();
  EXPECT_FALSE(state.load("pose"));
  for (const char* text : {"one", "two", "three"}) {
    ASSERT_TRUE(state.save("pose", bytes(text)));
    EXPECT_EQ(state.load("pose").value(), bytes(text));
  }
}

TEST_F(Files, ADamagedSlotFallsBackToTheOneBefore) {
  const StateFolder state = StateFolder::open(folder_).value();
  ASSERT_TRUE(state.save("pose", bytes("before")));
  ASSERT_TRUE(state.save("pose", bytes("last")));
  std::fstream(folder_ / "pose.b", std::ios::in | std::ios::out | std::ios::binary)
      .seekp(24)
      .put('X');
  EXPECT_EQ(state.load("pose").value(), bytes("before"));
}

TEST_F(Files, AStateFolderHasOneOwnerAtATime) {
  {
    const StateFolder first = StateFolder::open(folder_ / "state").value();
    const auto second = StateFolder::open(folder_ / "state");
    ASSERT_FALSE(second);
    EXPECT_NE(second.error().message.find("a process that is running"), std::string::npos);
  }
  EXPECT_TRUE(StateFolder::open(folder_ / "state"));
}

TEST_F(Files, WithoutAFolderNothingIsKept) {
  const StateFolder none;
  EXPECT_TRUE(none.save("pose", bytes("x")));
  EXPECT_FALSE(none.load("pose"));
}

}  // namespace
}  // namespace cairn
