// SPDX-License-Identifier: Apache-2.0
#include "mapping/brick_carving.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>

// Compiled once for each kind of processor; the best one is chosen at run time. All give the same:
// no step rounds differently where registers are wider.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/brick_carving.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace cairn::mapping::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, 16>;
using Ints = hn::RebindToSigned<Floats>;

VoxelMask VoxelsInFreeSpace(const BrickBeforeCamera& brick, const LayerOffsets& offsets) {
  const Floats d;
  const Ints di;
  const auto scale = hn::Set(d, brick.scale);
  const auto cx = hn::Set(d, brick.cx);
  const auto cy = hn::Set(d, brick.cy);
  const auto width = hn::Set(d, brick.width);
  const auto height = hn::Set(d, brick.height);
  const auto stride = hn::Set(di, brick.stride);
  const auto half_depth = hn::Set(d, brick.half_depth_m);
  const auto least_depth = hn::Set(d, brick.least_depth_m);
  const auto clear_to = hn::Set(d, brick.clear_to_m);
  const auto hidden_from = hn::Set(d, brick.hidden_from_m);
  VoxelMask free;
  for (std::size_t layer = 0; layer < kBrickSide; ++layer) {
    const auto n = static_cast<float>(layer);
    const auto first_x = hn::Set(d, brick.first[0] + n * brick.layer[0]);
    const auto first_y = hn::Set(d, brick.first[1] + n * brick.layer[1]);
    const auto first_depth = hn::Set(d, brick.first[2] + n * brick.layer[2]);
    for (std::size_t i = 0; i < 64; i += hn::Lanes(d)) {
      const auto depth = hn::Add(first_depth, hn::Load(d, offsets.depth_m.data() + i));
      const auto end = hn::Add(depth, half_depth);
      const auto asked = hn::And(hn::Lt(end, hidden_from), hn::Gt(depth, least_depth));
      if (hn::AllFalse(d, asked)) continue;
      auto is_free = hn::Lt(end, clear_to);
      if (!hn::AllTrue(d, is_free)) {
        const auto x = hn::Add(first_x, hn::Load(d, offsets.x_px_m.data() + i));
        const auto y = hn::Add(first_y, hn::Load(d, offsets.y_px_m.data() + i));
        const auto per_depth = hn::Div(scale, depth);
        const auto u = hn::Add(hn::Mul(x, per_depth), cx);
        const auto v = hn::Add(hn::Mul(y, per_depth), cy);
        const auto zero = hn::Zero(d);
        const auto in_columns = hn::And(hn::Ge(u, zero), hn::Lt(u, width));
        const auto in_rows = hn::And(hn::Ge(v, zero), hn::Lt(v, height));
        const auto in_image = hn::And(asked, hn::And(in_columns, in_rows));
        const auto column = hn::ConvertTo(di, hn::IfThenElseZero(in_image, u));
        const auto row = hn::ConvertTo(di, hn::IfThenElseZero(in_image, v));
        const auto at = hn::Add(hn::Mul(row, stride), column);
        const auto nearest = hn::GatherIndex(d, brick.nearest_m, at);
        is_free = hn::And(in_image, hn::Lt(end, nearest));
      }
      std::uint8_t bytes[8] = {};
      hn::StoreMaskBits(d, is_free, bytes);
      std::uint64_t bits = 0;
      std::memcpy(&bits, bytes, sizeof bits);
      free.words[layer] |= bits << i;
    }
  }
  return free;
}

}  // namespace cairn::mapping::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cairn::mapping {

HWY_EXPORT(VoxelsInFreeSpace);

VoxelMask voxels_in_free_space(const BrickBeforeCamera& brick, const LayerOffsets& offsets) {
  return HWY_DYNAMIC_DISPATCH(VoxelsInFreeSpace)(brick, offsets);
}

}  // namespace cairn::mapping
#endif
