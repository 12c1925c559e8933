// SPDX-License-Identifier: Apache-2.0
#include "messages/disparity_packing.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>

#include "messages/symbol_coding.hpp"

namespace cairn::messages {
namespace {

constexpr std::uint8_t kPlain = 0;
constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kPreambleBytes = 9;  // version, columns, rows, bytes of the symbols
constexpr std::uint8_t kValid = 4;
constexpr std::uint8_t kMaxCode = 3;
constexpr std::uint8_t kLongNibble = 15;
constexpr std::uint8_t kLongByte = 255;
constexpr std::array<int, 3> kSpreadLimits_16ths{6, 16, 48};
constexpr std::size_t kSpreads = kSpreadLimits_16ths.size() + 1;

/// Half bytes, low half first.
class NibbleWriter {
 public:
  void put(std::uint8_t nibble) {
    if (half_) {
      bytes_.back() |= static_cast<std::uint8_t>(nibble << 4);
    } else {
      bytes_.push_back(nibble);
    }
    half_ = !half_;
  }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  Bytes bytes_;
  bool half_ = false;
};

/// Reads half bytes or whole ones off the front; past the end come zeros and it is bad for good.
class NibbleReader {
 public:
  explicit NibbleReader(Bytes bytes = {}) : bytes_(std::move(bytes)) {}

  std::uint8_t nibble() {
    if (next_ >= 2 * bytes_.size()) {
      good_ = false;
      return 0;
    }
    const std::uint8_t byte = bytes_[next_ / 2];
    return next_++ % 2 == 0 ? byte & 15 : static_cast<std::uint8_t>(byte >> 4);
  }
  std::uint8_t byte() {
    const std::uint8_t low = nibble();
    return static_cast<std::uint8_t>(low | nibble() << 4);
  }
  /// Whether all was read, nothing beyond, and a half left over is zero.
  [[nodiscard]] bool used_up() {
    if (next_ % 2 != 0 && nibble() != 0) return false;
    return good_ && next_ == 2 * bytes_.size();
  }
  [[nodiscard]] bool good() const { return good_; }

 private:
  Bytes bytes_;
  std::size_t next_ = 0;
  bool good_ = true;
};

/// What the neighbours that are already known say about a disparity.
struct Prediction {
  int value_16ths;
  std::size_t spread;
};

int median_edge(int left, int above, int above_left) {
  const auto [low, high] = std::minmax(left, above);
  return above_left >= high ? low : above_left <= low ? high : left + above - above_left;
}

std::size_t spread_class(int spread_16ths) {
  std::size_t spread = 0;
  while (spread < kSpreadLimits_16ths.size() && spread_16ths >= kSpreadLimits_16ths[spread]) {
    ++spread;
  }
  return spread;
}

/// `row` and `above` have one zero before the first and after the last column.
Prediction predict(const std::uint16_t* row, const std::uint16_t* above, int column) {
  const int left = row[column - 1];
  const int up = above[column];
  const int up_left = above[column - 1];
  const int up_right = above[column + 1];
  if (left != 0 && up != 0 && up_left != 0) {
    const int spread = std::abs(left - up_left) + std::abs(up - up_left) +
                       (up_right != 0 ? std::abs(up - up_right) : 0);
    return {median_edge(left, up, up_left), spread_class(spread)};
  }
  if (left != 0 && up != 0) {
    return {(left + up) / 2, spread_class(std::abs(left - up) + kSpreadLimits_16ths[0])};
  }
  for (const int neighbour : {left, up, up_left, up_right}) {
    if (neighbour != 0) return {neighbour, kSpreads - 2};
  }
  return {0, kSpreads - 1};
}

std::uint16_t zigzag(std::uint16_t difference) {
  const bool negative = (difference & 0x8000) != 0;
  return static_cast<std::uint16_t>((difference << 1) ^ (negative ? 0xffff : 0));
}

std::uint16_t unzigzag(std::uint16_t code) {
  return static_cast<std::uint16_t>((code >> 1) ^ ((code & 1) != 0 ? 0xffff : 0));
}

SymbolGrid symbols_of(const DisparityGrid& grid) {
  const int columns = grid.code.cols;
  auto symbols = framed<std::uint8_t>(grid.code.rows, columns);
  for (int row = 0; row < grid.code.rows; ++row) {
    const std::uint8_t* code = grid.code[row];
    const std::uint16_t* disparity = grid.disparity_16ths[row];
    std::uint8_t* out = symbols[row + 1] + 1;
    for (int column = 0; column < columns; ++column) {
      out[column] = static_cast<std::uint8_t>(code[column] | (disparity[column] != 0 ? kValid : 0));
    }
  }
  return symbols;
}

/// Prediction errors by spread, zigzag: below kLongNibble as a nibble; others as kLongNibble, with
/// the rest in `longer` as a byte or, from kLongByte on, as kLongByte and 16 bits.
struct Errors {
  std::array<NibbleWriter, kSpreads> by_spread;
  Bytes longer;

