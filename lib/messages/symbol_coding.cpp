// SPDX-License-Identifier: Apache-2.0
#include "messages/symbol_coding.hpp"

#include <array>

#include "messages/range_coder.hpp"

namespace cairn::messages {
namespace {

/// What is known of a symbol before it is coded.
struct Neighbours {
  std::size_t left;
  std::size_t above;
  std::size_t above_right;
};

Neighbours neighbours(const std::uint8_t* row, const std::uint8_t* row_above, int column) {
  return {row[column - 1], row_above[column], row_above[column + 1]};
}

/// "As above?", then "as to the left?", then the three bits; each by what the neighbours are.
/// `Coder` codes one bit: an encoder returns the bit that it is given, a decoder the one that it
/// reads.
class SymbolModel {
 public:
  template <class Coder>
  std::uint8_t code(Coder& coder, std::uint8_t symbol, const Neighbours& near) {
    const std::size_t pair = near.left * 8 + near.above;
    if (coder(as_above_[pair * 8 + near.above_right], symbol == near.above)) {
      return static_cast<std::uint8_t>(near.above);
    }
    if (near.left != near.above && coder(as_left_[pair], symbol == near.left)) {
      return static_cast<std::uint8_t>(near.left);
    }
    std::size_t node = 1;
    for (int bit = 2; bit >= 0; --bit) {
      node = node * 2 + (coder(bits_[pair * 8 + node], (symbol >> bit & 1) != 0) ? 1 : 0);
    }
    return static_cast<std::uint8_t>(node & 7);
  }

 private:
  std::array<BitModel, 512> as_above_;
  std::array<BitModel, 64> as_left_;
  std::array<BitModel, 512> bits_;
};

}  // namespace

Bytes encode_symbols(const SymbolGrid& symbols) {
  SymbolModel model;
  RangeEncoder encoder;
  const auto put = [&encoder](BitModel& bit_model, bool bit) {
    encoder.put(bit_model, bit);
    return bit;
  };
  const int columns = symbols.cols - 3;
  for (int r = 1; r < symbols.rows; ++r) {
    const std::uint8_t* row = symbols[r] + 1;
    const std::uint8_t* above = symbols[r - 1] + 1;
    for (int column = 0; column < columns; ++column) {
      model.code(put, row[column], neighbours(row, above, column));
    }
  }
  return encoder.finish();
}

Result<SymbolGrid> decode_symbols(std::span<const std::uint8_t> bytes, int rows, int columns) {
  auto symbols = framed<std::uint8_t>(rows, columns);
  SymbolModel model;
  RangeDecoder decoder(bytes);
  const auto get = [&decoder](BitModel& bit_model, bool) { return decoder.get(bit_model); };
  for (int r = 1; r <= rows; ++r) {
    std::uint8_t* row = symbols[r] + 1;
    const std::uint8_t* above = symbols[r - 1] + 1;
    for (int column = 0; column < columns; ++column) {
      row[column] = model.code(get, 0, neighbours(row, above, column));
    }
  }
  if (!decoder.exhausted()) return fail("packed codes are too few or too many");
  return symbols;
}

}  // namespace cairn::messages
