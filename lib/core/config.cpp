// SPDX-License-Identifier: Apache-2.0
#include "core/config.hpp"

#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <numeric>
#include <set>
#include <sstream>

namespace cairn {
namespace {

std::string number_text(double value) {
  std::ostringstream text;
  text.precision(17);
  for (int digits = 6; digits <= 17; ++digits) {
    text.str("");
    text.precision(digits);
    text << value;
    if (std::strtod(text.str().c_str(), nullptr) == value) break;
  }
  return text.str();
}

std::string range_text(NumberRange range) {
  const NumberRange unbounded;
  const bool low = range.min > unbounded.min;
  const bool high = range.max < unbounded.max;
  if (low && high) return number_text(range.min) + " to " + number_text(range.max);
  if (low) return number_text(range.min) + " or more";
  if (high) return number_text(range.max) + " or less";
  return "any number";
}

std::string choice_text(std::initializer_list<const char*> allowed) {
  std::string text;
  for (const char* word : allowed) text += (text.empty() ? "" : ", ") + std::string(word);
  return text;
}

bool parse_number(const std::string& text, double& value) {
  if (text.empty()) return false;
  char* end = nullptr;
  value = std::strtod(text.c_str(), &end);
  return end == text.c_str() + text.size() && std::isfinite(value);
}

bool parse_integer(const std::string& text, long& value) {
  if (text.empty()) return false;
  char* end = nullptr;
  errno = 0;
  value = std::strtol(text.c_str(), &end, 10);
  return end == text.c_str() + text.size() && errno == 0;
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

std::string did_you_mean(const std::string& word, const std::set<std::string>& known) {
  std::string best;
  std::size_t best_distance = 3 + word.size() / 4;
  for (const std::string& candidate : known) {
    const bool starts_alike = candidate.starts_with(word);
    const std::size_t distance = starts_alike ? 1 : edit_distance(word, candidate);
    if (distance < best_distance) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best.empty() ? "" : " (did you mean '" + best + "'?)";
}

/// One map of the YAML file while its struct is being visited.
struct Scope {
  YAML::Node map;
  std::string path;
  std::set<std::string> visited;
};

class Loader : public ConfigVisitor {
 public:
  /// `shared`: groups of the whole file, taken where the section itself does not have one of the
  /// same name.
  Loader(std::string source_name, const YAML::Node& root, std::string path,
         const std::map<std::string, YAML::Node>& shared = {})
      : source_name_{std::move(source_name)}, shared_{shared} {
    open_scope(root, std::move(path));
  }

  void number(const char* key, double& value, NumberRange range, const char* unit,
              const char*) override {
    const YAML::Node node = find(key);
    if (!node) return;
    double parsed = 0;
    if (!node.IsScalar() || !parse_number(node.Scalar(), parsed)) {
      return wrong(node, key, "is not a number", range_text(range), unit);
    }
    if (parsed < range.min || parsed > range.max) {
      return wrong(node, key, node.Scalar() + " is out of range", range_text(range), unit);
    }
    value = parsed;
  }

  void integer(const char* key, int& value, int min, int max, const char* unit,
               const char*) override {
    const YAML::Node node = find(key);
    if (!node) return;
    const std::string range = std::to_string(min) + " to " + std::to_string(max);
    long parsed = 0;
    if (!node.IsScalar() || !parse_integer(node.Scalar(), parsed)) {
      return wrong(node, key, "is not a whole number", range, unit);
    }
    if (parsed < min || parsed > max) {
      return wrong(node, key, node.Scalar() + " is out of range", range, unit);
    }
    value = static_cast<int>(parsed);
  }

  void flag(const char* key, bool& value, const char*) override {
    const YAML::Node node = find(key);
    if (!node) return;
    const std::string text = node.IsScalar() ? node.Scalar() : "";
    if (text != "true" && text != "false") return wrong(node, key, "is not true or false", "", "");
    value = text == "true";
  }

  void text(const char* key, std::string& value, const char*) override {
    const YAML::Node node = find(key);
    if (!node) return;
    if (!node.IsScalar()) return wrong(node, key, "is not a text", "", "");
    value = node.Scalar();
  }

  void choice(const char* key, std::string& value, std::initializer_list<const char*> allowed,
              const char*) override {
    const YAML::Node node = find(key);
    if (!node) return;
    const std::string given = node.IsScalar() ? node.Scalar() : "";
    if (std::find(allowed.begin(), allowed.end(), given) == allowed.end()) {
      return wrong(node, key, "'" + given + "' is not known", choice_text(allowed), "");
    }
    value = given;
  }

  void numbers(const char* key, std::vector<double>& values, std::size_t min_count,
               std::size_t max_count, NumberRange range, const char* unit, const char*) override {
    const YAML::Node node = find(key);
    if (!node) return;
    const std::string count = min_count == max_count
                                  ? std::to_string(min_count)
                                  : std::to_string(min_count) + " to " + std::to_string(max_count);
    if (!node.IsSequence() || node.size() < min_count || node.size() > max_count) {
      return wrong(node, key, "is not a list of " + count + " numbers", range_text(range), unit);
    }
    std::vector<double> parsed;
    for (const YAML::Node& entry : node) {
      double one = 0;
      if (!entry.IsScalar() || !parse_number(entry.Scalar(), one) || one < range.min ||
          one > range.max) {
        return wrong(entry, key, "holds an entry that is not a number in range", range_text(range),
                     unit);
      }
      parsed.push_back(one);
    }
    values = parsed;
  }

  void texts(const char* key, std::vector<std::string>& values, const char*) override {
    const YAML::Node node = find(key);
    if (!node) return;
    if (!node.IsSequence()) return wrong(node, key, "is not a list of texts", "", "");
    std::vector<std::string> parsed;
    for (const YAML::Node& entry : node) {
      if (!entry.IsScalar()) return wrong(entry, key, "holds an entry that is not a text", "", "");
      parsed.push_back(entry.Scalar());
    }
    values = parsed;
  }

  void reject(const char* key, const std::string& why) override {
    const YAML::Node node = find(key);
    report(node ? node : scopes_.back().map, scopes_.back().path + key + ": " + why);
  }

  void finish() { close_scope(); }
  [[nodiscard]] const std::vector<std::string>& errors() const { return errors_; }

 protected:
  bool begin_group(const char* key, const char*) override {
    const YAML::Node node = find(key);
    if (!node) return begin_shared_group(key);
    if (!node.IsMap()) {
      wrong(node, key, "is not a group of keys", "", "");
      return false;
    }
    open_scope(node, scopes_.back().path + key + ".");
    return true;
  }
  void end_group() override { close_scope(); }

  void visit_list(const char* key, const char*, std::size_t size,
                  const std::function<void()>& append,
                  const std::function<void(std::size_t)>& visit_entry) override {
    const YAML::Node node = find(key);
    if (!node) return;
    if (!node.IsSequence()) return wrong(node, key, "is not a list", "", "");
    for (std::size_t i = 0; i < node.size(); ++i) {
      if (!node[i].IsMap()) {
        wrong(node[i], key, "holds an entry that is not a group of keys", "", "");
        continue;
      }
      append();
      open_scope(node[i], scopes_.back().path + key + "[" + std::to_string(i) + "].");
      visit_entry(size++);
      close_scope();
    }
  }

 private:
  bool begin_shared_group(const char* key) {
    const auto group = shared_.find(key);
    if (scopes_.size() != 1 || group == shared_.end()) return false;
    open_scope(group->second, std::string(key) + ".");
    return true;
  }

  YAML::Node find(const char* key) {
    Scope& scope = scopes_.back();
    scope.visited.insert(key);
    for (const auto& entry : scope.map) {
      if (entry.first.Scalar() == key) return entry.second;
    }
    return YAML::Node(YAML::NodeType::Undefined);
  }

  void open_scope(const YAML::Node& map, std::string path) {
    scopes_.push_back(Scope{map, std::move(path), {}});
    std::set<std::string> seen;
    for (const auto& entry : map) {
      if (!seen.insert(entry.first.Scalar()).second) {
        report(entry.first, scopes_.back().path + entry.first.Scalar() + ": stands here twice");
      }
    }
  }

  void close_scope() {
    const Scope& scope = scopes_.back();
    for (const auto& entry : scope.map) {
      const std::string key = entry.first.Scalar();
      if (!scope.visited.contains(key)) {
        report(entry.first, scope.path + key + ": unknown key" + did_you_mean(key, scope.visited));
      }
    }
    scopes_.pop_back();
  }

  void wrong(const YAML::Node& node, const char* key, const std::string& what,
             const std::string& allowed, const char* unit) {
    std::string message = scopes_.back().path + key + ": " + what;
    if (!allowed.empty()) {
      message += " (allowed: " + allowed + (*unit == '\0' ? "" : " " + std::string(unit)) + ")";
    }
    report(node, message);
  }

  void report(const YAML::Node& node, const std::string& message) {
    const int line = node.Mark().line;
    errors_.push_back(
        source_name_ +
        (line >= 0 && source_name_.front() != '-' ? ":" + std::to_string(line + 1) : "") + ": " +
        message);
  }

  std::string source_name_;
  std::map<std::string, YAML::Node> shared_;
  std::vector<Scope> scopes_;
  std::vector<std::string> errors_;
};

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + line;
  return text;
}

Result<YAML::Node> parse_file(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return fail(file.string() + ": no such file");
  if (!std::filesystem::is_regular_file(file, error))
    return fail(file.string() + ": is not a file");
  if (::access(file.c_str(), R_OK) != 0) {
    return fail(file.string() + ": cannot open: " + std::strerror(errno));
  }
  try {
    YAML::Node root = YAML::LoadFile(file.string());
    if (!root.IsMap() && !root.IsNull()) return fail(file.string() + ":1: is not a map of keys");
    return root;
  } catch (const YAML::Exception& problem) {
    return fail(file.string() + ":" + std::to_string(problem.mark.line + 1) + ": " + problem.msg);
  }
}

/// "a.b=v" as the YAML {a: {b: v}}.
Result<YAML::Node> parse_override(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    return fail("--set " + text + ": is not of the form key=value");
  }
  YAML::Node value;
  try {
    value = YAML::Load(text.substr(equals + 1));
    if (value.IsNull()) value = YAML::Node(std::string{});
  } catch (const YAML::Exception& problem) {
    return fail("--set " + text + ": " + problem.msg);
  }
  std::string key = text.substr(0, equals);
  for (std::size_t dot = key.rfind('.');; dot = key.rfind('.')) {
    YAML::Node map(YAML::NodeType::Map);
    map[key.substr(dot == std::string::npos ? 0 : dot + 1)] = value;
    value = map;
    if (dot == std::string::npos) return value;
    key.resize(dot);
  }
}

class Printer : public ConfigVisitor {
 public:
  explicit Printer(int depth) : depth_{depth} {}

