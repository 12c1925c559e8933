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

template <class Message>
class Mutation : public ::testing::Test {
 protected:
  Mutation() { std::printf("seed %llu, %d mutants\n", kSeed, mutant_count()); }

  Sample sample() {
    return random_sample(schema(), Message::getTypeName(), Message::getHash(), rng_);
  }

  std::mt19937_64 rng_{kSeed};
};

struct NameOfType {
  template <class Message>
  static std::string GetName(int) {
    return Message::getTypeName();
  }
};
TYPED_TEST_SUITE(Mutation, AllTypes<::testing::Types>, NameOfType);

TYPED_TEST(Mutation, AWholeMessageComesBackByteForByte) {
  for (int i = 0; i < 200; ++i) {
    const Sample sample = this->sample();
    TypeParam message{};
    const int size = static_cast<int>(sample.bytes.size());
    ASSERT_EQ(message.decode(sample.bytes.data(), 0, size), size);
    ASSERT_TRUE(message.counts_agree());
    std::vector<std::uint8_t> again(sample.bytes.size());
    ASSERT_EQ(message.getEncodedSize(), size);
    ASSERT_EQ(message.encode(again.data(), 0, size), size);
    ASSERT_EQ(again, sample.bytes);
  }
}

TYPED_TEST(Mutation, DamagedBytesNeitherCrashNorThrowNorTakeMuchMemory) {
  Sample sample = this->sample();
  Sample other = this->sample();
  for (int i = 0; i < mutant_count(); ++i) {
    if (i % 64 == 0) {
      other = std::move(sample);
      sample = this->sample();
    }
    const ExactBlock block(mutant(sample, other, this->rng_));
    TypeParam message{};
    int decoded = 0;
    const std::size_t before = allocated_bytes();
    ASSERT_NO_THROW(decoded = message.decode(block.data(), 0, block.size())) << "mutant " << i;
    ASSERT_LE(allocated_bytes() - before,
              kMaxAllocated_per_byte * static_cast<std::size_t>(block.size()))
        << "mutant " << i;
    ASSERT_LE(decoded, block.size()) << "mutant " << i;
    if (decoded != block.size()) continue;
    ASSERT_TRUE(message.counts_agree()) << "mutant " << i;
    // A string may hold a zero byte in its midst and then is written shorter; never longer.
    const int size = message.getEncodedSize();
    ASSERT_EQ(size, block.size()) << "mutant " << i;
    std::vector<std::uint8_t> again(static_cast<std::size_t>(size));
    const int encoded = message.encode(again.data(), 0, size);
    ASSERT_GE(encoded, 0) << "mutant " << i;
    ASSERT_LE(encoded, size) << "mutant " << i;
  }
}

template <class... Messages>
struct NamesOf {
  static std::set<std::string> get() { return {Messages::getTypeName()...}; }
};

TEST(AllTypes, AreThoseOfTheLcmFiles) {
  std::set<std::string> files;
  for (const auto& [type, fields] : schema().types()) files.insert(type);
  EXPECT_EQ(AllTypes<NamesOf>::get(), files);
}

}  // namespace
}  // namespace cairn::testing
