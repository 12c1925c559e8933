// SPDX-License-Identifier: Apache-2.0
#include "house/lcm_types.hpp"

#include <regex>
#include <set>

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

TypeFile parse(const std::string& path, const std::string& text) {
  static const std::regex package_line(R"(\s*package\s+cairn\s*;.*)");
  static const std::regex struct_line(R"(\s*(?:struct|enum)\s+(\w+).*)");
  static const std::regex field_line(R"(\s*([\w.]+)\s+\w+\s*((?:\[\s*\w+\s*\]\s*)*);\s*(//.*)?)");
  TypeFile file;
  file.path = path;
  const std::vector<std::string> lines = lines_of(text);
  std::smatch match;
  for (size_t i = 0; i < lines.size(); ++i) {
    if (std::regex_match(lines[i], package_line)) {
      file.in_package_cairn = true;
    } else if (std::regex_match(lines[i], match, struct_line)) {
      file.structs.push_back(match[1]);
    } else if (std::regex_match(lines[i], match, field_line)) {
      file.fields.push_back({i + 1, match[1], match[3]});
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
  static const std::regex unit(R"(.*\[[^\]]+\].*)");
  return std::regex_match(comment, unit);
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