  void number(const char* key, double& value, NumberRange range, const char* unit,
              const char* help) override {
    line(key, number_text(value), range_text(range), unit, help);
  }
  void integer(const char* key, int& value, int min, int max, const char* unit,
               const char* help) override {
    line(key, std::to_string(value), std::to_string(min) + " to " + std::to_string(max), unit,
         help);
  }
  void flag(const char* key, bool& value, const char* help) override {
    line(key, value ? "true" : "false", "true, false", "", help);
  }
  void text(const char* key, std::string& value, const char* help) override {
    line(key, quoted(value), "", "", help);
  }
  void choice(const char* key, std::string& value, std::initializer_list<const char*> allowed,
              const char* help) override {
    line(key, value, choice_text(allowed), "", help);
  }
  void numbers(const char* key, std::vector<double>& values, std::size_t, std::size_t,
               NumberRange range, const char* unit, const char* help) override {
    std::string list;
    for (const double value : values) list += (list.empty() ? "" : ", ") + number_text(value);
    line(key, "[" + list + "]", range_text(range), unit, help);
  }
  void texts(const char* key, std::vector<std::string>& values, const char* help) override {
    std::string list;
    for (const std::string& value : values) list += (list.empty() ? "" : ", ") + quoted(value);
    line(key, "[" + list + "]", "", "", help);
  }
  [[nodiscard]] const std::string& result() const { return result_; }

