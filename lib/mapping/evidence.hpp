// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>

#include "core/config.hpp"

namespace cairn::mapping {

/// What is known of a voxel. Values are what goes over the bus.
enum class VoxelClass : std::uint8_t { kUnknown = 0, kFree = 1, kOccupied = 2 };

/// When evidence makes a voxel occupied or free (Ferrese 2012: separate occupied and empty
/// evidence). With evidence occ and emp, the occupied share is occ / (occ + emp + prior), the free
/// share emp / (occ + emp + prior).
struct EvidenceConfig {
  double prior = 2;
  double occupied_share = 0.5;
  int occupied_support = 8;
  double free_share = 0.5;
  int free_support = 2;

  void visit(ConfigVisitor& v) {
    v.number("prior", prior, {0, 100}, "evidence", "doubt that every voxel starts with");
    v.number("occupied_share", occupied_share, {0.05, 0.95}, "1",
             "a voxel is occupied when its occupied share is over this");
    v.integer("occupied_support", occupied_support, 1, 255, "evidence",
              "and its occupied evidence is at least this");
    v.number("free_share", free_share, {0.05, 0.95}, "1",
             "a voxel is free when it is not occupied and its free share is over this");
    v.integer("free_support", free_support, 1, 255, "evidence",
              "and its empty evidence is at least this");
  }
};

/// EvidenceConfig as a function of the two counters.
class EvidenceRule {
 public:
  explicit EvidenceRule(const EvidenceConfig& config);

  [[nodiscard]] VoxelClass classify(std::uint8_t occupied, std::uint8_t empty) const {
    if (empty < occupied_below_[occupied]) return VoxelClass::kOccupied;
    return empty >= free_from_[occupied] ? VoxelClass::kFree : VoxelClass::kUnknown;
  }

  /// A voxel without occupied evidence is free from this much empty evidence on; 256: never.
  [[nodiscard]] int free_from() const { return free_from_[0]; }

 private:
  std::array<std::uint16_t, 256> occupied_below_{};  ///< by occupied evidence
  std::array<std::uint16_t, 256> free_from_{};
};

}  // namespace cairn::mapping
