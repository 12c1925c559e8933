// SPDX-License-Identifier: Apache-2.0
#include "evaluation/report.hpp"

#include <algorithm>

#include "core/atomic_file.hpp"

namespace cairn::evaluation {
namespace {

using Json = nlohmann::ordered_json;

template <class Value>
Json or_null(const std::optional<Value>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json or_null(const std::optional<Percentiles>& value) {
  if (!value) return nullptr;
  return {{"p50", value->p50}, {"p95", value->p95}, {"p99", value->p99}};
}

Json trajectory_json(const TrajectoryReport& trajectory) {
  return {{"length_m", or_null(trajectory.length_m)},
          {"ate_rmse_m", or_null(trajectory.ate_rmse_m)},
          {"final_ate_rmse_m", or_null(trajectory.final_ate_rmse_m)},
          {"odometry_ate_rmse_m", or_null(trajectory.odometry_ate_rmse_m)},
          {"rpe_1m", or_null(trajectory.rpe_1m)},
          {"end_error_m", or_null(trajectory.end_error_m)},
          {"end_error_fraction", or_null(trajectory.end_error_fraction)},
          {"end_yaw_error_rad", or_null(trajectory.end_yaw_error_rad)}};
}

Json map_json(const MapReport& map) {
  return {{"resolution_m", or_null(map.resolution_m)},
          {"tolerance_m", or_null(map.tolerance_m)},
          {"precision", or_null(map.precision)},
          {"recall", or_null(map.recall)},
          {"iou", or_null(map.iou)},
          {"false_free_rate", or_null(map.false_free_rate)},
          {"bytes", or_null(map.bytes)}};
}

Json latency_json(const LatencyReport& latency) {
  return {{"frame_to_pose", or_null(latency.frame_to_pose)},
          {"frame_to_correction", or_null(latency.frame_to_correction)},
          {"frame_to_map", or_null(latency.frame_to_map)}};
}

}  // namespace

std::optional<Percentiles> percentiles(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const auto at_percent = [&](std::size_t percent) {
    const std::size_t rank = (values.size() * percent + 99) / 100;
    return values[std::max<std::size_t>(rank, 1) - 1];
  };
  return Percentiles{at_percent(50), at_percent(95), at_percent(99)};
}

nlohmann::ordered_json to_json(const Report& report) {
  return {{"finished", report.finished},
          {"reason", report.reason},
          {"mode", report.mode},
          {"coverage", or_null(report.coverage)},
          {"trajectory", trajectory_json(report.trajectory)},
          {"map", map_json(report.map)},
          {"latency_ms", latency_json(report.latency_ms)},
          {"dropped", or_null(report.dropped)},
          {"skipped", or_null(report.skipped)},
          {"restarts", or_null(report.restarts)},
          {"collisions", or_null(report.collisions)},
          {"realtime_factor", or_null(report.realtime_factor)},
          {"cpu_cores", or_null(report.cpu_cores)}};
}

Result<void> write_report(const std::filesystem::path& file, const Report& report) {
  const std::string text =
      to_json(report).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  return write_file_atomically(file,
                               {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace cairn::evaluation
