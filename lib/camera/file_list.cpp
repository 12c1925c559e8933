// SPDX-License-Identifier: Apache-2.0
#include "camera/file_list.hpp"

#include <fnmatch.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>

namespace cairn::camera {
namespace {

namespace fs = std::filesystem;
constexpr std::string_view kDigits = "0123456789";

/// The text at the front of `text` that is all digits, or all other characters.
std::string_view front_run(std::string_view text) {
  const bool digits = kDigits.find(text.front()) != std::string_view::npos;
  const std::size_t end = digits ? text.find_first_not_of(kDigits) : text.find_first_of(kDigits);
  return text.substr(0, end);
}

std::string_view without_zeros(std::string_view digits) {
  return digits.substr(std::min(digits.find_first_not_of('0'), digits.size()));
}

bool name_less(std::string_view a, std::string_view b) {
  const std::string_view whole_a = a;
  const std::string_view whole_b = b;
  while (!a.empty() && !b.empty()) {
    const std::string_view run_a = front_run(a);
    const std::string_view run_b = front_run(b);
    const bool digits = kDigits.find(run_a.front()) != std::string_view::npos &&
                        kDigits.find(run_b.front()) != std::string_view::npos;
    const std::string_view value_a = digits ? without_zeros(run_a) : run_a;
    const std::string_view value_b = digits ? without_zeros(run_b) : run_b;
    if (digits && value_a.size() != value_b.size()) return value_a.size() < value_b.size();
    if (value_a != value_b) return value_a < value_b;
    a.remove_prefix(run_a.size());
    b.remove_prefix(run_b.size());
  }
  if (a.empty() != b.empty()) return a.empty();
  return whole_a < whole_b;
}

/// A stem split around its last run of digits.
struct NumberedStem {
  std::string before;
  std::string digits;
  std::string after;
};

NumberedStem split(const fs::path& file) {
  const std::string stem = file.stem().string();
  const std::size_t last = stem.find_last_of(kDigits);
  if (last == std::string::npos) return {stem, "", ""};
  const std::size_t before = stem.find_last_not_of(kDigits, last);
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  return {stem.substr(0, first), stem.substr(first, last - first + 1), stem.substr(last + 1)};
}

std::optional<std::int64_t> number_of(const fs::path& file) {
  const std::string digits = split(file).digits;
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (error != std::errc{} || digits.empty()) return std::nullopt;
  return number;
}

using KeyOf = std::string (*)(const fs::path&);
std::string stem_of(const fs::path& file) { return file.stem().string(); }
std::string digits_of(const fs::path& file) { return split(file).digits; }

std::set<std::string> keys(const FileList& files, KeyOf key_of) {
  std::set<std::string> keys;
  for (const fs::path& file : files) keys.insert(key_of(file));
  return keys;
}

/// Whether the key tells each side's files apart and some file has a partner by it.
bool pairs_by(const FileList& left, const FileList& right, KeyOf key_of) {
  const auto left_keys = keys(left, key_of);
  const auto right_keys = keys(right, key_of);
  if (left_keys.size() != left.size() || right_keys.size() != right.size()) return false;
  return std::any_of(left_keys.begin(), left_keys.end(),
                     [&](const std::string& key) { return right_keys.contains(key); });
}

/// The path that a file of this key would have beside `example`.
fs::path beside(const fs::path& example, const std::string& key, bool key_is_stem) {
  const NumberedStem parts = split(example);
  const std::string stem = key_is_stem ? key : parts.before + key + parts.after;
  return example.parent_path() / (stem + example.extension().string());
}

Result<void> every_file_has_a_partner(const FileList& files, const FileList& others, KeyOf key_of) {
  const auto other_keys = keys(others, key_of);
  for (const fs::path& file : files) {
    const std::string key = key_of(file);
    if (other_keys.contains(key)) continue;
    return fail(beside(others.front(), key, key_of == stem_of).string() +
                ": is missing (its partner is " + file.string() + ")");
  }
  return {};
}

}  // namespace

Result<FileList> list_files(const fs::path& folder, const std::string& pattern) {
  const fs::path full = folder / pattern;
  const std::string name_pattern = full.filename().string();
  std::error_code error;
  FileList files;
  for (fs::directory_iterator entry(full.parent_path(), error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (::fnmatch(name_pattern.c_str(), name.c_str(), FNM_PERIOD) != 0) continue;
    std::error_code not_there;
    if (fs::is_regular_file(entry->path(), not_there)) files.push_back(entry->path());
  }
  if (error) return fail(full.parent_path().string() + ": " + error.message());
  if (files.empty()) return fail(full.string() + ": no such files");
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return name_less(a.filename().string(), b.filename().string());
  });
  return files;
}

Result<void> check_pairs(const FileList& left, const FileList& right, bool names_are_times) {
  for (const KeyOf key_of : {stem_of, digits_of}) {
    if (!names_are_times && !pairs_by(left, right, key_of)) continue;
    if (auto paired = every_file_has_a_partner(left, right, key_of); !paired) return paired;
    return every_file_has_a_partner(right, left, key_of);
  }
  if (left.size() == right.size()) return {};
  const FileList& longer = left.size() > right.size() ? left : right;
  return fail(longer[std::min(left.size(), right.size())].string() +
              ": has no partner: " + std::to_string(left.size()) + " left and " +
              std::to_string(right.size()) + " right images");
}

Result<void> check_no_gap(const FileList& files) {
  std::map<std::int64_t, std::size_t> count_of_step;
  std::vector<std::int64_t> numbers;
  for (const fs::path& file : files) {
    const auto number = number_of(file);
    if (!number || (!numbers.empty() && *number <= numbers.back())) return {};
    if (!numbers.empty()) ++count_of_step[*number - numbers.back()];
    numbers.push_back(*number);
  }
  if (count_of_step.size() < 2) return {};
  const auto usual =
      std::max_element(count_of_step.begin(), count_of_step.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  const std::size_t steps = files.size() - 1;
  const std::size_t gaps = steps - usual->second;
  if (usual->second < 2 || gaps > std::max<std::size_t>(1, steps / 20)) return {};
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    if (numbers[i] - numbers[i - 1] <= usual->first) continue;
    std::string digits = std::to_string(numbers[i - 1] + usual->first);
    const std::size_t width = split(files[i - 1]).digits.size();
    if (digits.size() < width) digits.insert(0, width - digits.size(), '0');
    return fail(beside(files[i - 1], digits, false).string() + ": is missing (between " +
                files[i - 1].filename().string() + " and " + files[i].filename().string() +
                "); at a fixed rate a gap makes every later time wrong: give timestamps instead");
  }
  return {};
}

}  // namespace cairn::camera
