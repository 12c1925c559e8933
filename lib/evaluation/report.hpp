// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"

namespace cairn::evaluation {

/// Nearest-rank percentiles: the smallest value that this share of all lies at or below.
struct Percentiles {
  double p50 = 0;
  double p95 = 0;
  double p99 = 0;
};
/// Nothing of no values.
[[nodiscard]] std::optional<Percentiles> percentiles(std::vector<double> values);

/// Definitions: trajectory_score.hpp. Published: as the robot said at the time. Final: after the
/// pose graph.
struct TrajectoryReport {
  std::optional<double> length_m;
  std::optional<double> ate_rmse_m;
  std::optional<double> final_ate_rmse_m;
  std::optional<double> odometry_ate_rmse_m;
  std::optional<double> rpe_1m;              ///< translation RMSE over 1 m of way [m]
  std::optional<double> end_error_m;         ///< at the last pose, aligned at the first alone
  std::optional<double> end_error_fraction;  ///< of the true way
  std::optional<double> end_yaw_error_rad;
};

/// Definitions: map_score.hpp; after align_maps of the trajectory.
struct MapReport {
  std::optional<double> resolution_m;
  std::optional<double> tolerance_m;
  std::optional<double> precision;
  std::optional<double> recall;
  std::optional<double> iou;
  std::optional<double> false_free_rate;
  std::optional<std::uint64_t> bytes;  ///< of memory that the map takes
};

/// Host time from the sending of a frame to what came of it [ms].
struct LatencyReport {
  std::optional<Percentiles> frame_to_pose;
  std::optional<Percentiles> frame_to_correction;
  std::optional<Percentiles> frame_to_map;
};

/// report.json of a demo or a replay. What was not measured stays empty and is written as null.
struct Report {
  bool finished = false;
  std::string reason;              ///< why it ended, in words
  std::string mode = "full";       ///< full, or fast (statistics only)
  std::optional<double> coverage;  ///< share of the reachable free floor that was seen
  TrajectoryReport trajectory;
  MapReport map;
  LatencyReport latency_ms;
  std::optional<std::map<std::string, std::uint64_t>> dropped;   ///< per channel: lost in transport
  std::optional<std::map<std::string, std::uint64_t>> skipped;   ///< per channel: a newer one won
  std::optional<std::map<std::string, std::uint64_t>> restarts;  ///< per process
  std::optional<std::uint64_t> collisions;  ///< contacts while moving at over 0.05 m/s
  std::optional<double> realtime_factor;    ///< data time / host time
  std::optional<std::map<std::string, double>> cpu_cores;  ///< per process: mean share of a core
};

/// Every key, always, in one order.
[[nodiscard]] nlohmann::ordered_json to_json(const Report& report);

/// Two-space indented, ends with a line break, replaced atomically.
[[nodiscard]] Result<void> write_report(const std::filesystem::path& file, const Report& report);

}  // namespace cairn::evaluation
