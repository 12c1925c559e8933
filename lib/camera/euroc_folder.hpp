// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "camera/recording.hpp"

namespace cairn::camera {

/// The rig of two EuRoC sensor files (Burri et al. 2016). T_BS maps the sensor into the body, which
/// is the recording's own (its inertial sensor).
[[nodiscard]] Result<RigCalibration> load_euroc_rig(const std::filesystem::path& left_sensor,
                                                    const std::filesystem::path& right_sensor);

/// The recording under `mav0`: cam0 and cam1 with data/*.png and sensor.yaml; data.csv, where it is
/// there, says which images there must be and when they were taken, else their names do; the truth
/// in state_groundtruth_estimate0.
[[nodiscard]] Result<Recording> find_euroc_recording(const std::filesystem::path& mav0);

}  // namespace cairn::camera
