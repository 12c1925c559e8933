// SPDX-License-Identifier: Apache-2.0
#include "localization/surface.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <bit>

namespace cairn::localization {
namespace {

using mapping::BrickIndex;
using mapping::kBrickSide;
using mapping::VoxelIndex;

constexpr int kFewestVoxels = 4;
/// How thin, compared with its extent, what is a wall or a rod must be (ratio of variances).
constexpr double kThin = 0.25;

struct Moments {
  std::int64_t count = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
};

/// Of the occupied voxels' indices, counted from `low`, in [low, high].
Moments moments_of(const mapping::MapReplica& map, VoxelIndex low, VoxelIndex high) {
  // Integer sums are exact, and the same in any order.
  std::int64_t n = 0, x1 = 0, y1 = 0, z1 = 0;
  std::int64_t xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
  mapping::MapReplica::Grid::Cursor bricks{map.grid()};
  const BrickIndex first = mapping::brick_of(low);
  const BrickIndex last = mapping::brick_of(high);
  for (std::int32_t bz = first.z; bz <= last.z; ++bz) {
    for (std::int32_t by = first.y; by <= last.y; ++by) {
      for (std::int32_t bx = first.x; bx <= last.x; ++bx) {
        const mapping::ClassBrick* brick = bricks.find({bx, by, bz});
        if (brick == nullptr) continue;
        const auto from = [](std::int32_t at, std::int32_t b) {
          return std::max(at - b * kBrickSide, 0);
        };
        const auto to = [](std::int32_t at, std::int32_t b) {
          return std::min(at - b * kBrickSide, kBrickSide - 1);
        };
        std::uint64_t wanted = 0;
        for (int y = from(low.y, by); y <= to(high.y, by); ++y) {
          for (int x = from(low.x, bx); x <= to(high.x, bx); ++x) {
            wanted |= std::uint64_t{1} << (x + 8 * y);
          }
        }
        for (int z = from(low.z, bz); z <= to(high.z, bz); ++z) {
          std::uint64_t bits = brick->occupied.words[static_cast<std::size_t>(z)] & wanted;
          for (; bits != 0; bits &= bits - 1) {
            const int place = std::countr_zero(bits);
            const std::int64_t vx = bx * kBrickSide + (place & 7) - low.x;
            const std::int64_t vy = by * kBrickSide + (place >> 3) - low.y;
            const std::int64_t vz = bz * kBrickSide + z - low.z;
            ++n;
            x1 += vx, y1 += vy, z1 += vz;
            xx += vx * vx, yy += vy * vy, zz += vz * vz;
            xy += vx * vy, xz += vx * vz, yz += vy * vz;
          }
        }
      }
    }
  }
  const auto d = [](std::int64_t value) { return static_cast<double>(value); };
  Moments moments;
  moments.count = n;
  moments.sum << d(x1), d(y1), d(z1);
  moments.squares << d(xx), d(xy), d(xz), d(xy), d(yy), d(yz), d(xz), d(yz), d(zz);
  return moments;
}

std::optional<SurfacePatch> fit(const mapping::MapReplica& map, VoxelIndex low, VoxelIndex high) {
  const Moments moments = moments_of(map, low, high);
  if (moments.count < kFewestVoxels) return std::nullopt;
  const auto count = static_cast<double>(moments.count);
  const Eigen::Vector3d mean = moments.sum / count;
  Eigen::Matrix3d covariance = moments.squares / count - mean * mean.transpose();
  // A voxel is no point: it has the variance of a cube of side 1.
  covariance.diagonal().array() += 1.0 / 12;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3d variance = solver.eigenvalues().cwiseMax(1.0 / 12);
  SurfacePatch patch;
  if (variance[0] < kThin * variance[1]) {
    patch.directions = 1;
  } else if (variance[1] < kThin * variance[2]) {
    patch.directions = 2;
  } else {
    return std::nullopt;
  }
  const double side_m = map.resolution_m();
  patch.middle_m =
      (Eigen::Vector3d(low.x, low.y, low.z) + mean + Eigen::Vector3d::Constant(0.5)) * side_m;
  for (int i = 0; i < patch.directions; ++i) {
    patch.across[i] = solver.eigenvectors().col(i);
    patch.sigma_m[i] = std::sqrt(variance[i]) * side_m;
  }
  return patch;
}

}  // namespace

const SurfacePatch* Surfaces::near(const Eigen::Vector3d& point_m, const DistanceField& field,
                                   const mapping::MapReplica& map) {
  const CellIndex cell = field.cell_at(point_m);
  constexpr std::uint64_t kGoldenRatio = 0x9e3779b97f4a7c15ULL;
  Slot& slot = slots_[(mapping::packed(cell) * kGoldenRatio) >> (64 - std::bit_width(kSlots - 1))];
  if (slot.version != field.version() || slot.cell != cell) {
    const int side = field.voxels_per_cell();
    const VoxelIndex low{(cell.x - 1) * side, (cell.y - 1) * side, (cell.z - 1) * side};
    const VoxelIndex high{low.x + 3 * side - 1, low.y + 3 * side - 1, low.z + 3 * side - 1};
    slot = {field.version(), cell, fit(map, low, high)};
  }
  return slot.patch ? &*slot.patch : nullptr;
}

}  // namespace cairn::localization
