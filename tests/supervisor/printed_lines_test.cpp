// SPDX-License-Identifier: Apache-2.0
#include "procs/supervisor/printed_lines.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "bus/log_format.hpp"
#include "procs/cli/output_lines.hpp"
#include "temporary_folder.hpp"

namespace cairn {
namespace {

using Lines = std::vector<std::string>;

class Printed : public ::testing::Test {
 protected:
  void print(const std::string& text) {
    std::ofstream(file_, std::ios::app | std::ios::binary) << text;
  }
  testing::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "log";
};

TEST_F(Printed, WholeLinesComeOnceAndWhatWasThereBeforeNever) {
  print("before\n");
  PrintedLines lines(file_);
  EXPECT_EQ(lines.take(), Lines{});
  print("one\ntwo\nthr");
  EXPECT_EQ(lines.take(), (Lines{"one", "two"}));
  print("ee\n");
  EXPECT_EQ(lines.take(), Lines{"three"});
}

TEST_F(Printed, AFileThatDoesNotExistYetOrIsEmptiedIsFollowedAllTheSame) {
  PrintedLines lines(file_);
  EXPECT_EQ(lines.take(), Lines{});
  print("first\n");
  EXPECT_EQ(lines.take(), Lines{"first"});
  std::ofstream{file_} << "x\n";
  EXPECT_EQ(lines.take(), Lines{"x"});
}

TEST_F(Printed, AFloodIsCutAndSaysSo) {
  PrintedLines lines(file_);
  std::string flood;
  for (int i = 0; i < 1'000; ++i) flood += "line " + std::to_string(i) + "\n";
  print(flood);
  const Lines taken = lines.take();
  ASSERT_EQ(taken.size(), 51U);
  EXPECT_EQ(taken.front(), "line 0");
  EXPECT_EQ(taken.back(), "and 950 lines more");
  print(std::string(10'000'000, 'y') + "\nlast\n");
  EXPECT_EQ(lines.take().back(), "last");
}

TEST_F(Printed, NoLineMovesATerminalOrIsEndless) {
  PrintedLines lines(file_);
  print("a\x1b[2Jb\r\tc\n" + std::string(5'000, 'z') + "\n");
  const Lines taken = lines.take();
  ASSERT_EQ(taken.size(), 2U);
  EXPECT_EQ(taken[0], "a [2Jb  c");
  EXPECT_EQ(taken[1].size(), PrintedLines::kLongestLine);
}

TEST_F(Printed, LogLinesAreKnownByTheirForm) {
  EXPECT_TRUE(bus::is_log_line("12:34:56.789 warning mapper: something"));
  EXPECT_FALSE(bus::is_log_line("terminate called after throwing an instance of 'int'"));
  EXPECT_FALSE(bus::is_log_line("12:34"));
  EXPECT_FALSE(bus::is_log_line(""));
}

TEST_F(Printed, TheLastLinesOfAFileAreThoseThatTailFinds) {
  std::string text;
  for (int i = 0; i < 30'000; ++i) text += "line number " + std::to_string(i) + "\n";
  print(text);
  EXPECT_EQ(cli::last_lines(file_, 2), (Lines{"line number 29998", "line number 29999"}));
  EXPECT_EQ(cli::last_lines(file_, 20'000).size(), 20'000U);
  EXPECT_EQ(cli::last_lines(file_, 20'000).front(), "line number 10000");
  EXPECT_EQ(cli::last_lines(file_, 50'000).size(), 30'000U);
  print("no end");
  EXPECT_EQ(cli::last_lines(file_, 1), Lines{"no end"});
  EXPECT_EQ(cli::last_lines(file_, 0), Lines{});
  EXPECT_EQ(cli::last_lines(folder_.path() / "none", 3), Lines{});
}

}  // namespace
}  // namespace cairn
