// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "procs/spy/printable.hpp"
#include "procs/spy/quantities.hpp"
#include "procs/spy/text_table.hpp"

namespace cairn::spy {
namespace {

TEST(Printable, KeepsTextAndShowsEverythingElseAsNumbers) {
  EXPECT_EQ(printable("plain"), "plain");
  EXPECT_EQ(printable("\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80"),
            "\xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80");
  EXPECT_EQ(printable("\x1b[1m\x7f"), "\\x1b[1m\\x7f");
  EXPECT_EQ(printable("\xc2\x9b"), "\\xc2\\x9b");                    // a control character (CSI)
  EXPECT_EQ(printable("\xc0\xaf"), "\\xc0\\xaf");                    // overlong
  EXPECT_EQ(printable("\xed\xa0\x80"), "\\xed\\xa0\\x80");           // half of a pair
  EXPECT_EQ(printable("\xf4\x90\x80\x80"), "\\xf4\\x90\\x80\\x80");  // beyond Unicode
  EXPECT_EQ(printable("\xe2\x82"), "\\xe2\\x82");                    // cut short
}

TEST(Printable, IsPrintableWhateverTheBytes) {
  std::mt19937 random(9);
  for (int trial = 0; trial < 2000; ++trial) {
    std::string bytes(random() % 40, ' ');
    for (char& byte : bytes) byte = static_cast<char>(random());
    const std::string text = printable(bytes);
    EXPECT_EQ(printable(text), text);
  }
}

TEST(Shortened, CutsBetweenCharacters) {
  EXPECT_EQ(shortened("abcdef", 6), "abcdef");
  EXPECT_EQ(shortened("abcdefg", 6), "abc...");
  EXPECT_EQ(shortened("\xc3\xa9\xc3\xa9\xc3\xa9\xc3\xa9\xc3\xa9", 4), "\xc3\xa9...");
  EXPECT_EQ(shortened("abcdef", 2), "..");
  EXPECT_EQ(shortened("abcdef", 0), "");
}

TEST(Quantities, ReadLikePeopleWriteThem) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1000), "1,000");
  EXPECT_EQ(grouped(-1234567), "-1,234,567");
  EXPECT_EQ(bytes_text(512), "512 B");
  EXPECT_EQ(bytes_text(1234), "1.23 kB");
  EXPECT_EQ(bytes_text(45.6e6), "45.6 MB");
  EXPECT_EQ(bytes_text(7e9), "7.00 GB");
  EXPECT_EQ(duration_text(85), "85 us");
  EXPECT_EQ(duration_text(1234), "1.23 ms");
  EXPECT_EQ(duration_text(45.6e6), "45.6 s");
  EXPECT_EQ(duration_text(600e6), "10 min");
  EXPECT_EQ(duration_text(9000e6), "2.50 h");
  EXPECT_EQ(rate_text(29.97), "30.0");
  EXPECT_EQ(rate_text(1.0 / 30), "0.03");
}

TextTable table() {
  TextTable table({{"name"}, {"type", false, 2}, {"Hz", true, 1}});
  table.add({"POSE", "pose_t", "30.0"});
  table.add({"CLOCK", "clock_t", "100"});
  return table;
}

TEST(TextTable, AlignsItsColumns) {
  EXPECT_EQ(table().lines(),
            (std::vector<std::string>{"name   type       Hz", "POSE   pose_t   30.0",
                                      "CLOCK  clock_t   100"}));
}

TEST(TextTable, DropsWhatIsMostExpendableWhereItDoesNotFit) {
  EXPECT_EQ(table().lines(19),
            (std::vector<std::string>{"name     Hz", "POSE   30.0", "CLOCK   100"}));
  EXPECT_EQ(table().lines(10), (std::vector<std::string>{"name", "POSE", "CLOCK"}));
  EXPECT_EQ(table().lines(4), (std::vector<std::string>{"name", "POSE", "C..."}));
}

}  // namespace
}  // namespace cairn::spy
