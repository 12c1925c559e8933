// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/disparity_t.hpp>
#include <cairn/odometry_t.hpp>
#include <cstdint>
#include <utility>

#include "core/result.hpp"
#include "procs/simulator/capture.hpp"
#include "simulation/disparity_model.hpp"
#include "simulation/odometry_model.hpp"

namespace cairn {

/// What stereo and odometry would have made of the captures, without pictures, by models of their
/// errors; as it goes over the bus.
class FastSenses {
 public:
  FastSenses(simulation::DisparityModel disparity, simulation::OdometryModel odometry,
             std::uint64_t calibration_id)
      : disparity_{std::move(disparity)},
        odometry_{std::move(odometry)},
        calibration_id_{calibration_id} {}

  [[nodiscard]] Result<disparity_t> disparity(const Capture& capture) const;
  /// Once for each capture, in order.
  [[nodiscard]] odometry_t odometry(const Capture& capture);

 private:
  simulation::DisparityModel disparity_;
  simulation::OdometryModel odometry_;
  std::uint64_t calibration_id_;
};

}  // namespace cairn
