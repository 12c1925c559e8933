// SPDX-License-Identifier: Apache-2.0
#include "bus/recording.hpp"

#include <gtest/gtest.h>

#include <iostream>
#include <random>

#include "bus/recording_bus.hpp"
#include "core/atomic_file.hpp"
#include "data_folder.hpp"
#include "temporary_folder.hpp"

namespace cairn::bus {
namespace {

constexpr int kEvents = 60;
constexpr std::size_t kEventHeader = 28;

class Recording : public ::testing::Test {
 protected:
  // Event i is on channel "CHANNEL_<i mod 3>" and holds 10 + i bytes, some of which look like a
  // sync word.
  void SetUp() override {
    path_ = folder_.path() / "log";
    auto writer = RecordingWriter::create(path_).value();
    std::size_t offset = 0;
    for (int i = 0; i < kEvents; ++i) {
      std::vector<std::uint8_t> bytes(static_cast<std::size_t>(10 + i),
                                      static_cast<std::uint8_t>(i));
      if (i % 5 == 0) bytes.insert(bytes.begin() + 3, {0xED, 0xA1, 0xDA, 0x01});
      const std::string channel = "CHANNEL_" + std::to_string(i % 3);
      ASSERT_TRUE(writer.write(1000 * i, channel, bytes));
      starts_.push_back(offset);
      offset += kEventHeader + channel.size() + bytes.size();
    }
    starts_.push_back(offset);
    ASSERT_TRUE(writer.flush());
    whole_ = read_file(path_).value();
    ASSERT_EQ(whole_.size(), offset);
  }

  struct Outcome {
    std::vector<int> events;
    std::uint64_t damaged_bytes = 0;
  };
  Outcome read(const std::vector<std::uint8_t>& bytes) {
    const auto path = folder_.path() / "damaged";
    EXPECT_TRUE(write_file_atomically(path, bytes));
    Outcome outcome;
    auto reader = RecordingReader::open(path);
    if (!reader) return outcome;
    while (const auto event = reader->next())
      outcome.events.push_back(static_cast<int>(event->recorded_us / 1000));
    outcome.damaged_bytes = reader->damaged_bytes();
    return outcome;
  }

  testing::TemporaryFolder folder_;
  std::filesystem::path path_;
  std::vector<std::uint8_t> whole_;
  std::vector<std::size_t> starts_;
};

TEST_F(Recording, AWholeOneIsReadWhole) {
  auto reader = RecordingReader::open(path_).value();
  for (int i = 0; i < kEvents; ++i) {
    const auto event = reader.next();
    ASSERT_TRUE(event);
    EXPECT_EQ(event->recorded_us, 1000 * i);
    EXPECT_EQ(event->message.channel, "CHANNEL_" + std::to_string(i % 3));
  }
  EXPECT_FALSE(reader.next());
  EXPECT_EQ(reader.damage(), "");
}

TEST_F(Recording, CutAnywhereEveryEventBeforeTheCutIsRead) {
  std::mt19937 random(7);
  for (int trial = 0; trial < 1000; ++trial) {
    const std::size_t cut = random() % whole_.size();
    auto bytes = whole_;
    bytes.resize(cut);
    std::vector<int> expected;
    for (int i = 0; i < kEvents && starts_[static_cast<std::size_t>(i) + 1] <= cut; ++i)
      expected.push_back(i);
    EXPECT_EQ(read(bytes).events, expected) << "cut at " << cut << ", seed 7";
  }
}

TEST_F(Recording, AFlippedBitCostsAtMostTheEventThatItIsIn) {
  std::mt19937 random(8);
  for (int trial = 0; trial < 1000; ++trial) {
    const std::size_t place = random() % whole_.size();
    auto bytes = whole_;
    bytes[place] = static_cast<std::uint8_t>(bytes[place] ^ (1U << random() % 8));
    const auto events = read(bytes).events;
    int next = 0;
    for (int i = 0; i < kEvents; ++i) {
      const auto index = static_cast<std::size_t>(i);
      if (place >= starts_[index] && place < starts_[index + 1]) continue;
      const auto found = std::find(events.begin() + next, events.end(), i);
      ASSERT_NE(found, events.end())
          << "event " << i << " is untouched, yet lost; byte " << place << ", seed 8";
      next = static_cast<int>(found - events.begin());
    }
  }
}

TEST_F(Recording, JunkBetweenEventsIsPassedOverAndCounted) {
  auto bytes = whole_;
  const std::vector<std::uint8_t> junk(100, 0xED);
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(starts_[10]), junk.begin(), junk.end());
  bytes.insert(bytes.end(), junk.begin(), junk.end());
  const Outcome outcome = read(bytes);
  EXPECT_EQ(outcome.events.size(), static_cast<std::size_t>(kEvents));
  EXPECT_EQ(outcome.damaged_bytes, 200U);
}

TEST_F(Recording, WhatIsNotARecordingIsSaidToBeNone) {
  ASSERT_TRUE(write_file_atomically(folder_.path() / "text", std::vector<std::uint8_t>(500, 'x')));
  EXPECT_NE(
      RecordingReader::open(folder_.path() / "text").error().message.find("holds no LCM event"),
      std::string::npos);
  EXPECT_NE(RecordingReader::open(folder_.path() / "none").error().message.find("cannot open"),
            std::string::npos);
  EXPECT_FALSE(RecordingReader::open(folder_.path()));
}

TEST_F(Recording, AnExistingOneIsNotWrittenOver) {
  EXPECT_NE(RecordingWriter::create(path_).error().message.find("exists already"),
            std::string::npos);
}

TEST_F(Recording, TheBusPlaysWhatWasSubscribedToAndWritesWhatIsPublished) {
  const auto out = folder_.path() / "out";
  const auto bus = open_recording_bus(path_, out).value();
  ASSERT_TRUE(bus->subscribe("CHANNEL_1"));
  std::vector<RawMessage> messages;
  while (!bus->ended()) {
    const std::size_t before = messages.size();
    bus->receive(0, messages);
    ASSERT_LE(messages.size(), before + 1);
    if (messages.size() == before) continue;
    ASSERT_TRUE(bus->publish("ANSWER", messages.back().bytes));
  }
  EXPECT_EQ(messages.size(), kEvents / 3U);
}

TEST(RecordingOfOthers, LcmsOwnExampleIsRead) {
  const auto data = testing::data_folder();
  if (!data) GTEST_SKIP() << "no recordings: set CAIRN_DATA to a folder with sequence/lcm_logs";
  auto reader = RecordingReader::open(*data / "sequence/lcm_logs/lcm_test_example.lcmlog").value();
  int events = 0;
  while (reader.next()) ++events;
  EXPECT_GT(events, 0);
  EXPECT_EQ(reader.damage(), "");
}

}  // namespace
}  // namespace cairn::bus
