// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.hpp"

namespace cairn {

struct NumberRange {
  double min = -std::numeric_limits<double>::max();
  double max = std::numeric_limits<double>::max();
};

/// A config struct names each of its keys once, in `void visit(ConfigVisitor&)`: key, member,
/// range, unit, help. The member's initialiser is the default, and the only one. Loader,
/// --print-config and the reference page are visitors.
class ConfigVisitor {
 public:
  virtual ~ConfigVisitor() = default;
  virtual void number(const char* key, double& value, NumberRange range, const char* unit,
                      const char* help) = 0;
  virtual void integer(const char* key, int& value, int min, int max, const char* unit,
                       const char* help) = 0;
  virtual void flag(const char* key, bool& value, const char* help) = 0;
  virtual void text(const char* key, std::string& value, const char* help) = 0;
  virtual void choice(const char* key, std::string& value,
                      std::initializer_list<const char*> allowed, const char* help) = 0;
  /// A list of min_count to max_count numbers, each within the range.
  virtual void numbers(const char* key, std::vector<double>& values, std::size_t min_count,
                       std::size_t max_count, NumberRange range, const char* unit,
                       const char* help) = 0;

  /// A list of texts.
  virtual void texts(const char* key, std::vector<std::string>& values, const char* help) = 0;

  /// The value of this key, just visited, cannot be used, for a reason that its type and range do
  /// not give. The loader says so with its line; who reads nothing takes no notice.
  virtual void reject(const char* key, const std::string& why);

  /// A config struct inside this one.
  template <class Config>
  void group(const char* key, Config& config, const char* help) {
    if (!begin_group(key, help)) return;
    config.visit(*this);
    end_group();
  }
  /// A list of config structs; the loader appends one per entry.
  template <class Config>
  void list(const char* key, std::vector<Config>& configs, const char* help) {
    visit_list(
        key, help, configs.size(), [&] { configs.emplace_back(); },
        [&](std::size_t i) { configs[i].visit(*this); });
  }

 protected:
  /// False: nothing to visit there.
  virtual bool begin_group(const char* key, const char* help) = 0;
  virtual void end_group() = 0;
  virtual void visit_list(const char* key, const char* help, std::size_t size,
                          const std::function<void()>& append,
                          const std::function<void(std::size_t)>& visit_entry) = 0;
};

using VisitConfig = std::function<void(ConfigVisitor&)>;

/// Where a process's settings come from, besides the defaults in the code.
struct ConfigSource {
  std::filesystem::path file;          ///< YAML; empty: none
  std::vector<std::string> overrides;  ///< "key=value", "group.key=value"; win over the file
};

/// Fills a struct from the map under `section` of a YAML file (an empty section: from the whole
/// file), then from the overrides. Strict: an unknown or repeated key, a wrong type, a value out of
/// range, a section that is not in `known_sections` are errors; all are reported, one a line, as
/// "file:line: section.key: what, and what is allowed". A file that does not name the section
/// leaves the defaults. A group that the section itself does not have is taken from a section of
/// the group's name: what several processes must agree on (`robot:`) stands in a file once.
[[nodiscard]] Result<void> load_config(const ConfigSource& source, std::string_view section,
                                       std::span<const std::string_view> known_sections,
                                       const VisitConfig& visit);

template <class Config>
[[nodiscard]] Result<Config> load_config(const ConfigSource& source, std::string_view section,
                                         std::span<const std::string_view> known_sections) {
  Config config;
  auto loaded = load_config(source, section, known_sections,
                            [&](ConfigVisitor& visitor) { config.visit(visitor); });
  if (!loaded) return tl::make_unexpected(loaded.error());
  return config;
}

/// A whole YAML file into one struct, as strictly.
template <class Config>
[[nodiscard]] Result<Config> load_yaml(const std::filesystem::path& file) {
  return load_config<Config>(ConfigSource{file, {}}, "", {});
}

/// The effective config as YAML that load_config takes back, each key with its help, unit and range
/// as a comment.
[[nodiscard]] std::string print_config(std::string_view section, const VisitConfig& visit);

/// The same as rows of a Markdown table: key, default, range, unit, meaning.
[[nodiscard]] std::string config_reference(const VisitConfig& visit);

}  // namespace cairn
