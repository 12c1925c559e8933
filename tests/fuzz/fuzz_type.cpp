// SPDX-License-Identifier: Apache-2.0
// A libFuzzer target for one message type; the build says which (CAIRN_FUZZ_TYPE,
// CAIRN_FUZZ_HEADER).
#include CAIRN_FUZZ_HEADER
#include <cstdint>
#include <cstdlib>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto hash = static_cast<std::uint64_t>(cairn::CAIRN_FUZZ_TYPE::getHash());
  std::vector<std::uint8_t> bytes;
  for (int shift = 56; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<std::uint8_t>(hash >> shift));
  }
  bytes.insert(bytes.end(), data, data + size);

  cairn::CAIRN_FUZZ_TYPE message{};
  const int total = static_cast<int>(bytes.size());
  if (message.decode(bytes.data(), 0, total) != total) return 0;
  if (!message.counts_agree() || message.getEncodedSize() != total) std::abort();
  if (message.encode(bytes.data(), 0, total) < 0) std::abort();
  return 0;
}
