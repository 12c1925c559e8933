// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/field_tree.hpp"

#include <algorithm>
#include <bit>
#include <charconv>

#include "procs/spy/printable.hpp"
#include "procs/spy/wire_reader.hpp"

namespace cairn::spy {
namespace {

constexpr std::size_t kFingerprintSize = 8;
constexpr std::int64_t kShownNumbers = 8;
constexpr std::int64_t kShownTypes = 32;
constexpr std::int64_t kLargestWholeArray = 64;
constexpr std::size_t kLongestText = 1000;
constexpr int kDeepest = 16;

std::size_t size_of(Primitive primitive) {
  switch (primitive) {
    case Primitive::kInt16:
      return 2;
    case Primitive::kInt32:
    case Primitive::kFloat:
      return 4;
    case Primitive::kInt64:
    case Primitive::kDouble:
      return 8;
    case Primitive::kInt8:
    case Primitive::kByte:
    case Primitive::kBoolean:
    case Primitive::kString:
      break;
  }
  return 1;
}

/// The double that reads like the float: 0.1, not 0.10000000149.
double like(float value) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof(digits), value).ptr;
  double result = value;
  std::from_chars(digits, end, result);
  return result;
}

Json json_of(Primitive primitive, std::uint64_t bits, std::int64_t value) {
  switch (primitive) {
    case Primitive::kFloat:
      return like(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    case Primitive::kDouble:
      return std::bit_cast<double>(bits);
    case Primitive::kBoolean:
      return bits != 0;
    case Primitive::kByte:
      return bits;
    default:
      return value;
  }
}

/// Goes through a message once, field by field; builds JSON where it is asked to.
class Walk {
 public:
  Walk(const Schema& schema, std::span<const std::uint8_t> bytes)
      : schema_{schema}, reader_{bytes}, visits_left_{1000 + 16 * bytes.size()} {}

  /// Null `into`: only checked.
  Result<void> message(const MessageType& type, Json* into) {
    const auto fingerprint = reader_.unsigned_integer(kFingerprintSize);
    if (!fingerprint) return fail("too short for a message");
    if (*fingerprint != type.fingerprint) return fail("not a " + type.name + ": wrong fingerprint");
    if (auto walked = fields(type, into, 0); !walked)
      return fail(type.name + walked.error().message);
    if (reader_.left() > 0)
      return fail(type.name + ": " + std::to_string(reader_.left()) + " bytes too many");
    return {};
  }

 private:
  Result<void> fields(const MessageType& type, Json* into, int depth) {
    if (depth > kDeepest) return fail(": types nested too deeply");
    std::vector<std::int64_t> integers(type.fields.size());
    if (into != nullptr) *into = Json::object();
    for (std::size_t i = 0; i < type.fields.size(); ++i) {
      const Field& field = type.fields[i];
      Json value;
      Json* const wanted = into == nullptr ? nullptr : &value;
      if (auto walked = dimension(field, 0, integers, wanted, depth); !walked)
        return fail("." + field.name + walked.error().message);
      integers[i] = last_integer_;
      if (into != nullptr) (*into)[field.name] = std::move(value);
    }
    return {};
  }

  Result<void> dimension(const Field& field, std::size_t index,
                         const std::vector<std::int64_t>& integers, Json* into, int depth) {
    if (visits_left_-- == 0) return fail(": more elements than its bytes can hold");
    if (index == field.dimensions.size()) return element(field, into, depth);
    const Dimension& size = field.dimensions[index];
    const std::int64_t count = size.count_field ? integers[*size.count_field] : size.size;
    if (count < 0) return fail(": a count of " + std::to_string(count));
    if (static_cast<std::uint64_t>(count) > reader_.left() && size.count_field)
      return fail(": " + std::to_string(count) + " elements in " + std::to_string(reader_.left()) +
                  " bytes");
    const bool last = index + 1 == field.dimensions.size();
    if (last && field.primitive && field.primitive != Primitive::kString)
      return numbers(field, size, static_cast<std::size_t>(count), into);
    const std::int64_t shown_count = shown(field, size, count);
    Json elements = Json::array();
    for (std::int64_t i = 0; i < count; ++i) {
      Json value;
      const bool wanted = into != nullptr && i < shown_count;
      auto walked = dimension(field, index + 1, integers, wanted ? &value : nullptr, depth);
      if (!walked) return fail("[" + std::to_string(i) + "]" + walked.error().message);
      if (wanted) elements.push_back(std::move(value));
    }
    if (into != nullptr) *into = array(size, count, shown_count, std::move(elements));
    return {};
  }

  /// A row of numbers; those that are not shown are passed over at once.
  Result<void> numbers(const Field& field, const Dimension& size, std::size_t count, Json* into) {
    const std::size_t bytes = count * size_of(*field.primitive);
    if (bytes > reader_.left()) return cut_short();
    if (into == nullptr || field.primitive == Primitive::kByte) {
      if (into != nullptr) *into = Json{{"bytes", count}};
      (void)reader_.skip(bytes);
      return {};
    }
    const std::int64_t shown_count = shown(field, size, static_cast<std::int64_t>(count));
    Json elements = Json::array();
    for (std::int64_t i = 0; i < shown_count; ++i) {
      Json value;
      if (auto walked = element(field, &value, 0); !walked) return walked;
      elements.push_back(std::move(value));
    }
    (void)reader_.skip(bytes - static_cast<std::size_t>(shown_count) * size_of(*field.primitive));
    *into = array(size, static_cast<std::int64_t>(count), shown_count, std::move(elements));
    return {};
  }

  Result<void> element(const Field& field, Json* into, int depth) {
    if (!field.primitive) return fields(*schema_.find(field.type), into, depth + 1);
    if (field.primitive == Primitive::kString) {
      const auto text = reader_.text();
      if (!text) return cut_short();
      if (into != nullptr) *into = shortened(printable(*text), kLongestText);
      return {};
    }
    const std::size_t size = size_of(*field.primitive);
    WireReader same = reader_;
    const auto bits = reader_.unsigned_integer(size);
    const auto value = same.signed_integer(size);
    if (!bits || !value) return cut_short();
    last_integer_ = *value;
    if (into != nullptr) *into = json_of(*field.primitive, *bits, *value);
    return {};
  }

  static std::int64_t shown(const Field& field, const Dimension& size, std::int64_t count) {
    if (!size.count_field && count <= kLargestWholeArray) return count;
    return std::min(count, field.primitive ? kShownNumbers : kShownTypes);
  }

  static Json array(const Dimension& size, std::int64_t count, std::int64_t shown_count,
                    Json elements) {
    if (!size.count_field && shown_count == count) return elements;
    return Json{{"count", count}, {"first", std::move(elements)}};
  }

  static tl::unexpected<Error> cut_short() { return fail(": the message ends before it"); }

  const Schema& schema_;
  WireReader reader_;
  std::size_t visits_left_;
  std::int64_t last_integer_ = 0;
};

}  // namespace

Result<void> check_message(const Schema& schema, const MessageType& type,
                           std::span<const std::uint8_t> bytes) {
  return Walk(schema, bytes).message(type, nullptr);
}

Result<Json> read_message(const Schema& schema, const MessageType& type,
                          std::span<const std::uint8_t> bytes) {
  Json fields;
  if (auto walked = Walk(schema, bytes).message(type, &fields); !walked)
    return tl::make_unexpected(walked.error());
  return fields;
}

}  // namespace cairn::spy
