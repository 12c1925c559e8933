// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/schema_parser.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>

#include "procs/spy/tokens.hpp"

namespace cairn::spy {
namespace {

constexpr std::array<std::pair<std::string_view, Primitive>, 9> kPrimitives{
    {{"int8_t", Primitive::kInt8},
     {"int16_t", Primitive::kInt16},
     {"int32_t", Primitive::kInt32},
     {"int64_t", Primitive::kInt64},
     {"byte", Primitive::kByte},
     {"boolean", Primitive::kBoolean},
     {"float", Primitive::kFloat},
     {"double", Primitive::kDouble},
     {"string", Primitive::kString}}};

std::optional<Primitive> primitive(std::string_view type) {
  for (const auto& [name, value] : kPrimitives) {
    if (name == type) return value;
  }
  return std::nullopt;
}

bool counts(const Field& field) {
  return field.dimensions.empty() &&
         (field.primitive == Primitive::kInt8 || field.primitive == Primitive::kInt16 ||
          field.primitive == Primitive::kInt32 || field.primitive == Primitive::kInt64);
}

template <class Integer>
std::optional<Integer> integer(std::string_view text) {
  const bool hex = text.starts_with("0x");
  if (hex) text.remove_prefix(2);
  Integer value{};
  const auto [end, error] =
      std::from_chars(text.data(), text.data() + text.size(), value, hex ? 16 : 10);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

bool is_name(std::string_view text) {
  return !text.empty() && std::isdigit(static_cast<unsigned char>(text[0])) == 0 &&
         std::all_of(text.begin(), text.end(), [](char c) {
           return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '.';
         });
}

std::string unit_in(std::string_view comment) {
  const std::size_t close = comment.rfind(']');
  const std::size_t open = comment.rfind('[', close);
  if (close == std::string_view::npos || open == std::string_view::npos) return "";
  const std::string_view unit = comment.substr(open + 1, close - open - 1);
  return unit == "-" ? "" : std::string(unit);
}

std::string value_family_in(std::string_view comment) {
  constexpr std::string_view kStart = "one of ";
  const std::size_t start = comment.find(kStart);
  if (start == std::string_view::npos) return "";
  comment.remove_prefix(start + kStart.size());
  const std::size_t star = comment.find('*');
  if (star == std::string_view::npos || !is_name(comment.substr(0, star))) return "";
  return std::string(comment.substr(0, star));
}

class Parser {
 public:
  explicit Parser(const SchemaFile& file) : file_{file.name}, source_{tokenize(file.text)} {}

  Result<std::vector<MessageType>> parse() {
    std::vector<MessageType> types;
    while (!done()) {
      if (take("package")) {
        next();
        if (!take(";")) return complain("';' is missing behind the package");
      } else if (take("struct")) {
        auto type = parse_type();
        if (!type) return tl::make_unexpected(type.error());
        types.push_back(std::move(*type));
      } else {
        return complain("'package' or 'struct' should stand here");
      }
    }
    return types;
  }

 private:
  [[nodiscard]] bool done() const { return at_ >= source_.tokens.size(); }
  [[nodiscard]] std::string peek() const { return done() ? "" : source_.tokens[at_].text; }
  std::string next() { return done() ? "" : source_.tokens[at_++].text; }
  bool take(std::string_view text) {
    if (done() || source_.tokens[at_].text != text) return false;
    ++at_;
    return true;
  }
  [[nodiscard]] int line() const {
    if (source_.tokens.empty()) return 1;
    return source_.tokens[std::min(at_, source_.tokens.size() - 1)].line;
  }
  [[nodiscard]] tl::unexpected<Error> complain(const std::string& what) const {
    return fail(file_ + ":" + std::to_string(line()) + ": " + what +
                (done() ? ", but the file ends" : ", not '" + peek() + "'"));
  }

  Result<MessageType> parse_type() {
    MessageType type;
    type.name = next();
    if (!is_name(type.name)) return complain("a type's name should stand here");
    if (!take("{")) return complain("'{' should stand here");
    while (!take("}")) {
      if (done()) return complain("'}' is missing");
      const Result<void> member = take("const") ? parse_constants(type) : parse_fields(type);
      if (!member) return tl::make_unexpected(member.error());
    }
    return type;
  }

  Result<void> parse_constants(MessageType& type) {
    const auto kind = primitive(next());
    if (!kind) return complain("a constant's type should stand here");
    do {
      const std::string name = next();
      if (!is_name(name) || !take("=")) return complain("'NAME = value' should stand here");
      if (const auto value = integer<std::int64_t>(next())) {
        type.constants.emplace_back(name, *value);
      } else if (kind != Primitive::kFloat && kind != Primitive::kDouble) {
        return complain("a whole number should stand before this");
      }
    } while (take(","));
    if (!take(";")) return complain("';' should stand here");
    return {};
  }

  Result<void> parse_fields(MessageType& type) {
    const std::string type_name = next();
    if (!is_name(type_name)) return complain("a field's type should stand here");
    do {
      Field field;
      field.type = type_name;
      field.primitive = primitive(type_name);
      field.name = next();
      if (!is_name(field.name)) return complain("a field's name should stand here");
      while (take("[")) {
        auto dimension = parse_dimension(type);
        if (!dimension) return tl::make_unexpected(dimension.error());
        field.dimensions.push_back(std::move(*dimension));
      }
      describe(field);
      type.fields.push_back(std::move(field));
    } while (take(","));
    if (!take(";")) return complain("';' should stand here");
    return {};
  }

  Result<Dimension> parse_dimension(const MessageType& type) {
    Dimension dimension;
    dimension.text = peek();
    if (const auto size = integer<std::int32_t>(dimension.text)) {
      if (*size <= 0) return complain("a size must be positive");
      dimension.size = *size;
    } else {
      const auto field =
          std::find_if(type.fields.begin(), type.fields.end(),
                       [&](const Field& before) { return before.name == dimension.text; });
      if (field == type.fields.end() || !counts(*field))
        return complain("a number or an integer field before this one should stand here");
      dimension.count_field = static_cast<std::size_t>(field - type.fields.begin());
    }
    next();
    if (!take("]")) return complain("']' should stand here");
    return dimension;
  }

  /// What the comment on the field's line says of it.
  void describe(Field& field) const {
    const std::string& comment = source_.comments[static_cast<std::size_t>(line() - 1)];
    field.unit = unit_in(comment);
    field.value_family = value_family_in(comment);
  }

  std::string file_;
  Tokens source_;
  std::size_t at_ = 0;
};

}  // namespace

Result<std::vector<MessageType>> parse_file(const SchemaFile& file) { return Parser(file).parse(); }

}  // namespace cairn::spy
