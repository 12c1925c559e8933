// SPDX-License-Identifier: Apache-2.0
#include "house/lcm_types.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <sstream>

namespace cairn::house {
namespace {

struct Field {
  size_t line = 0;      ///< from 1
  std::string type;     ///< as written
  std::string comment;  ///< what stands after // on the line
};

struct TypeFile {
  std::string path;
  bool in_package_cairn = false;
  std::vector<std::string> structs;
  std::vector<Field> fields;
};

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  return {std::istream_iterator<std::string>(stream), {}};
}

TypeFile parse(const std::string& path, const std::string& text) {
  TypeFile file;
  file.path = path;
  const std::vector<std::string> lines = lines_of(text);
  for (size_t i = 0; i < lines.size(); ++i) {
    const size_t comment = std::min(lines[i].find("//"), lines[i].size());
    const std::vector<std::string> words = words_of(lines[i].substr(0, comment));
    if (words.size() < 2 || words[0] == "const") continue;
    if (words[0] == "package") {
      file.in_package_cairn = words[1] == "cairn;";
    } else if (words[0] == "struct" || words[0] == "enum") {
      file.structs.push_back(words[1]);
    } else {
      file.fields.push_back({i + 1, words[0], lines[i].substr(comment)});
    }
  }
  return file;
}

bool is_number(const std::string& type) {
  static const std::set<std::string> numbers{"int8_t", "int16_t", "int32_t", "int64_t",
                                             "byte",   "float",   "double"};
  return numbers.contains(type);
}

bool has_words(const std::string& comment) {
  return comment.find_first_not_of("/ \t") != std::string::npos;
}

bool has_unit(const std::string& comment) {
  const size_t open = comment.find('[');
  const size_t close = comment.find(']', std::min(open, comment.size()));
  return close != std::string::npos && close > open + 1;
}

void check_fields(const TypeFile& file, Findings& findings) {
  for (const Field& field : file.fields) {
    const std::string place = file.path + ":" + std::to_string(field.line) + ": ";
    if (!has_words(field.comment)) {
      findings.push_back(place + "a field without a comment");
    } else if (is_number(field.type) && !has_unit(field.comment)) {
      findings.push_back(place + "a number without a [unit] in its comment");
    }
  }
}

void check_file(const TypeFile& file, const std::set<std::string>& parts, Findings& findings) {
  const size_t slash = file.path.rfind('/') + 1;
  const std::string name = file.path.substr(slash, file.path.rfind('.') - slash);
  if (!file.in_package_cairn) findings.push_back(file.path + ":1: must be of package cairn");
  if (file.structs != std::vector<std::string>{name}) {
    findings.push_back(file.path + ":1: must define the one type " + name);
  }
  const bool has_header = !file.fields.empty() && file.fields[0].type == "header_t";
  if (!parts.contains(name) && !has_header) {
    findings.push_back(file.path + ":1: a message's first field must be a header_t");
  }
  check_fields(file, findings);
}

}  // namespace

Findings message_type_findings(const SourceTree& tree) {
  std::vector<TypeFile> files;
  std::set<std::string> parts;
  for (const auto& [path, text] : tree) {
    if (path.starts_with("lcmtypes/") && path.ends_with(".lcm")) files.push_back(parse(path, text));
  }
  for (const TypeFile& file : files) {
    for (const Field& field : file.fields) parts.insert(field.type);
  }
  Findings findings;
  for (const TypeFile& file : files) check_file(file, parts, findings);
  return findings;
}

}  // namespace cairn::house
