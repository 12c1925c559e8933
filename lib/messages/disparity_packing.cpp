// SPDX-License-Identifier: Apache-2.0
#include "messages/disparity_packing.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <string>

namespace cairn::messages {
namespace {

constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kPreambleBytes = 5;  // version, columns, rows
constexpr std::uint8_t kValid = 4;
constexpr std::uint8_t kMaxCode = 3;
constexpr std::size_t kSymbols = 8;
constexpr std::uint8_t kEscape = 255;
constexpr std::array<int, 3> kSpreadLimits_16ths{6, 16, 48};
constexpr std::size_t kSpreads = kSpreadLimits_16ths.size() + 1;

/// Everything that goes into zstd streams, in the order of packing.
struct Streams {
  Bytes same_as_above;                    ///< a bit a pair, low bit first
  std::array<Bytes, kSymbols> pairs;      ///< by the symbol to the left: first | second << 3
  std::array<Bytes, kSpreads> residuals;  ///< zigzag; kEscape: see escapes
  Bytes escapes;                          ///< 16 bits, little end first
};

template <class S, class Visit>
auto for_each_stream(S& streams, Visit visit) {
  visit(streams.same_as_above, Redundancy::kRepeated);
  for (auto& stream : streams.pairs) visit(stream, Redundancy::kSkewed);
  for (auto& stream : streams.residuals) visit(stream, Redundancy::kSkewed);
  visit(streams.escapes, Redundancy::kRepeated);
}

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

/// A copy with one zero around every row's ends and a row of zeros above, so that each point has
/// its neighbours.
template <class T>
cv::Mat_<T> framed(int rows, int columns) {
  return cv::Mat_<T>(rows + 1, columns + 3, T{0});  // pairs may reach one column further
}

cv::Mat_<std::uint8_t> symbols_of(const DisparityGrid& grid) {
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

void pack_symbols(const cv::Mat_<std::uint8_t>& symbols, int columns, Streams& streams) {
  std::size_t pair_index = 0;
  for (int row = 1; row < symbols.rows; ++row) {
    const std::uint8_t* here = symbols[row] + 1;
    const std::uint8_t* above = symbols[row - 1] + 1;
    for (int column = 0; column < columns; column += 2, ++pair_index) {
      if (pair_index % 8 == 0) streams.same_as_above.push_back(0);
      if (here[column] == above[column] && here[column + 1] == above[column + 1]) {
        streams.same_as_above.back() |= static_cast<std::uint8_t>(1U << (pair_index % 8));
      } else {
        streams.pairs[here[column - 1]].push_back(
            static_cast<std::uint8_t>(here[column] | here[column + 1] << 3));
      }
    }
  }
}

void pack_disparities(const DisparityGrid& grid, Streams& streams) {
  const int columns = grid.code.cols;
  auto framed_grid = framed<std::uint16_t>(grid.code.rows, columns);
  grid.disparity_16ths.copyTo(framed_grid(cv::Rect(1, 1, columns, grid.code.rows)));
  for (int r = 1; r < framed_grid.rows; ++r) {
    const std::uint16_t* row = framed_grid[r] + 1;
    const std::uint16_t* above = framed_grid[r - 1] + 1;
    for (int column = 0; column < columns; ++column) {
      if (row[column] == 0) continue;
      const Prediction prediction = predict(row, above, column);
      const std::uint16_t code =
          zigzag(static_cast<std::uint16_t>(row[column] - prediction.value_16ths));
      streams.residuals[prediction.spread].push_back(
          static_cast<std::uint8_t>(std::min<int>(code, kEscape)));
      if (code >= kEscape) {
        streams.escapes.push_back(static_cast<std::uint8_t>(code));
        streams.escapes.push_back(static_cast<std::uint8_t>(code >> 8));
      }
    }
  }
}

/// Takes bytes off the front of a stream; remembers whether there were too few.
class Front {
 public:
  explicit Front(const Bytes& bytes) : bytes_(&bytes) {}
  [[nodiscard]] bool empty() const { return next_ == bytes_->size(); }
  std::uint8_t take() { return (*bytes_)[next_++]; }

 private:
  const Bytes* bytes_;
  std::size_t next_ = 0;
};

template <std::size_t N>
std::array<Front, N> fronts(const std::array<Bytes, N>& streams) {
  return [&]<std::size_t... I>(std::index_sequence<I...>) {
    return std::array<Front, N>{Front(streams[I])...};
  }
  (std::make_index_sequence<N>());
}

template <std::size_t N>
bool all_empty(const std::array<Front, N>& all) {
  return std::all_of(all.begin(), all.end(), [](const Front& front) { return front.empty(); });
}

Result<cv::Mat_<std::uint8_t>> unpack_symbols(const Streams& streams, int rows, int columns) {
  auto symbols = framed<std::uint8_t>(rows, columns);
  const std::size_t pairs_a_row = (static_cast<std::size_t>(columns) + 1) / 2;
  if (streams.same_as_above.size() != (pairs_a_row * static_cast<std::size_t>(rows) + 7) / 8) {
    return fail("packed codes do not fill the grid");
  }
  auto pairs = fronts(streams.pairs);
  std::size_t pair_index = 0;
  for (int row = 1; row <= rows; ++row) {
    std::uint8_t* here = symbols[row] + 1;
    const std::uint8_t* above = symbols[row - 1] + 1;
    for (int column = 0; column < columns; column += 2, ++pair_index) {
      if ((streams.same_as_above[pair_index / 8] >> (pair_index % 8) & 1) != 0) {
        here[column] = above[column];
        here[column + 1] = above[column + 1];
        continue;
      }
      Front& front = pairs[here[column - 1]];
      if (front.empty()) return fail("packed codes end too early");
      const std::uint8_t pair = front.take();
      if (pair >= kSymbols * kSymbols) return fail("a packed pair of codes is out of range");
      here[column] = pair & 7;
      here[column + 1] = static_cast<std::uint8_t>(pair >> 3);
    }
    if (columns % 2 != 0 && here[columns] != 0) return fail("a packed code is beyond the grid");
  }
  if (!all_empty(pairs)) return fail("more packed codes than grid points");
  return symbols;
}

Result<cv::Mat_<std::uint16_t>> unpack_disparities(const Streams& streams,
                                                   const cv::Mat_<std::uint8_t>& symbols,
                                                   int columns) {
  auto disparities = framed<std::uint16_t>(symbols.rows - 1, columns);
  auto residuals = fronts(streams.residuals);
  Front escapes(streams.escapes);
  for (int r = 1; r < symbols.rows; ++r) {
    const std::uint8_t* symbol = symbols[r] + 1;
    std::uint16_t* row = disparities[r] + 1;
    const std::uint16_t* above = disparities[r - 1] + 1;
    for (int column = 0; column < columns; ++column) {
      if ((symbol[column] & kValid) == 0) continue;
      const Prediction prediction = predict(row, above, column);
      Front& front = residuals[prediction.spread];
      if (front.empty()) return fail("packed disparities end too early");
      std::uint16_t code = front.take();
      if (code == kEscape) {
        if (streams.escapes.size() % 2 != 0 || escapes.empty()) {
          return fail("packed disparities end too early");
        }
        code = escapes.take();
        code = static_cast<std::uint16_t>(code | escapes.take() << 8);
      }
      row[column] = static_cast<std::uint16_t>(prediction.value_16ths + unzigzag(code));
      if (row[column] == 0) return fail("a valid grid point has the packed disparity 0");
    }
  }
  if (!all_empty(residuals) || !escapes.empty()) {
    return fail("more packed disparities than valid grid points");
  }
  return disparities;
}

bool size_in_range(int rows, int columns) {
  return rows > 0 && columns > 0 && rows <= kMaxGridSide && columns <= kMaxGridSide &&
         std::int64_t{rows} * columns <= kMaxGridPoints;
}

std::string size_text(int rows, int columns) {
  return std::to_string(columns) + "x" + std::to_string(rows);
}

void append_16(Bytes& bytes, int value) {
  bytes.push_back(static_cast<std::uint8_t>(value));
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
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

  Streams streams;
  pack_symbols(symbols_of(grid), columns, streams);
  pack_disparities(grid, streams);
  Bytes packed{kVersion};
  append_16(packed, columns);
  append_16(packed, rows);
  for_each_stream(streams, [&](const Bytes& stream, Redundancy redundancy) {
    append_stream(packed, stream, redundancy);
  });
  return packed;
}

Result<DisparityGrid> unpack(std::span<const std::uint8_t> packed, int rows, int columns) {
  if (packed.size() < kPreambleBytes) return fail("packed bytes end too early");
  if (packed[0] != kVersion) {
    return fail("packed in version " + std::to_string(packed[0]) + ", this program knows " +
                std::to_string(kVersion));
  }
  const int packed_columns = packed[1] | packed[2] << 8;
  const int packed_rows = packed[3] | packed[4] << 8;
  if (packed_columns != columns || packed_rows != rows || !size_in_range(rows, columns)) {
    return fail("packed grid is " + size_text(packed_rows, packed_columns) + ", message says " +
                size_text(rows, columns));
  }
  const std::size_t points = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  StreamReader reader(packed.subspan(kPreambleBytes), 4 * points + 1);
  Streams streams;
  Result<void> read;
  for_each_stream(streams, [&](Bytes& stream, Redundancy) {
    if (!read) return;
    auto bytes = reader.next();
    if (bytes) {
      stream = std::move(*bytes);
    } else {
      read = fail(bytes.error().message);
    }
  });
  if (!read) return fail(read.error().message);
  if (!reader.at_end()) return fail("bytes after the end of the packed grid");

  const auto symbols = unpack_symbols(streams, rows, columns);
  if (!symbols) return fail(symbols.error().message);
  const auto disparities = unpack_disparities(streams, *symbols, columns);
  if (!disparities) return fail(disparities.error().message);
  const cv::Rect inside(1, 1, columns, rows);
  DisparityGrid grid;
  grid.disparity_16ths = (*disparities)(inside).clone();
  grid.code = (*symbols)(inside)&kMaxCode;
  return grid;
}

}  // namespace cairn::messages
