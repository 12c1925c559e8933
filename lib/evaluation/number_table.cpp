// SPDX-License-Identifier: Apache-2.0
#include "evaluation/number_table.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "core/atomic_file.hpp"

namespace cairn::evaluation {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 30;
constexpr std::string_view kSeparators = " \t,\r";

std::vector<std::string_view> cut(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t begin = line.find_first_not_of(kSeparators); begin != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kSeparators, begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSeparators, end);
  }
  return fields;
}

template <class Number>
bool parse(std::string_view text, Number& value) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

std::string field_error(const TableLine& line, std::size_t index, const char* expected) {
  return line.place + "field " + std::to_string(index + 1) + " '" +
         std::string(line.fields[index].substr(0, 40)) + "' is not " + expected;
}

}  // namespace

Result<NumberTable> NumberTable::read(const std::filesystem::path& file) {
  const auto bytes = read_file(file, kMaxBytes);
  if (!bytes) return tl::make_unexpected(bytes.error());
  NumberTable table;
  table.text_.assign(bytes->begin(), bytes->end());
  const std::string_view text{table.text_.data(), table.text_.size()};
  std::size_t number = 1;
  for (std::size_t begin = 0; begin < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    auto fields = cut(text.substr(begin, end - begin));
    if (!fields.empty() && fields.front().front() != '#') {
      table.lines_.push_back(
          {file.string() + ":" + std::to_string(number) + ": ", std::move(fields)});
    }
    begin = end + 1;
  }
  return table;
}

Result<double> number_at(const TableLine& line, std::size_t index) {
  double value = 0;
  if (!parse(line.fields[index], value) || !std::isfinite(value)) {
    return fail(field_error(line, index, "a finite number"));
  }
  return value;
}

Result<std::int64_t> integer_at(const TableLine& line, std::size_t index) {
  std::int64_t value = 0;
  if (!parse(line.fields[index], value)) return fail(field_error(line, index, "a whole number"));
  return value;
}

}  // namespace cairn::evaluation
