// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <filesystem>
#include <random>
#include <set>

#include "fuzz/all_types.hpp"
#include "procs/spy/catalogue.hpp"
#include "spy/messages.hpp"

namespace cairn::spy {
namespace {

template <class... Messages>
struct Fingerprints {
  static std::map<std::string, std::uint64_t> get() {
    return {{Messages::getTypeName(), static_cast<std::uint64_t>(Messages::getHash())}...};
  }
};

TEST(EmbeddedSchema, FingerprintsOfAllTypesAreThoseOfTheGeneratedDecoders) {
  std::map<std::string, std::uint64_t> ours;
  for (const auto& [name, type] : schema().types()) ours[name] = type.fingerprint;
  EXPECT_EQ(ours, testing::AllTypes<Fingerprints>::get());
}

TEST(EmbeddedSchema, FindsTheTypeOfEveryChannelByNameAndFingerprint) {
  bus::for_each_channel([](auto channel) {
    using Channel = decltype(channel);
    const CatalogueEntry* entry = catalogue_entry(Channel::name);
    ASSERT_NE(entry, nullptr) << Channel::name;
    const MessageType* type = schema().find(entry->type);
    ASSERT_NE(type, nullptr) << Channel::name;
    EXPECT_EQ(schema().find(static_cast<std::uint64_t>(Channel::type::getHash())), type);
  });
  EXPECT_EQ(catalogue_entry("NO_SUCH_CHANNEL"), nullptr);
  EXPECT_EQ(schema().find("no_such_t"), nullptr);
  EXPECT_EQ(schema().find(std::uint64_t{1}), nullptr);
}

TEST(EmbeddedSchema, KnowsUnitsAndNamesOfValues) {
  const MessageType& pose = *schema().find("pose_t");
  const auto field_of = [&](const std::string& name) {
    for (const Field& field : pose.fields) {
      if (field.name == name) return field;
    }
    return Field{};
  };
  EXPECT_EQ(field_of("correction_utime").unit, "us");
  EXPECT_EQ(field_of("epoch").unit, "");
  EXPECT_EQ(field_of("state").value_family, "STATE_");
  EXPECT_EQ(pose.value_name("STATE_", 2), "TRACKING");
  EXPECT_EQ(pose.value_name("STATE_", 9), "");
  EXPECT_EQ(pose.value_name("", 2), "");
}

TEST(Catalogue, KnowsWhichChannelsShouldNeverFallSilent) {
  for (const char* channel : {"STEREO_FRAME", "POSE", "CALIBRATION", "PROCESS_STATUS"})
    EXPECT_TRUE(catalogue_entry(channel)->steady) << channel;
  for (const char* channel : {"LOG_LINE", "GOAL", "STOP", "KEYFRAME_POSES"})
    EXPECT_FALSE(catalogue_entry(channel)->steady) << channel;
}

Result<Schema> parse(const std::string& text) {
  const std::vector<SchemaFile> files{{"a.lcm", text}};
  return Schema::parse(files);
}

TEST(SchemaParser, ReadsAllThatTheLanguageHas) {
  const auto schema = parse(
      "/* a block\n comment */ package some.where;\n"
      "struct a_t {\n"
      "  const int32_t ONE = 1, TWO = 0x2;  // numbers\n"
      "  const double HALF = 0.5;\n"
      "  int16_t x, y;  // both [m]\n"
      "  int8_t n;\n"
      "  b_t grid[n][3];\n"
      "}\n"
      "struct b_t { }\n");
  ASSERT_TRUE(schema) << schema.error().message;
  const MessageType& a = *schema->find("a_t");
  ASSERT_EQ(a.fields.size(), 4u);
  EXPECT_EQ(a.fields[0].unit, "m");
  EXPECT_EQ(a.fields[1].unit, "m");
  EXPECT_EQ(a.fields[3].dimensions[0].count_field, 2u);
  EXPECT_EQ(a.fields[3].dimensions[1].size, 3);
  EXPECT_EQ(a.constants,
            (std::vector<std::pair<std::string, std::int64_t>>{{"ONE", 1}, {"TWO", 2}}));
}

TEST(SchemaParser, SaysWhereTheFaultIs) {
  const auto message_of = [](const std::string& text) {
    const auto parsed = parse(text);
    return parsed ? "" : parsed.error().message;
  };
  EXPECT_EQ(message_of("struct a_t {\n  int8_t;\n}\n"),
            "a.lcm:3: a field's name should stand here, not '}'");
  EXPECT_EQ(message_of("struct a_t {\n  double x[n];\n}\n"),
            "a.lcm:2: a number or an integer field before this one should stand here, not 'n'");
  EXPECT_EQ(message_of("struct a_t {\n  double x[0];\n}\n"),
            "a.lcm:2: a size must be positive, not '0'");
  EXPECT_EQ(message_of("struct a_t {\n  b_t b;\n}\n"), "a_t.b: there is no type b_t");
  EXPECT_EQ(message_of("struct a_t { }\nstruct a_t { }\n"), "a.lcm: a second type a_t");
  EXPECT_EQ(message_of("struct a_t {\n"), "a.lcm:1: '}' is missing, but the file ends");
}

TEST(SchemaParser, SurvivesDamagedFiles) {
  constexpr unsigned kSeed = 11;
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  const std::vector<SchemaFile> whole = embedded_files();
  int refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<SchemaFile> files = whole;
    std::string& text = files[random() % files.size()].text;
    for (std::size_t faults = 1 + random() % 6; faults > 0; --faults) {
      const std::size_t at = random() % text.size();
      switch (random() % 3) {
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text.erase(at, 1 + random() % 20);
          text += ' ';
          break;
        default:
          text.insert(at, text.substr(random() % text.size(), 20));
      }
    }
    const auto parsed = Schema::parse(files);
    if (parsed) continue;
    ++refused;
    EXPECT_FALSE(parsed.error().message.empty());
  }
  EXPECT_GT(refused, 500);
}

}  // namespace
}  // namespace cairn::spy
