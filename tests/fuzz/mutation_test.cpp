// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <memory>
#include <set>

#include "fuzz/all_types.hpp"
#include "fuzz/allocation_meter.hpp"
#include "fuzz/lcm_schema.hpp"
#include "fuzz/mutants.hpp"

namespace cairn::testing {
namespace {

/// A count is at most the bytes that are left, and no element of ours is larger than this.
constexpr std::size_t kMaxAllocated_per_byte = 256;

const LcmSchema& schema() {
  static const LcmSchema types(std::filesystem::path(CAIRN_SOURCE_DIR) / "lcmtypes");
  return types;
}

/// Bytes on the heap in a block of exactly their size, so that a sanitizer sees every step beyond.
class ExactBlock {
 public:
  explicit ExactBlock(const std::vector<std::uint8_t>& bytes)
      : block_(new std::uint8_t[bytes.size()]), size_(static_cast<int>(bytes.size())) {
    std::copy(bytes.begin(), bytes.end(), block_.get());
  }
  [[nodiscard]] const void* data() const { return block_.get(); }
  [[nodiscard]] int size() const { return size_; }

 private:
  std::unique_ptr<std::uint8_t[]> block_;
  int size_;
};

/// What became of some bytes that were decoded and, where they were a whole message, encoded again.
struct Outcome {
  int decoded = 0;
  std::size_t allocated_bytes = 0;
  bool counts_agree = false;
  int encoded_size = 0;
  int encoded = 0;
  std::vector<std::uint8_t> again;
};

template <class Message>
Outcome decode_and_encode(const ExactBlock& block) {
  Message message{};
  Outcome outcome;
  const std::size_t before = allocated_bytes();
  outcome.decoded = message.decode(block.data(), 0, block.size());
  outcome.allocated_bytes = allocated_bytes() - before;
  if (outcome.decoded != block.size()) return outcome;
  outcome.counts_agree = message.counts_agree();
  if (!outcome.counts_agree) return outcome;
  outcome.encoded_size = message.getEncodedSize();
  outcome.again.resize(static_cast<std::size_t>(outcome.encoded_size));
  outcome.encoded = message.encode(outcome.again.data(), 0, outcome.encoded_size);
  return outcome;
}

struct MessageType {
  const char* name;
  std::int64_t hash;
  Outcome (*decode_and_encode)(const ExactBlock&);

  friend std::ostream& operator<<(std::ostream& out, const MessageType& type) {
    return out << type.name;
  }
};

template <class... Messages>
struct ListOf {
  static std::vector<MessageType> get() {
    return {{Messages::getTypeName(), Messages::getHash(), decode_and_encode<Messages>}...};
  }
};

class Mutation : public ::testing::TestWithParam<MessageType> {
 protected:
  Sample sample() { return random_sample(schema(), GetParam().name, GetParam().hash, rng_); }
  static Outcome outcome_of(const std::vector<std::uint8_t>& bytes) {
    return GetParam().decode_and_encode(ExactBlock(bytes));
  }

  std::mt19937_64 rng_{kSeed};
};

TEST_P(Mutation, AWholeMessageComesBackByteForByte) {
  for (int i = 0; i < 200; ++i) {
    const Sample whole = sample();
    const Outcome outcome = outcome_of(whole.bytes);
    const int size = static_cast<int>(whole.bytes.size());
    ASSERT_EQ(outcome.decoded, size);
    ASSERT_TRUE(outcome.counts_agree);
    ASSERT_EQ(outcome.encoded_size, size);
    ASSERT_EQ(outcome.encoded, size);
    ASSERT_EQ(outcome.again, whole.bytes);
  }
}

TEST_P(Mutation, DamagedBytesNeitherCrashNorThrowNorTakeMuchMemory) {
  std::printf("seed %llu, %d mutants\n", kSeed, mutant_count());
  Sample whole = sample();
  Sample other = sample();
  for (int i = 0; i < mutant_count(); ++i) {
    if (i % 64 == 0) {
      other = std::move(whole);
      whole = sample();
    }
    const auto bytes = mutant(whole, other, rng_);
    const int size = static_cast<int>(bytes.size());
    Outcome outcome;
    ASSERT_NO_THROW(outcome = outcome_of(bytes)) << "mutant " << i;
    ASSERT_LE(outcome.allocated_bytes, kMaxAllocated_per_byte * bytes.size()) << "mutant " << i;
    ASSERT_LE(outcome.decoded, size) << "mutant " << i;
    if (outcome.decoded != size) continue;
    ASSERT_TRUE(outcome.counts_agree) << "mutant " << i;
    ASSERT_EQ(outcome.encoded_size, size) << "mutant " << i;
    // A string may hold a zero byte in its midst and then is written shorter; never longer.
    ASSERT_GE(outcome.encoded, 0) << "mutant " << i;
    ASSERT_LE(outcome.encoded, size) << "mutant " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(AllTypes, Mutation, ::testing::ValuesIn(AllTypes<ListOf>::get()),
                         [](const auto& type) { return std::string(type.param.name); });

TEST(AllTypes, AreThoseOfTheLcmFiles) {
  std::set<std::string> files;
  for (const auto& [type, fields] : schema().types()) files.insert(type);
  std::set<std::string> listed;
  for (const MessageType& type : AllTypes<ListOf>::get()) listed.insert(type.name);
  EXPECT_EQ(listed, files);
}

}  // namespace
}  // namespace cairn::testing
