// SPDX-License-Identifier: Apache-2.0
#include "mapping/map_journal.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <iterator>
#include <random>

#include "mapping/corruption.hpp"
#include "mapping/made_maps.hpp"
#include "temporary_folder.hpp"

namespace cairn::mapping {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr HostTime kSecond = kMicrosecondsPerSecond;

MapInfo info_at(int step) { return {99, 1000 * step}; }
Bytes state_at(int step) {
  return Bytes(static_cast<std::size_t>(step % 7), static_cast<std::uint8_t>(step));
}

/// The map's history: the evidence that comes in at a step.
void advance(VoxelMap& map, int step) {
  std::mt19937 random{static_cast<unsigned>(1000 + step)};
  testing::add_random_evidence(map, random, 3, 4);
}

VoxelMap map_at(int step) {
  VoxelMap map{0.05};
  for (int i = 1; i <= step; ++i) advance(map, i);
  return map;
}

Bytes bytes_of(const std::filesystem::path& path) {
  std::ifstream file{path, std::ios::binary};
  return {std::istreambuf_iterator<char>{file}, std::istreambuf_iterator<char>{}};
}

void put_bytes(const std::filesystem::path& path, std::span<const std::uint8_t> bytes) {
  std::ofstream file{path, std::ios::binary | std::ios::trunc};
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

/// Recovers and checks that this is exactly some step of the history; gives the step.
int recovered_step(const std::filesystem::path& map_file, std::string* note = nullptr) {
  const auto recovered = recover_map(map_file, {});
  if (!recovered || !*recovered) {
    ADD_FAILURE() << (recovered ? "no map" : recovered.error().message);
    return -1;
  }
  const int step = static_cast<int>((*recovered)->info.last_utime / 1000);
  EXPECT_EQ(encode_map((*recovered)->map, (*recovered)->info),
            encode_map(map_at(step), info_at(step)));
  if ((*recovered)->records > 0) {
    EXPECT_EQ((*recovered)->state, state_at(step));
  }
  if (note != nullptr) *note = (*recovered)->note;
  return step;
}

class MapJournalTest : public ::testing::Test {
 protected:
  /// Saves step `first` and appends the steps up to `last`.
  MapJournal journal(VoxelMap& map, int first, int last) {
    for (int i = 1; i <= first; ++i) advance(map, i);
    auto started = MapJournal::start(file_, map, info_at(first), state_at(first));
    EXPECT_TRUE(started) << started.error().message;
    for (int i = first + 1; i <= last; ++i) append(*started, map, i);
    return std::move(*started);
  }
  void append(MapJournal& to, VoxelMap& map, int step) {
    advance(map, step);
    const auto appended = to.append(map, info_at(step), state_at(step), step * kSecond);
    ASSERT_TRUE(appended) << appended.error().message;
    EXPECT_TRUE(*appended);
  }

  cairn::testing::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "map.cairn";
  std::filesystem::path journal_ = journal_path(file_);
};

TEST_F(MapJournalTest, NothingIsFoundWhereNothingWasSaved) {
  const auto recovered = recover_map(file_, {});
  ASSERT_TRUE(recovered);
  EXPECT_FALSE(recovered->has_value());
}

TEST_F(MapJournalTest, FileAndJournalGiveBackTheMapAsLastAppended) {
  for (const int last : {5, 6, 12}) {
    VoxelMap map{0.05};
    const MapJournal open = journal(map, 5, last);
    EXPECT_EQ(open.bytes(), std::filesystem::file_size(journal_));
    std::string note;
    EXPECT_EQ(recovered_step(file_, &note), last);
    EXPECT_EQ(note, "");
  }
}

TEST_F(MapJournalTest, AppendsAtMostOnceASecond) {
  VoxelMap map{0.05};
  MapJournal open = journal(map, 1, 1);
  advance(map, 2);
  EXPECT_EQ(open.append(map, info_at(2), state_at(2), 10 * kSecond).value(), true);
  advance(map, 3);
  EXPECT_EQ(open.append(map, info_at(3), state_at(3), 11 * kSecond - 1).value(), false);
  EXPECT_FALSE(map.dirty_bricks().empty());
  EXPECT_EQ(recovered_step(file_), 2);
  EXPECT_EQ(open.append(map, info_at(3), state_at(3), 11 * kSecond).value(), true);
  EXPECT_EQ(recovered_step(file_), 3);
}

TEST_F(MapJournalTest, ARecordTornAtAnyByteCostsOnlyItself) {
  VoxelMap map{0.05};
  MapJournal open = journal(map, 2, 4);
  const std::size_t whole = open.bytes();
  append(open, map, 5);
  const Bytes bytes = bytes_of(journal_);
  ASSERT_GT(bytes.size(), whole);
  const Bytes step_4 = encode_map(map_at(4), info_at(4));
  for (std::size_t cut = whole; cut < bytes.size(); ++cut) {
    put_bytes(journal_, std::span{bytes}.first(cut));
    const auto recovered = recover_map(file_, {});
    ASSERT_TRUE(recovered && *recovered);
    ASSERT_EQ((*recovered)->info, info_at(4)) << "cut at " << cut;
    ASSERT_EQ((*recovered)->note.empty(), cut == whole);
    if (cut % 64 != 0) continue;
    ASSERT_EQ(encode_map((*recovered)->map, (*recovered)->info), step_4);
  }
}

TEST_F(MapJournalTest, AfterRecoveryANewJournalGoesOn) {
  {
    VoxelMap map{0.05};
    const MapJournal open = journal(map, 2, 6);
  }
  std::filesystem::resize_file(journal_, std::filesystem::file_size(journal_) - 3);
  auto recovered = recover_map(file_, {});
  ASSERT_TRUE(recovered && *recovered);
  EXPECT_NE((*recovered)->note.find(journal_.string()), std::string::npos);
  VoxelMap& map = (*recovered)->map;
  auto open = MapJournal::start(file_, map, (*recovered)->info, (*recovered)->state);
  ASSERT_TRUE(open);
  EXPECT_EQ(recovered_step(file_), 5);
  append(*open, map, 6);
  EXPECT_EQ(recovered_step(file_), 6);
}

TEST_F(MapJournalTest, FoldingTheJournalIntoTheFileLosesNothingWhereverItStops) {
  VoxelMap map{0.05};
  MapJournal open = journal(map, 1, 5);
  const Bytes old_file = bytes_of(file_);
  const Bytes old_journal = bytes_of(journal_);
  advance(map, 6);
  auto folded = MapJournal::start(file_, map, info_at(6), state_at(6));
  ASSERT_TRUE(folded);
  open = std::move(*folded);
  EXPECT_TRUE(map.dirty_bricks().empty());
  EXPECT_LT(open.bytes(), old_journal.size());
  const Bytes new_file = bytes_of(file_);
  const Bytes new_journal = bytes_of(journal_);
  const std::filesystem::path next = journal_.string() + ".next";
  EXPECT_FALSE(std::filesystem::exists(next));

  // Killed after the next journal was written; then after the map file was replaced.
  put_bytes(next, new_journal);
  put_bytes(journal_, old_journal);
  put_bytes(file_, old_file);
  EXPECT_EQ(recovered_step(file_), 5);
  put_bytes(file_, new_file);
  EXPECT_EQ(recovered_step(file_), 6);

  put_bytes(journal_, new_journal);
  append(open, map, 7);
  EXPECT_EQ(recovered_step(file_), 7);
}

TEST_F(MapJournalTest, AJournalOfAnotherFileIsPassedOver) {
  VoxelMap map{0.05};
  const MapJournal open = journal(map, 2, 4);
  ASSERT_TRUE(save_map(file_, map_at(9), info_at(9)));
  std::string note;
  EXPECT_EQ(recovered_step(file_, &note), 9);
  EXPECT_NE(note.find("does not belong"), std::string::npos) << note;
  std::filesystem::remove(journal_);
  EXPECT_EQ(recovered_step(file_), 9);
}

TEST_F(MapJournalTest, ADamagedMapFileIsAnError) {
  VoxelMap map{0.05};
  const MapJournal open = journal(map, 2, 4);
  Bytes bytes = bytes_of(file_);
  bytes[bytes.size() / 2] ^= 1;
  put_bytes(file_, bytes);
  const auto recovered = recover_map(file_, {});
  ASSERT_FALSE(recovered);
  EXPECT_NE(recovered.error().message.find("map.cairn"), std::string::npos);
}

TEST_F(MapJournalTest, TwoThousandCorruptionsGiveBackSomeWholeStep) {
  const unsigned seed = 51;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random{seed};
  VoxelMap map{0.05};
  const MapJournal open = journal(map, 1, 6);
  const Bytes bytes = bytes_of(journal_);
  std::vector<Bytes> steps;
  for (int step = 0; step <= 6; ++step) steps.push_back(encode_map(map_at(step), info_at(step)));
  for (int i = 0; i < 2000; ++i) {
    put_bytes(journal_, testing::corrupted(bytes, random));
    const auto recovered = recover_map(file_, {});
    ASSERT_TRUE(recovered && *recovered) << "corruption " << i;
    const auto step = static_cast<std::size_t>((*recovered)->info.last_utime / 1000);
    ASSERT_LT(step, steps.size());
    ASSERT_EQ(encode_map((*recovered)->map, (*recovered)->info), steps[step]) << "corruption " << i;
  }
}

TEST_F(MapJournalTest, AFullDiskIsAnErrorThatLosesNothingAlreadyWritten) {
  VoxelMap map{0.05};
  MapJournal open = journal(map, 2, 4);
  const std::size_t whole = open.bytes();
  advance(map, 5);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{whole + 100, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
  const auto appended = open.append(map, info_at(5), state_at(5), 100 * kSecond);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  std::signal(SIGXFSZ, old_handler);
  ASSERT_FALSE(appended);
  EXPECT_NE(appended.error().message.find(journal_.string()), std::string::npos);
  EXPECT_FALSE(map.dirty_bricks().empty());
  EXPECT_EQ(open.bytes(), whole);
  EXPECT_EQ(recovered_step(file_), 4);
  EXPECT_EQ(open.append(map, info_at(5), state_at(5), 101 * kSecond).value(), true);
  std::string note;
  EXPECT_EQ(recovered_step(file_, &note), 5);
  EXPECT_EQ(note, "");
}

TEST_F(MapJournalTest, AKilledProcessLosesOnlyWhatCameAfterItsLastAppend) {
  for (const int acknowledged_steps : {1, 7, 25}) {
    int channel[2];
    ASSERT_EQ(::pipe(channel), 0);
    const pid_t child = ::fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      VoxelMap map{0.05};
      auto open = MapJournal::start(file_, map, info_at(0), state_at(0));
      for (int step = 1; open; ++step) {
        advance(map, step);
        if (!open->append(map, info_at(step), state_at(step), step * kSecond)) break;
        if (step % 10 == 0) open = MapJournal::start(file_, map, info_at(step), state_at(step));
        const char done = 1;
        if (::write(channel[1], &done, 1) != 1) break;
      }
      ::_exit(1);
    }
    ::close(channel[1]);
    char done = 0;
    for (int i = 0; i < acknowledged_steps; ++i) ASSERT_EQ(::read(channel[0], &done, 1), 1);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    int written = acknowledged_steps;
    while (::read(channel[0], &done, 1) == 1) ++written;
    ::close(channel[0]);
    const int step = recovered_step(file_);
    EXPECT_GE(step, written);
    EXPECT_LE(step, written + 1);
  }
}

}  // namespace
}  // namespace cairn::mapping
