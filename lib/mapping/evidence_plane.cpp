// SPDX-License-Identifier: Apache-2.0
#include "mapping/evidence_plane.hpp"

#include <cstddef>
#include <cstring>

// Compiled once for each kind of processor; the best one is chosen at run time. All give the same.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "mapping/evidence_plane.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace cairn::mapping::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Bytes = hn::CappedTag<std::uint8_t, 64>;

void Add(std::uint8_t* plane, const VoxelMask& voxels, std::uint8_t evidence) {
  const Bytes d;
  const auto increment = hn::Set(d, evidence);
  for (std::size_t z = 0; z < kBrickSide; ++z) {
    if (voxels.words[z] == 0) continue;
    for (std::size_t i = 0; i < 64; i += hn::Lanes(d)) {
      const std::uint64_t bits = voxels.words[z] >> i;
      std::uint8_t bytes[8];
      std::memcpy(bytes, &bits, sizeof bits);
      std::uint8_t* at = plane + 64 * z + i;
      const auto selected = hn::IfThenElseZero(hn::LoadMaskBits(d, bytes), increment);
      hn::Store(hn::SaturatedAdd(hn::Load(d, at), selected), d, at);
    }
  }
}

VoxelMask AtLeast(const std::uint8_t* plane, std::uint8_t evidence) {
  const Bytes d;
  const auto threshold = hn::Set(d, evidence);
  VoxelMask mask;
  for (std::size_t z = 0; z < kBrickSide; ++z) {
    for (std::size_t i = 0; i < 64; i += hn::Lanes(d)) {
      const auto value = hn::Load(d, plane + 64 * z + i);
      std::uint64_t bits = 0;
      std::uint8_t bytes[8] = {};
      hn::StoreMaskBits(d, hn::Eq(hn::Max(value, threshold), value), bytes);
      std::memcpy(&bits, bytes, sizeof bits);
      mask.words[z] |= bits << i;
    }
  }
  return mask;
}

}  // namespace cairn::mapping::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace cairn::mapping {

HWY_EXPORT(Add);
HWY_EXPORT(AtLeast);

void EvidencePlane::add(const VoxelMask& voxels, std::uint8_t evidence) {
  HWY_DYNAMIC_DISPATCH(Add)(of.data(), voxels, evidence);
}

VoxelMask EvidencePlane::at_least(int evidence) const {
  if (evidence > 255) return {};
  return HWY_DYNAMIC_DISPATCH(AtLeast)(of.data(), static_cast<std::uint8_t>(evidence));
}

}  // namespace cairn::mapping
#endif