 protected:
  bool begin_group(const char* key, const char* help) override {
    result_ += std::string(static_cast<std::size_t>(2 * depth_), ' ') + key + ":  # " + help + "\n";
    ++depth_;
    return true;
  }
  void end_group() override { --depth_; }
  void visit_list(const char* key, const char* help, std::size_t size, const std::function<void()>&,
                  const std::function<void(std::size_t)>& visit_entry) override {
    if (size == 0) return;
    begin_group(key, help);
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t start = result_.size();
      ++depth_;
      visit_entry(i);
      --depth_;
      if (result_.size() > start) result_[start + static_cast<std::size_t>(2 * depth_)] = '-';
    }
    end_group();
  }

 private:
  static std::string quoted(const std::string& value) {
    YAML::Emitter emitter;
    emitter << YAML::DoubleQuoted << value;
    return emitter.c_str();
  }
  void line(const char* key, const std::string& value, const std::string& allowed, const char* unit,
            const char* help) {
    result_ +=
        std::string(static_cast<std::size_t>(2 * depth_), ' ') + key + ": " + value + "  # " + help;
    if (*unit != '\0') result_ += " [" + std::string(unit) + "]";
    if (!allowed.empty()) result_ += " (" + allowed + ")";
    result_ += "\n";
  }

  int depth_;
  std::string result_;
};

class ReferenceWriter : public ConfigVisitor {
 public:
  void number(const char* key, double& value, NumberRange range, const char* unit,
              const char* help) override {
    row(key, number_text(value), range_text(range), unit, help);
  }
  void integer(const char* key, int& value, int min, int max, const char* unit,
               const char* help) override {
    row(key, std::to_string(value), std::to_string(min) + " to " + std::to_string(max), unit, help);
  }
  void flag(const char* key, bool& value, const char* help) override {
    row(key, value ? "true" : "false", "true, false", "", help);
  }
  void text(const char* key, std::string& value, const char* help) override {
    row(key, value, "text", "", help);
  }
  void choice(const char* key, std::string& value, std::initializer_list<const char*> allowed,
              const char* help) override {
    row(key, value, choice_text(allowed), "", help);
  }
  void numbers(const char* key, std::vector<double>& values, std::size_t, std::size_t,
               NumberRange range, const char* unit, const char* help) override {
    std::string list;
    for (const double value : values) list += (list.empty() ? "" : ", ") + number_text(value);
    row(key, "[" + list + "]", range_text(range), unit, help);
  }
  void texts(const char* key, std::vector<std::string>&, const char* help) override {
    row(key, "[]", "texts", "", help);
  }
  [[nodiscard]] const std::string& result() const { return result_; }

