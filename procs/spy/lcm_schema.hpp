// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/result.hpp"

namespace cairn::spy {

/// One .lcm file: its name, for error messages, and its text.
struct SchemaFile {
  std::string name;
  std::string text;
};

enum class Primitive { kInt8, kInt16, kInt32, kInt64, kByte, kBoolean, kFloat, kDouble, kString };

/// One pair of brackets: a number, or the integer field before it that says how many.
struct Dimension {
  std::string text;                        ///< as the file says it
  std::int32_t size = 0;                   ///< where it is a number
  std::optional<std::size_t> count_field;  ///< index in the same type, where it is not
};

struct Field {
  std::string name;
  std::string type;
  std::optional<Primitive> primitive;  ///< nothing where `type` is another message type
  std::vector<Dimension> dimensions;
  std::string unit;          ///< from the comment's "[unit]"; empty for none or "-"
  std::string value_family;  ///< "STATE_" where the comment says "one of STATE_*"
};

struct MessageType {
  std::string name;
  std::vector<Field> fields;
  std::vector<std::pair<std::string, std::int64_t>> constants;  ///< integers only
  std::uint64_t fingerprint = 0;                                ///< as lcm-gen computes it

  /// "TRACKING" for 2 in the family "STATE_"; empty for a value without a name.
  [[nodiscard]] std::string value_name(const std::string& family, std::int64_t value) const;
};

/// Message types as .lcm files say them, read at run time.
class Schema {
 public:
  /// All types of the files together; an error names the file and the line. Dimensions that are
  /// named constants are refused.
  [[nodiscard]] static Result<Schema> parse(std::span<const SchemaFile> files);

  /// Null where there is none.
  [[nodiscard]] const MessageType* find(std::string_view name) const;

  /// The first by name with this fingerprint. Types of equal fields have equal fingerprints.
  [[nodiscard]] const MessageType* find(std::uint64_t fingerprint) const;

  [[nodiscard]] const std::map<std::string, MessageType, std::less<>>& types() const {
    return types_;
  }

 private:
  std::map<std::string, MessageType, std::less<>> types_;
};

}  // namespace cairn::spy
