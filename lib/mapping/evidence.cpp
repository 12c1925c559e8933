// SPDX-License-Identifier: Apache-2.0
#include "mapping/evidence.hpp"

namespace cairn::mapping {
namespace {

bool is_occupied(const EvidenceConfig& config, int occupied, int empty) {
  return occupied >= config.occupied_support &&
         occupied > config.occupied_share * (occupied + empty + config.prior);
}

bool is_free(const EvidenceConfig& config, int occupied, int empty) {
  return empty >= config.free_support &&
         empty > config.free_share * (occupied + empty + config.prior);
}

}  // namespace

EvidenceRule::EvidenceRule(const EvidenceConfig& config) {
  for (std::size_t occupied = 0; occupied < 256; ++occupied) {
    int empty = 0;
    while (empty < 256 && is_occupied(config, static_cast<int>(occupied), empty)) ++empty;
    occupied_below_[occupied] = static_cast<std::uint16_t>(empty);
    empty = 0;
    while (empty < 256 && !is_free(config, static_cast<int>(occupied), empty)) ++empty;
    free_from_[occupied] = static_cast<std::uint16_t>(empty);
  }
}

}  // namespace cairn::mapping