 protected:
  bool begin_group(const char* key, const char*) override {
    prefix_.push_back(std::string(key) + ".");
    return true;
  }
  void end_group() override { prefix_.pop_back(); }
  void visit_list(const char* key, const char* help, std::size_t, const std::function<void()>&,
                  const std::function<void(std::size_t)>&) override {
    row(key, "[]", "list", "", help);
  }

 private:
  void row(const char* key, const std::string& value, const std::string& allowed, const char* unit,
           const char* help) {
    std::string path;
    for (const std::string& part : prefix_) path += part;
    result_ += "| `" + path + key + "` | " + (value.empty() ? "" : "`" + value + "`") + " | " +
               allowed + " | " + unit + " | " + help + " |\n";
  }

  std::vector<std::string> prefix_;
  std::string result_;
};

/// The file's sections by name; what is wrong with them goes into `errors`.
std::map<std::string, YAML::Node> sections_of(const YAML::Node& root, const std::string& file,
                                              std::span<const std::string_view> known_sections,
                                              std::vector<std::string>& errors) {
  const std::set<std::string> known(known_sections.begin(), known_sections.end());
  std::set<std::string> seen;
  std::map<std::string, YAML::Node> sections;
  for (const auto& entry : root) {
    const std::string key = entry.first.Scalar();
    const std::string place = file + ":" + std::to_string(entry.first.Mark().line + 1) + ": " + key;
    if (!seen.insert(key).second) errors.push_back(place + ": stands here twice");
    if (!known.contains(key)) {
      errors.push_back(place + ": unknown section" + did_you_mean(key, known));
    } else if (entry.second.IsMap()) {
      sections.emplace(key, entry.second);
    } else if (!entry.second.IsNull()) {
      errors.push_back(place + ": is not a group of keys");
    }
  }
  return sections;
}

}  // namespace

void ConfigVisitor::reject(const char*, const std::string&) {}

Result<void> load_config(const ConfigSource& source, std::string_view section,
                         std::span<const std::string_view> known_sections,
                         const VisitConfig& visit) {
  std::vector<std::string> errors;
  const auto load_from = [&](const std::string& name, const YAML::Node& node, std::string path,
                             const std::map<std::string, YAML::Node>& shared = {}) {
    Loader loader(name, node, std::move(path), shared);
    visit(loader);
    loader.finish();
    errors.insert(errors.end(), loader.errors().begin(), loader.errors().end());
  };
  if (!source.file.empty()) {
    const auto root = parse_file(source.file);
    if (!root) return tl::make_unexpected(root.error());
    if (section.empty()) {
      load_from(source.file.string(), *root, "");
    } else {
      const auto sections = sections_of(*root, source.file.string(), known_sections, errors);
      const auto own = sections.find(std::string(section));
      load_from(source.file.string(),
                own == sections.end() ? YAML::Node(YAML::NodeType::Map) : own->second,
                std::string(section) + ".", sections);
    }
  }
  for (const std::string& text : source.overrides) {
    const auto node = parse_override(text);
    if (!node) {
      errors.push_back(node.error().message);
    } else {
      load_from("--set " + text, *node, "");
    }
  }
  if (!errors.empty()) return fail(joined(errors));
  return {};
}

std::string print_config(std::string_view section, const VisitConfig& visit) {
  Printer printer(section.empty() ? 0 : 1);
  visit(printer);
  return (section.empty() ? "" : std::string(section) + ":\n") + printer.result();
}

std::string config_reference(const VisitConfig& visit) {
  ReferenceWriter writer;
  visit(writer);
  return "| key | default | allowed | unit | meaning |\n|---|---|---|---|---|\n" + writer.result();
}

}  // namespace cairn
