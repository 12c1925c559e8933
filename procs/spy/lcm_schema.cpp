// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/lcm_schema.hpp"

#include "procs/spy/fingerprint.hpp"
#include "procs/spy/schema_parser.hpp"

namespace cairn::spy {

std::string MessageType::value_name(const std::string& family, std::int64_t value) const {
  if (family.empty()) return "";
  for (const auto& [constant, meaning] : constants) {
    if (meaning == value && constant.starts_with(family)) return constant.substr(family.size());
  }
  return "";
}

Result<Schema> Schema::parse(std::span<const SchemaFile> files) {
  Schema schema;
  for (const SchemaFile& file : files) {
    auto types = parse_file(file);
    if (!types) return tl::make_unexpected(types.error());
    for (MessageType& type : *types) {
      const std::string name = type.name;
      if (!schema.types_.emplace(name, std::move(type)).second)
        return fail(file.name + ": a second type " + name);
    }
  }
  for (const auto& [name, type] : schema.types_) {
    for (const Field& field : type.fields) {
      if (!field.primitive && !schema.types_.contains(field.type))
        return fail(name + "." + field.name + ": there is no type " + field.type);
    }
  }
  for (auto& [name, type] : schema.types_) type.fingerprint = fingerprint(schema.types_, type);
  return schema;
}

const MessageType* Schema::find(std::string_view name) const {
  const auto found = types_.find(name);
  return found == types_.end() ? nullptr : &found->second;
}

const MessageType* Schema::find(std::uint64_t fingerprint) const {
  for (const auto& [name, type] : types_) {
    if (type.fingerprint == fingerprint) return &type;
  }
  return nullptr;
}

}  // namespace cairn::spy
