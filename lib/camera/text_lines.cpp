// SPDX-License-Identifier: Apache-2.0
#include "camera/text_lines.hpp"

#include <charconv>
#include <cmath>

#include "core/atomic_file.hpp"

namespace cairn::camera {
namespace {

constexpr std::size_t kMaxText_bytes = std::size_t{256} << 20;
constexpr std::string_view kBlanks = " \t\r";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace

Result<std::vector<TextLine>> read_lines(const std::filesystem::path& file) {
  const auto bytes = read_file(file, kMaxText_bytes);
  if (!bytes) return tl::make_unexpected(bytes.error());
  std::string_view rest(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  std::vector<TextLine> lines;
  for (int number = 1; !rest.empty(); ++number) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::string_view text = trimmed(rest.substr(0, end));
    if (!text.empty() && text.front() != '#') lines.push_back({number, std::string(text)});
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return lines;
}

Result<std::vector<double>> parse_numbers(std::string_view text) {
  std::vector<double> numbers;
  while (!(text = trimmed(text)).empty()) {
    const std::string_view word = text.substr(0, text.find_first_of(kBlanks));
    double number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc{} || end != word.data() + word.size() || !std::isfinite(number)) {
      return fail("'" + std::string(word) + "' is not a number");
    }
    numbers.push_back(number);
    text.remove_prefix(word.size());
  }
  return numbers;
}

std::string place(const std::filesystem::path& file, const TextLine& line) {
  return file.string() + ":" + std::to_string(line.number) + ": ";
}

}  // namespace cairn::camera
