// SPDX-License-Identifier: Apache-2.0
#include "planning/ground_model.hpp"

#include <algorithm>
#include <vector>

namespace cairn::planning {
namespace {

constexpr double kAroundStands_m = 1.5;

}  // namespace

void GroundModel::take(const mapping::MapReplica::Changes& changes) {
  if (changes.started_over) {
    columns_.clear();
    waiting_.clear();
    changed_ = true;
  }
  waiting_.insert(waiting_.end(), changes.bricks.begin(), changes.bricks.end());
}

void GroundModel::read(const mapping::MapReplica& map) {
  if (waiting_.empty()) return;
  const auto count = static_cast<std::ptrdiff_t>(std::min(waiting_.size(), kBricksPerStep));
  const std::vector<mapping::BrickIndex> bricks(waiting_.begin(), waiting_.begin() + count);
  waiting_.erase(waiting_.begin(), waiting_.begin() + count);
  columns_.update(map, bricks);
  changed_ = true;
}

bool GroundModel::refresh(Utime now, std::span<const KnownFloor> known,
                          std::span<const BlockedSpot> blocked) {
  if (!changed_ || known.empty() || (now >= judged_ && now < judged_ + kPeriod_us)) return false;
  columns_.cover(known.front().at_m, kAroundStands_m);
  columns_.cover(known.back().at_m, kAroundStands_m);
  ground_ = judge_ground(columns_, known, blocked, config_, robot_);
  costs_ = route_costs(ground_, robot_.turning_radius_m(), route_config_);
  judged_ = now;
  changed_ = false;
  return true;
}

}  // namespace cairn::planning
