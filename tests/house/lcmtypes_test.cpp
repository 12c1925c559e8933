// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "house/lcm_types.hpp"

namespace cairn::house {
namespace {

Findings findings_of(const std::string& name, const std::string& text) {
  return message_type_findings({{"lcmtypes/" + name + ".lcm", text}});
}

TEST(MessageTypes, EveryFieldSaysItsUnit) {
  EXPECT_EQ(joined(message_type_findings(read_source_tree(CAIRN_SOURCE_DIR))), "");
}

TEST(MessageTypes, AGoodTypeIsNotComplainedAbout) {
  EXPECT_EQ(joined(findings_of("a_t",
                               "package cairn;\n// who sends it\nstruct a_t {\n"
                               "  const int8_t BAD = 1, GOOD = 2;\n"
                               "  header_t header;  // data time\n"
                               "  int32_t n;  // how many [-]\n"
                               "  double x[n][ 3 ] ;  // where [m]\n"
                               "  string name;  // of whom\n}\n")),
            "");
}

TEST(MessageTypes, AFieldWithoutACommentIsFound) {
  const std::string start = "package cairn;\nstruct a_t {\n  header_t header;  // when\n";
  EXPECT_EQ(findings_of("a_t", start + "  string name;\n}\n"),
            (Findings{"lcmtypes/a_t.lcm:4: a field without a comment"}));
  EXPECT_EQ(findings_of("a_t", start + "  string name;  //\n}\n"),
            (Findings{"lcmtypes/a_t.lcm:4: a field without a comment"}));
}

TEST(MessageTypes, ANumberWithoutAUnitIsFound) {
  EXPECT_EQ(findings_of("a_t",
                        "package cairn;\nstruct a_t {\n  header_t header;  // when\n"
                        "  double x[3];  // where\n}\n"),
            (Findings{"lcmtypes/a_t.lcm:4: a number without a [unit] in its comment"}));
}

TEST(MessageTypes, AMessageBeginsWithItsHeader) {
  const SourceTree tree{
      {"lcmtypes/a_t.lcm", "package cairn;\nstruct a_t {\n  b_t b;  // no header\n}\n"},
      {"lcmtypes/b_t.lcm", "package cairn;\nstruct b_t {\n  double x;  // a part [m]\n}\n"}};
  EXPECT_EQ(message_type_findings(tree),
            (Findings{"lcmtypes/a_t.lcm:1: a message's first field must be a header_t"}));
}

TEST(MessageTypes, AFileDefinesTheOneTypeOfItsName) {
  const std::string start = "package cairn;\nstruct a_t {\n  header_t header;  // when\n}\n";
  EXPECT_EQ(findings_of("b_t", start).size(), 1u);
  EXPECT_EQ(findings_of("a_t", start + "struct c_t {\n}\n").size(), 1u);
  EXPECT_EQ(findings_of("a_t", start.substr(start.find('\n') + 1)).size(), 1u);
}

}  // namespace
}  // namespace cairn::house