  void put(std::size_t spread, std::uint16_t error) {
    by_spread[spread].put(static_cast<std::uint8_t>(std::min<int>(error, kLongNibble)));
    if (error < kLongNibble) return;
    const int rest = error - kLongNibble;
    longer.push_back(static_cast<std::uint8_t>(std::min<int>(rest, kLongByte)));
    if (rest < kLongByte) return;
    longer.push_back(static_cast<std::uint8_t>(rest));
    longer.push_back(static_cast<std::uint8_t>(rest >> 8));
  }
};

struct ErrorReader {
  std::array<NibbleReader, kSpreads> by_spread;
  NibbleReader longer;

  std::uint16_t next(std::size_t spread) {
    const std::uint8_t nibble = by_spread[spread].nibble();
    if (nibble < kLongNibble) return nibble;
    int rest = longer.byte();
    if (rest == kLongByte) {
      rest = longer.byte();
      rest |= longer.byte() << 8;
    }
    return static_cast<std::uint16_t>(kLongNibble + rest);
  }
  [[nodiscard]] bool used_up() {
    bool all = longer.used_up();
    for (NibbleReader& reader : by_spread) all = reader.used_up() && all;
    return all;
  }
};

Errors prediction_errors(const cv::Mat_<std::uint16_t>& disparity_16ths) {
  const int columns = disparity_16ths.cols;
  auto grid = framed<std::uint16_t>(disparity_16ths.rows, columns);
  disparity_16ths.copyTo(grid(cv::Rect(1, 1, columns, disparity_16ths.rows)));
  Errors errors;
  for (int r = 1; r < grid.rows; ++r) {
    const std::uint16_t* row = grid[r] + 1;
    const std::uint16_t* above = grid[r - 1] + 1;
    for (int column = 0; column < columns; ++column) {
      if (row[column] == 0) continue;
      const Prediction prediction = predict(row, above, column);
      errors.put(prediction.spread,
                 zigzag(static_cast<std::uint16_t>(row[column] - prediction.value_16ths)));
    }
  }
  return errors;
}

Result<cv::Mat_<std::uint16_t>> restore(ErrorReader& errors, const SymbolGrid& symbols,
                                        int columns) {
  auto grid = framed<std::uint16_t>(symbols.rows - 1, columns);
  for (int r = 1; r < symbols.rows; ++r) {
    const std::uint8_t* symbol = symbols[r] + 1;
    std::uint16_t* row = grid[r] + 1;
    const std::uint16_t* above = grid[r - 1] + 1;
    for (int column = 0; column < columns; ++column) {
      if ((symbol[column] & kValid) == 0) continue;
      const Prediction prediction = predict(row, above, column);
      row[column] = static_cast<std::uint16_t>(prediction.value_16ths +
                                               unzigzag(errors.next(prediction.spread)));
      if (row[column] == 0) return fail("a valid grid point has the packed disparity 0");
    }
  }
  if (!errors.used_up()) return fail("packed disparities are too few or too many");
  return grid;
}

Result<ErrorReader> read_errors(std::span<const std::uint8_t> packed, std::size_t points) {
  StreamReader streams(packed, 4 * points + kSpreads);
  ErrorReader errors;
  for (NibbleReader& reader : errors.by_spread) {
    auto stream = streams.next();
    if (!stream) return fail(stream.error().message);
    reader = NibbleReader(std::move(*stream));
  }
  auto longer = streams.next();
  if (!longer) return fail(longer.error().message);
  errors.longer = NibbleReader(std::move(*longer));
  if (!streams.at_end()) return fail("bytes after the end of the packed grid");
  return errors;
}

bool size_in_range(int rows, int columns) {
  return rows > 0 && columns > 0 && rows <= kMaxGridSide && columns <= kMaxGridSide &&
         std::int64_t{rows} * columns <= kMaxGridPoints;
}

std::string size_text(int rows, int columns) {
  return std::to_string(columns) + "x" + std::to_string(rows);
}

void append_number(Bytes& bytes, std::size_t value, int size) {
  for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

std::size_t number_at(std::span<const std::uint8_t> bytes, std::size_t at, std::size_t size) {
  std::size_t value = 0;
  for (std::size_t i = 0; i < size; ++i) value |= std::size_t{bytes[at + i]} << (8 * i);
  return value;
}

Result<DisparityGrid> read_plain(std::span<const std::uint8_t> bytes, int rows, int columns) {
  const std::size_t points = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  if (!size_in_range(rows, columns) || bytes.size() != 3 * points) {
    return fail("a plain grid of " + size_text(rows, columns) + " has 3 bytes a point, not " +
                std::to_string(bytes.size()) + " in all");
  }
  DisparityGrid grid;
  grid.disparity_16ths.create(rows, columns);
  grid.code.create(rows, columns);
  for (std::size_t i = 0; i < points; ++i) {
    grid.disparity_16ths.ptr<std::uint16_t>()[i] =
        static_cast<std::uint16_t>(bytes[2 * i] | bytes[2 * i + 1] << 8);
    grid.code.ptr<std::uint8_t>()[i] = bytes[2 * points + i];
    if (bytes[2 * points + i] > kMaxCode) return fail("a code is over 3");
  }
  return grid;
}

}  // namespace

Result<Bytes> pack(const DisparityGrid& grid) {
  const int rows = grid.code.rows;
  const int columns = grid.code.cols;
  if (grid.disparity_16ths.size() != grid.code.size() || !size_in_range(rows, columns)) {
    return fail("grid size " + size_text(rows, columns) + " is out of range or not that of both");
  }
  double largest_code = 0;
  cv::minMaxLoc(grid.code, nullptr, &largest_code);
  if (largest_code > kMaxCode) return fail("a code is over 3");

  const Bytes symbols = encode_symbols(symbols_of(grid));
  const Errors errors = prediction_errors(grid.disparity_16ths);
  Bytes packed{kVersion};
  append_number(packed, static_cast<std::size_t>(columns), 2);
  append_number(packed, static_cast<std::size_t>(rows), 2);
  append_number(packed, symbols.size(), 4);
  packed.insert(packed.end(), symbols.begin(), symbols.end());
  StreamWriter streams(packed, Redundancy::kSkewed);
  for (const NibbleWriter& writer : errors.by_spread) streams.append(writer.bytes());
  streams.append(errors.longer);
  return packed;
}

Result<DisparityGrid> unpack(std::span<const std::uint8_t> packed, int rows, int columns) {
  if (!packed.empty() && packed[0] == kPlain) return read_plain(packed.subspan(1), rows, columns);
  if (packed.size() < kPreambleBytes) return fail("packed bytes end too early");
  if (packed[0] != kVersion) {
    return fail("packed in version " + std::to_string(packed[0]) + ", this program knows " +
                std::to_string(kVersion));
  }
  const auto packed_columns = static_cast<int>(number_at(packed, 1, 2));
  const auto packed_rows = static_cast<int>(number_at(packed, 3, 2));
  if (packed_columns != columns || packed_rows != rows || !size_in_range(rows, columns)) {
    return fail("packed grid is " + size_text(packed_rows, packed_columns) + ", message says " +
                size_text(rows, columns));
  }
  const std::size_t symbol_bytes = number_at(packed, 5, 4);
  if (symbol_bytes > packed.size() - kPreambleBytes) return fail("packed bytes end too early");
  const std::size_t points = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  auto errors = read_errors(packed.subspan(kPreambleBytes + symbol_bytes), points);
  if (!errors) return fail(errors.error().message);

  const auto symbols = decode_symbols(packed.subspan(kPreambleBytes, symbol_bytes), rows, columns);
  if (!symbols) return fail(symbols.error().message);
  const auto disparities = restore(*errors, *symbols, columns);
  if (!disparities) return fail(disparities.error().message);
  const cv::Rect inside(1, 1, columns, rows);
  DisparityGrid grid;
  grid.disparity_16ths = (*disparities)(inside).clone();
  grid.code = (*symbols)(inside)&kMaxCode;
  return grid;
}

}  // namespace cairn::messages
