// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/field_tree.hpp"

#include <gtest/gtest.h>

#include <random>

#include "fuzz/all_types.hpp"
#include "fuzz/lcm_schema.hpp"
#include "procs/spy/field_lines.hpp"
#include "spy/messages.hpp"

namespace cairn::spy {
namespace {

template <class Message>
Json fields_of(const Message& message) {
  return read_message(schema(), *schema().find(Message::getTypeName()), bytes_of(message)).value();
}

template <class Message>
std::string text_of(const Message& message) {
  std::string text;
  for (const std::string& line :
       field_lines(schema(), *schema().find(Message::getTypeName()), fields_of(message))) {
    text += line + "\n";
  }
  return text;
}

pose_t pose() {
  pose_t pose{};
  pose.header = {};
  pose.header.utime = 1'500'000;
  pose.header.sequence = 7;
  pose.T_map_body.position_m[0] = 1.25;
  pose.T_map_body.position_m[2] = -0.1;
  pose.T_map_body.orientation_xyzw[3] = 1;
  pose.epoch = -3;
  pose.state = pose_t::STATE_TRACKING;
  pose.covariance[35] = 0.5;
  return pose;
}

TEST(FieldTree, APoseAsJson) {
  const Json fields = fields_of(pose());
  EXPECT_EQ(fields["header"]["utime"], 1'500'000);
  EXPECT_EQ(fields["header"]["sequence"], 7);
  EXPECT_EQ(fields["T_map_body"]["position_m"], (Json{1.25, 0.0, -0.1}));
  EXPECT_EQ(fields["T_map_body"]["orientation_xyzw"], (Json{0.0, 0.0, 0.0, 1.0}));
  EXPECT_EQ(fields["epoch"], -3);
  EXPECT_EQ(fields["state"], 2);
  ASSERT_EQ(fields["covariance"].size(), 36u);
  EXPECT_EQ(fields["covariance"][35], 0.5);
  EXPECT_EQ(fields.begin().key(), "header");
}

TEST(FieldTree, APoseAsText) {
  const std::string text = text_of(pose());
  EXPECT_NE(text.find("header\n  utime           1500000 us\n"), std::string::npos) << text;
  EXPECT_NE(text.find("T_map_body\n  position_m        [1.25, 0, -0.1] m\n"), std::string::npos)
      << text;
  EXPECT_NE(text.find("\nstate             2 (TRACKING)\n"), std::string::npos) << text;
}

TEST(FieldTree, VariableArraysAreShortenedAndCounted) {
  particles_t particles{};
  particles.count = 1000;
  for (auto* values :
       {&particles.x_m, &particles.y_m, &particles.z_m, &particles.yaw_rad, &particles.weight}) {
    for (int i = 0; i < 1000; ++i) values->push_back(0.1F * static_cast<float>(i));
  }
  const Json fields = fields_of(particles);
  EXPECT_EQ(fields["x_m"]["count"], 1000);
  ASSERT_EQ(fields["x_m"]["first"].size(), 8u);
  EXPECT_EQ(fields["x_m"]["first"][1].dump(), "0.1");
  EXPECT_NE(text_of(particles).find("x_m      1000 x float [0, 0.1, 0.2, "), std::string::npos)
      << text_of(particles);
  particles_t none{};
  EXPECT_EQ(fields_of(none)["x_m"], (Json{{"count", 0}, {"first", Json::array()}}));
}

TEST(FieldTree, BytesAreShownAsTheirNumber) {
  stereo_frame_t frame{};
  frame.left_size = 3;
  frame.left = {1, 2, 3};
  EXPECT_EQ(fields_of(frame)["left"], (Json{{"bytes", 3}}));
  EXPECT_EQ(fields_of(frame)["right"], (Json{{"bytes", 0}}));
  EXPECT_NE(text_of(frame).find("left            3 bytes\n"), std::string::npos) << text_of(frame);
}

TEST(FieldTree, ArraysOfTypesAreShownOneByOne) {
  process_status_t status = process_status("mapper", 1);
  for (const char* name : {"one", "two"}) {
    counter_t counter{};
    counter.name = name;
    counter.value = 5;
    status.counters.push_back(counter);
  }
  status.counter_count = 2;
  const Json fields = fields_of(status);
  EXPECT_EQ(fields["counters"]["first"][1], (Json{{"name", "two"}, {"value", 5}}));
  EXPECT_NE(text_of(status).find("counters       2 x counter_t\n  [0]\n    name   \"one\"\n"),
            std::string::npos)
      << text_of(status);
  EXPECT_NE(text_of(status).find("health         1 (OK)\n"), std::string::npos);
}

TEST(FieldTree, TextCannotReachTheTerminal) {
  log_line_t line{};
  line.text = "a\x1b[2Jb\n\xff";
  EXPECT_EQ(fields_of(line)["text"], "a\\x1b[2Jb\\x0a\\xff");
  line.text = std::string(100'000, 'x');
  EXPECT_EQ(fields_of(line)["text"].get<std::string>().size(), 1000u);
}

TEST(FieldTree, SaysWhatDoesNotFit) {
  const MessageType& type = *schema().find("log_line_t");
  const auto message_of = [&](const std::vector<std::uint8_t>& bytes) {
    const auto checked = check_message(schema(), type, bytes);
    return checked ? "" : checked.error().message;
  };
  log_line_t line{};
  line.text = "hello";
  std::vector<std::uint8_t> bytes = bytes_of(line);
  EXPECT_EQ(message_of(bytes), "");
  bytes.push_back(0);
  EXPECT_EQ(message_of(bytes), "log_line_t: 1 bytes too many");
  bytes.resize(bytes.size() - 2);
  EXPECT_EQ(message_of(bytes), "log_line_t.text: the message ends before it");
  bytes.resize(20);
  EXPECT_EQ(message_of(bytes), "log_line_t.header.sent_steady_us: the message ends before it");
  EXPECT_EQ(message_of({1, 2, 3}), "too short for a message");
  EXPECT_EQ(message_of(bytes_of(pose())), "not a log_line_t: wrong fingerprint");
}

/// In a block of exactly their size, so that a sanitizer sees every step beyond.
std::vector<std::uint8_t> exactly(std::vector<std::uint8_t> bytes) {
  bytes.shrink_to_fit();
  return bytes;
}

template <class Message>
class DamagedMessage : public ::testing::Test {};
struct NameOfType {
  template <class Message>
  static std::string GetName(int) {
    return Message::getTypeName();
  }
};
TYPED_TEST_SUITE(DamagedMessage, testing::AllTypes<::testing::Types>, NameOfType);

TYPED_TEST(DamagedMessage, IsTakenExactlyWhereTheGeneratedDecoderTakesIt) {
  constexpr unsigned kSeed = 3;
  SCOPED_TRACE(kSeed);
  static const testing::LcmSchema kLayout(std::filesystem::path(CAIRN_SOURCE_DIR) / "lcmtypes");
  const MessageType& type = *schema().find(TypeParam::getTypeName());
  std::mt19937_64 random(kSeed);
  for (int trial = 0; trial < 2000; ++trial) {
    const auto sample = testing::random_sample(kLayout, type.name, TypeParam::getHash(), random);
    const auto other = testing::random_sample(kLayout, type.name, TypeParam::getHash(), random);
    ASSERT_TRUE(check_message(schema(), type, sample.bytes));
    const auto bytes = exactly(testing::mutant(sample, other, random));
    TypeParam message{};
    const int size = static_cast<int>(bytes.size());
    const bool decodes = message.decode(bytes.data(), 0, size) == size;
    ASSERT_EQ(check_message(schema(), type, bytes).has_value(), decodes) << "trial " << trial;
    const auto fields = read_message(schema(), type, bytes);
    ASSERT_EQ(fields.has_value(), decodes) << "trial " << trial;
    if (fields) (void)field_lines(schema(), type, *fields);
  }
}

TEST(FieldTree, TypesWithoutBytesCannotHoldItUp) {
  const std::vector<SchemaFile> files{{"a.lcm",
                                       "struct nothing_t { }\n"
                                       "struct a_t { int32_t n; nothing_t grid[n][n][n]; }\n"
                                       "struct chain_t { chain_t next; }\n"}};
  const Schema odd = Schema::parse(files).value();
  for (const char* name : {"a_t", "chain_t"}) {
    const MessageType& type = *odd.find(name);
    std::vector<std::uint8_t> bytes(4000);
    for (std::size_t i = 0; i < 8; ++i)
      bytes[i] = static_cast<std::uint8_t>(type.fingerprint >> (56 - 8 * i));
    bytes[10] = 0x0f;
    EXPECT_FALSE(read_message(odd, type, bytes)) << name;
  }
}

}  // namespace
}  // namespace cairn::spy
