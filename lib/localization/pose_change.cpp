// SPDX-License-Identifier: Apache-2.0
#include "localization/pose_change.hpp"

namespace cairn::localization {

Isometry changed_by(const Isometry& T_map_body, const Vector6d& change) {
  Isometry changed = T_map_body;
  changed.translation() += change.head<3>();
  changed.linear() = nearest_rotation(exp_so3(change.tail<3>()) * T_map_body.linear());
  return changed;
}

Vector6d change_between(const Isometry& from, const Isometry& to) {
  Vector6d change;
  change.head<3>() = to.translation() - from.translation();
  change.tail<3>() = log_so3(to.linear() * from.linear().transpose());
  return change;
}

}  // namespace cairn::localization
