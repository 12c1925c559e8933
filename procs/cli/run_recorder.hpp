// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/plan_state_t.hpp>
#include <cairn/process_status_t.hpp>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bus/node.hpp"
#include "bus/recording.hpp"
#include "evaluation/trajectory.hpp"

namespace cairn::cli {

/// Listens to a run and keeps what its report is made of. It is a listener like any other: nothing
/// on the robot depends on it.
class RunRecorder {
 public:
  /// Also writes a recording of the inputs and the small channels (`all`: of everything), if
  /// `recording` is not empty.
  [[nodiscard]] static Result<std::unique_ptr<RunRecorder>> create(
      bus::Node& node, const std::filesystem::path& recording, bool all);

  RunRecorder(bus::Node& node, std::optional<bus::RecordingWriter> writer, bool all);

  [[nodiscard]] const evaluation::Trajectory& odometry() const { return odometry_; }
  [[nodiscard]] const evaluation::Trajectory& poses() const { return poses_; }
  /// As published: POSE where a localizer runs, else ODOMETRY.
  [[nodiscard]] const evaluation::Trajectory& trajectory() const {
    return poses_.empty() ? odometry_ : poses_;
  }

  /// The same after the fact: ODOMETRY under the first correction that rests on that frame itself
  /// or a later one, where POSE had to do with an earlier one. Of frames that nothing later
  /// corrects in their epoch it is what was published.
  [[nodiscard]] evaluation::Trajectory final_trajectory() const;

  /// True poses in the world's frame, where a simulator tells them.
  [[nodiscard]] const evaluation::Trajectory& truth() const { return truth_; }
  /// How often the robot began to touch something while it moved; nothing without a simulator.
  [[nodiscard]] std::optional<std::uint64_t> collisions() const { return collisions_; }
  /// The newest of this run, if any.
  [[nodiscard]] const std::optional<plan_state_t>& plan_state() const { return plan_state_; }

  /// From the sending of a frame to the sending of what came of it, host time [ms].
  [[nodiscard]] const std::vector<double>& frame_to_pose_ms() const { return frame_to_pose_ms_; }
  /// To the first POSE that rests on what was seen in it.
  [[nodiscard]] const std::vector<double>& frame_to_correction_ms() const {
    return frame_to_correction_ms_;
  }
  [[nodiscard]] const std::vector<double>& frame_to_map_ms() const { return frame_to_map_ms_; }

  [[nodiscard]] std::int64_t frames() const { return frames_; }
  /// Data time from the first frame to the newest [us].
  [[nodiscard]] std::int64_t duration_us() const;
  /// Data time per host time, over the frames; nothing before the second.
  [[nodiscard]] std::optional<double> realtime_factor() const;
  /// Whether data time was set back: the source began anew.
  [[nodiscard]] bool set_back() const { return set_back_; }
  [[nodiscard]] HostTime last_result_us() const { return last_result_us_; }
  [[nodiscard]] bool heard(const std::string& process) const { return sessions_.contains(process); }
  /// How often a process began anew.
  [[nodiscard]] std::map<std::string, std::uint64_t> restarts() const;
  /// Processor time of each process per time that it ran, as it says itself: 1 is one core.
  [[nodiscard]] std::map<std::string, double> cpu_cores() const;
  /// Sums over all processes and their runs, by channel.
  [[nodiscard]] std::map<std::string, std::uint64_t> lost() const;
  [[nodiscard]] std::map<std::string, std::uint64_t> skipped() const;
  [[nodiscard]] std::map<std::string, std::uint64_t> refused() const;
  /// Messages that did not reach this listener itself: the recording lacks them.
  [[nodiscard]] std::int64_t missed() const { return missed_; }

 private:
  struct Moment {
    Utime utime;
    HostTime sent_us;
  };
  struct Correction {
    Isometry T_map_odom;
    Isometry T_odom_body;
    Utime rests_on;
    std::int32_t epoch;
  };

  void hear(const bus::RawMessage& raw);
  void keep(const bus::RawMessage& raw);
  void hear_frame(const bus::RawMessage& raw);
  void count_missed(const bus::RawMessage& raw);
  void hear_odometry(const bus::RawMessage& raw);
  void hear_pose(const bus::RawMessage& raw);
  void hear_map(const bus::RawMessage& raw);
  void hear_status(const bus::RawMessage& raw);
  void hear_truth(const bus::RawMessage& raw);
  void hear_contacts(const bus::RawMessage& raw);
  void hear_plan(const bus::RawMessage& raw);
  /// Of all frames up to `through`, which leave `waiting`.
  void add_latencies(std::map<Utime, HostTime>& waiting, Utime through, HostTime sent_us,
                     std::vector<double>& latencies);
  void add_latency(Utime utime, HostTime sent_us, std::vector<double>& latencies);
  template <class Count>
  [[nodiscard]] std::map<std::string, std::uint64_t> sum(Count count) const;

  bus::Node& node_;
  std::optional<bus::RecordingWriter> writer_;
  bool all_;
  evaluation::Trajectory odometry_;
  evaluation::Trajectory poses_;
  std::vector<Correction> corrections_;  ///< of each of poses_
  evaluation::Trajectory truth_;
  std::optional<std::uint64_t> collisions_;
  std::optional<plan_state_t> plan_state_;
  std::map<Utime, HostTime> frame_sent_us_;
  std::map<Utime, HostTime> not_mapped_yet_;
  std::map<Utime, HostTime> not_corrected_yet_;
  std::vector<double> frame_to_pose_ms_;
  std::vector<double> frame_to_correction_ms_;
  std::vector<double> frame_to_map_ms_;
  std::int64_t frames_ = 0;
  std::optional<Moment> first_frame_;
  Moment newest_frame_;
  bool set_back_ = false;
  std::map<std::pair<std::string, std::int64_t>, std::int32_t>
      last_sequence_;  ///< by channel and session
  std::int64_t missed_ = 0;
  HostTime last_result_us_ = 0;
  std::map<std::string, std::map<std::int64_t, process_status_t>>
      sessions_;  ///< newest status of each run
};

}  // namespace cairn::cli
