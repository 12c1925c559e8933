// SPDX-License-Identifier: Apache-2.0
#include "fuzz/lcm_schema.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace cairn::testing {
namespace {

using Bytes = std::vector<std::uint8_t>;

const std::map<std::string, int> kPrimitiveBytes{{"boolean", 1}, {"byte", 1},    {"int8_t", 1},
                                                 {"int16_t", 2}, {"int32_t", 4}, {"int64_t", 8},
                                                 {"float", 4},   {"double", 8}};

bool starts_with_any(const std::string& line, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const char* word) { return line.rfind(word, 0) == 0; });
}

/// `type name[dimension][dimension]`
LcmField field_of(const std::string& declaration) {
  LcmField field;
  std::string name;
  std::istringstream words(declaration);
  words >> field.type >> name;
  std::istringstream parts(name);
  std::getline(parts, field.name, '[');
  for (std::string size; std::getline(parts, size, ']'); parts.ignore(1)) {
    field.dimensions.push_back(size);
  }
  return field;
}

std::vector<LcmField> read_type(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::vector<LcmField> fields;
  for (std::string line; std::getline(in, line);) {
    line.erase(0, line.find_first_not_of(' '));
    if (line.empty() || starts_with_any(line, {"//", "package ", "struct ", "const ", "}"})) {
      continue;
    }
    const std::size_t end = line.find(';');
    if (end == std::string::npos) {
      throw std::runtime_error(file.string() + ": not understood: " + line);
    }
    fields.push_back(field_of(line.substr(0, end)));
  }
  return fields;
}

/// Writes one message at random.
class SampleWriter {
 public:
  SampleWriter(const LcmSchema& schema, std::mt19937_64& rng) : schema_(schema), rng_(rng) {}

  void big_endian(std::uint64_t value, int bytes) {
    for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) {
      sample_.bytes.push_back(static_cast<std::uint8_t>(value >> shift));
    }
  }

  void fields_of(const std::string& type) {
    const auto& fields = schema_.types().at(type);
    std::map<std::string, std::int32_t> counts;
    for (const LcmField& field : fields) {
      if (is_count(fields, field.name)) {
        const auto count = static_cast<std::int32_t>(rng_() % 7);
        counts[field.name] = count;
        length(count);
      } else {
        elements(field, 0, counts);
      }
    }
  }

  Sample take() { return std::move(sample_); }

 private:
  static bool is_count(const std::vector<LcmField>& fields, const std::string& name) {
    return std::any_of(fields.begin(), fields.end(), [&](const LcmField& field) {
      return std::find(field.dimensions.begin(), field.dimensions.end(), name) !=
             field.dimensions.end();
    });
  }

  void length(std::int32_t value) {
    sample_.length_offsets.push_back(sample_.bytes.size());
    big_endian(static_cast<std::uint32_t>(value), 4);
  }

  void elements(const LcmField& field, std::size_t dimension,
                const std::map<std::string, std::int32_t>& counts) {
    if (dimension == field.dimensions.size()) return element(field.type);
    const std::string& size = field.dimensions[dimension];
    const bool number = std::isdigit(static_cast<unsigned char>(size[0])) != 0;
    const std::int32_t count = number ? std::stoi(size) : counts.at(size);
    for (std::int32_t i = 0; i < count; ++i) elements(field, dimension + 1, counts);
  }

  void element(const std::string& type) {
    if (schema_.is_struct(type)) return fields_of(type);
    if (type == "string") return text();
    big_endian(rng_(), kPrimitiveBytes.at(type));
  }

  void text() {
    const auto size = static_cast<std::int32_t>(rng_() % 12);
    length(size + 1);
    for (std::int32_t i = 0; i < size; ++i) {
      sample_.bytes.push_back(static_cast<std::uint8_t>('a' + rng_() % 26));
    }
    sample_.bytes.push_back(0);
  }

  const LcmSchema& schema_;
  std::mt19937_64& rng_;
  Sample sample_;
};

/// A position in [0, size].
std::size_t position(std::size_t size, std::mt19937_64& rng) { return rng() % (size + 1); }

void flip_bits(Bytes& bytes, std::mt19937_64& rng) {
  for (std::uint64_t flips = 1 + rng() % 8; flips > 0 && !bytes.empty(); --flips) {
    bytes[rng() % bytes.size()] ^= static_cast<std::uint8_t>(1U << rng() % 8);
  }
}

void forge_length(Bytes& bytes, const Sample& sample, std::mt19937_64& rng) {
  if (sample.length_offsets.empty()) return flip_bits(bytes, rng);
  constexpr std::int32_t kMin = std::numeric_limits<std::int32_t>::min();
  constexpr std::int32_t kMax = std::numeric_limits<std::int32_t>::max();
  const auto size = static_cast<std::int32_t>(bytes.size());
  const std::array<std::int32_t, 16> forged{
      kMin,        kMin + 1, -1,           0,
      1,           2,        size,         size - 8,
      size / 8,    kMax / 8, kMax / 8 + 1, kMax / 4,
      500'000'000, kMax - 1, kMax,         static_cast<std::int32_t>(rng())};
  const auto value = static_cast<std::uint32_t>(forged[rng() % forged.size()]);
  const std::size_t at = sample.length_offsets[rng() % sample.length_offsets.size()];
  for (std::size_t i = 0; i < 4; ++i) {
    bytes[at + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
  }
}

void extend(Bytes& bytes, std::mt19937_64& rng) {
  for (std::uint64_t count = 1 + rng() % 40; count > 0; --count) {
    bytes.push_back(static_cast<std::uint8_t>(rng()));
  }
}

void splice(Bytes& bytes, const Bytes& other, std::mt19937_64& rng) {
  const std::size_t from = position(other.size(), rng);
  const std::size_t count = position(other.size() - from, rng);
  const std::size_t at = position(bytes.size(), rng);
  const auto begin = other.begin() + static_cast<std::ptrdiff_t>(from);
  if (rng() % 2 == 0) bytes.resize(at);
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), begin,
               begin + static_cast<std::ptrdiff_t>(count));
}

}  // namespace

bool LcmField::variable() const {
  return std::any_of(dimensions.begin(), dimensions.end(), [](const std::string& size) {
    return std::isdigit(static_cast<unsigned char>(size[0])) == 0;
  });
}

LcmSchema::LcmSchema(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".lcm") continue;
    types_[entry.path().stem().string()] = read_type(entry.path());
  }
}

Sample random_sample(const LcmSchema& schema, const std::string& type, std::int64_t hash,
                     std::mt19937_64& rng) {
  SampleWriter writer(schema, rng);
  writer.big_endian(static_cast<std::uint64_t>(hash), 8);
  writer.fields_of(type);
  return writer.take();
}

Bytes mutant(const Sample& sample, const Sample& other, std::mt19937_64& rng) {
  Bytes bytes = sample.bytes;
  switch (rng() % 6) {
    case 0:
    case 1:
      forge_length(bytes, sample, rng);
      break;
    case 2:
      bytes.resize(position(bytes.size(), rng));
      break;
    case 3:
      extend(bytes, rng);
      break;
    case 4:
      splice(bytes, other.bytes, rng);
      break;
    default:
      flip_bits(bytes, rng);
  }
  return bytes;
}

}  // namespace cairn::testing
