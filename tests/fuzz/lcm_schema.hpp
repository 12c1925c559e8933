// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace cairn::testing {

/// One field of a message type: `type name[dimensions]`.
struct LcmField {
  std::string type;
  std::string name;
  std::vector<std::string> dimensions;  ///< each a number or the name of a count field

  [[nodiscard]] bool variable() const;
};

/// The message types as their .lcm files say, read without lcm-gen.
class LcmSchema {
 public:
  /// Reads all `folder`/*.lcm; throws std::runtime_error where a line is not understood.
  explicit LcmSchema(const std::filesystem::path& folder);

  [[nodiscard]] const std::map<std::string, std::vector<LcmField>>& types() const { return types_; }
  [[nodiscard]] bool is_struct(const std::string& type) const { return types_.contains(type); }

 private:
  std::map<std::string, std::vector<LcmField>> types_;
};

/// A message as bytes, and where in it lengths are said.
struct Sample {
  std::vector<std::uint8_t> bytes;
  std::vector<std::size_t> length_offsets;
};

/// A message of `type` filled at random: hash first, then its fields as LCM writes them.
[[nodiscard]] Sample random_sample(const LcmSchema& schema, const std::string& type,
                                   std::int64_t hash, std::mt19937_64& rng);

/// Damages a message: flips bits, forges lengths, cuts, extends, splices from `other`.
[[nodiscard]] std::vector<std::uint8_t> mutant(const Sample& sample, const Sample& other,
                                               std::mt19937_64& rng);

}  // namespace cairn::testing
