// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/field_lines.hpp"

#include <algorithm>
#include <cstdio>

namespace cairn::spy {
namespace {

std::string number_text(const Json& value) {
  if (!value.is_number_float()) return value.dump();
  char text[32];
  std::snprintf(text, sizeof(text), "%.10g", value.get<double>());
  return text;
}

std::string scalar_text(const MessageType& type, const Field& field, const Json& value) {
  if (value.is_string()) return "\"" + value.get<std::string>() + "\"";
  const std::string name = value.is_number_integer()
                               ? type.value_name(field.value_family, value.get<std::int64_t>())
                               : "";
  return number_text(value) + (name.empty() ? "" : " (" + name + ")");
}

class Lines {
 public:
  explicit Lines(const Schema& schema) : schema_{schema} {}

  void fields(const MessageType& type, const Json& values, std::size_t indent) {
    std::size_t width = 0;
    for (const Field& field : type.fields) width = std::max(width, field.name.size());
    for (const Field& field : type.fields) {
      const std::string name = field.name + std::string(width - field.name.size(), ' ');
      value(type, field, name, values.at(field.name), indent);
    }
  }

  std::vector<std::string> take() { return std::move(lines_); }

 private:
  void line(std::size_t indent, const std::string& text) {
    lines_.push_back(std::string(indent, ' ') + text);
    lines_.back().erase(lines_.back().find_last_not_of(' ') + 1);
  }

  void value(const MessageType& type, const Field& field, const std::string& name,
             const Json& value, std::size_t indent) {
    if (field.dimensions.empty() && !field.primitive) {
      line(indent, name);
      fields(*schema_.find(field.type), value, indent + 2);
    } else if (field.primitive && field.dimensions.size() <= 1) {
      const std::string unit =
          field.unit.empty() || value.contains("bytes") ? "" : " " + field.unit;
      line(indent, name + "  " + inline_text(type, field, value) + unit);
    } else {
      elements(type, field, name, value, indent);
    }
  }

  static std::string inline_text(const MessageType& type, const Field& field, const Json& value) {
    if (field.dimensions.empty()) return scalar_text(type, field, value);
    if (value.contains("bytes")) return number_text(value["bytes"]) + " bytes";
    const bool short_form = value.is_object();
    const Json& shown = short_form ? value["first"] : value;
    std::string text;
    for (const Json& element : shown)
      text += (text.empty() ? "" : ", ") + scalar_text(type, field, element);
    if (!short_form) return "[" + text + "]";
    const bool more = value["count"] > shown.size();
    return number_text(value["count"]) + " x " + field.type + " [" + text + (more ? ", ...]" : "]");
  }

  /// An array of types, or of arrays.
  void elements(const MessageType& type, const Field& field, const std::string& name,
                const Json& value, std::size_t indent) {
    const bool short_form = value.is_object();
    const Json& shown = short_form ? value["first"] : value;
    const std::size_t count = short_form ? value["count"].get<std::size_t>() : shown.size();
    Field inner = field;
    inner.dimensions.erase(inner.dimensions.begin());
    line(indent, name + "  " + std::to_string(count) + " x " + field.type);
    std::size_t index = 0;
    for (const Json& element : shown)
      this->value(type, inner, "[" + std::to_string(index++) + "]", element, indent + 2);
    if (count > shown.size())
      line(indent + 2, "... " + std::to_string(count - shown.size()) + " more");
  }

  const Schema& schema_;
  std::vector<std::string> lines_;
};

}  // namespace

std::vector<std::string> field_lines(const Schema& schema, const MessageType& type,
                                     const Json& fields) {
  Lines lines(schema);
  lines.fields(type, fields, 0);
  return lines.take();
}

}  // namespace cairn::spy
