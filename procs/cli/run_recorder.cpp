// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/run_recorder.hpp"

#include <algorithm>

#include "bus/channels.hpp"
#include "bus/codec.hpp"
#include "messages/geometry_messages.hpp"

namespace cairn::cli {

namespace channels = bus::channels;

namespace {

bool is_large(const std::string& channel) {
  return channel == channels::Disparity::name || channel == channels::DisparityBand::name ||
         channel == channels::MapDelta::name;
}

void append(evaluation::Trajectory& trajectory, Utime utime, const Result<Isometry>& T) {
  if (!T || (!trajectory.empty() && utime <= trajectory.back().utime)) return;
  trajectory.push_back({utime, *T});
}

}  // namespace

Result<std::unique_ptr<RunRecorder>> RunRecorder::create(bus::Node& node,
                                                         const std::filesystem::path& recording,
                                                         bool all) {
  std::optional<bus::RecordingWriter> writer;
  if (!recording.empty()) {
    auto created = bus::RecordingWriter::create(recording);
    if (!created) return tl::make_unexpected(created.error());
    writer = std::move(*created);
  }
  return std::make_unique<RunRecorder>(node, std::move(writer), all);
}

RunRecorder::RunRecorder(bus::Node& node, std::optional<bus::RecordingWriter> writer, bool all)
    : node_{node}, writer_{std::move(writer)}, all_{all} {
  node.on_raw([this](const bus::RawMessage& raw) { hear(raw); });
}

void RunRecorder::hear(const bus::RawMessage& raw) {
  keep(raw);
  count_missed(raw);
  if (raw.channel == channels::StereoFrame::name || raw.channel == channels::Disparity::name)
    hear_frame(raw);
  if (raw.channel == channels::Odometry::name) hear_odometry(raw);
  if (raw.channel == channels::Pose::name) hear_pose(raw);
  if (raw.channel == channels::MapDelta::name) hear_map(raw);
  if (raw.channel == channels::ProcessStatus::name) hear_status(raw);
  if (raw.channel == channels::Truth::name) hear_truth(raw);
  if (raw.channel == channels::SimState::name) hear_contacts(raw);
  if (raw.channel == channels::PlanState::name) hear_plan(raw);
}

// Of a depth recording, and of a fast run, DISPARITY is the frame; else STEREO_FRAME came first.
void RunRecorder::hear_frame(const bus::RawMessage& raw) {
  const auto header = bus::peek_header(raw.bytes);
  if (!header) return;
  last_result_us_ = node_.host_time();
  if (!frame_sent_us_.try_emplace(header->utime, header->sent_steady_us).second) return;
  ++frames_;
  not_mapped_yet_.emplace(header->utime, header->sent_steady_us);
  not_corrected_yet_.emplace(header->utime, header->sent_steady_us);
  if (!first_frame_) {
    first_frame_ = newest_frame_ = {header->utime, header->sent_steady_us};
  } else if (header->utime > newest_frame_.utime) {
    newest_frame_ = {header->utime, header->sent_steady_us};
  } else if (header->utime < newest_frame_.utime - kMicrosecondsPerSecond) {
    set_back_ = true;
  }
}

std::int64_t RunRecorder::duration_us() const {
  return first_frame_ ? newest_frame_.utime - first_frame_->utime : 0;
}

std::optional<double> RunRecorder::realtime_factor() const {
  if (!first_frame_ || newest_frame_.sent_us <= first_frame_->sent_us) return std::nullopt;
  return static_cast<double>(duration_us()) /
         static_cast<double>(newest_frame_.sent_us - first_frame_->sent_us);
}

void RunRecorder::count_missed(const bus::RawMessage& raw) {
  const auto header = bus::peek_header(raw.bytes);
  if (!header) return;
  const auto [last, fresh] =
      last_sequence_.try_emplace({raw.channel, header->session}, header->sequence);
  if (fresh) return;
  if (header->sequence > last->second) missed_ += header->sequence - last->second - 1;
  last->second = header->sequence;
}

void RunRecorder::keep(const bus::RawMessage& raw) {
  if (!writer_ || (is_large(raw.channel) && !all_) || raw.channel == "LCM_SELF_TEST") return;
  if (auto written = writer_->write(node_.host_time(), raw.channel, raw.bytes); !written) {
    node_.log(bus::Level::kError, written.error().message + "; the recording ends here");
    writer_.reset();
  }
}

void RunRecorder::add_latency(Utime utime, HostTime sent_us, std::vector<double>& latencies) {
  last_result_us_ = node_.host_time();
  const auto frame = frame_sent_us_.find(utime);
  if (frame == frame_sent_us_.end()) return;
  latencies.push_back(1e-3 * static_cast<double>(sent_us - frame->second));
}

void RunRecorder::hear_odometry(const bus::RawMessage& raw) {
  const auto message = bus::decode<odometry_t>(raw.bytes);
  if (!message) return;
  append(odometry_, message->header.utime,
         messages::to_isometry(message->T_odom_body, "T_odom_body"));
  if (poses_.empty())
    add_latency(message->header.utime, message->header.sent_steady_us, frame_to_pose_ms_);
}

void RunRecorder::hear_pose(const bus::RawMessage& raw) {
  const auto message = bus::decode<pose_t>(raw.bytes);
  if (!message) return;
  if (poses_.empty()) frame_to_pose_ms_.clear();
  const auto T_map_body = messages::to_isometry(message->T_map_body, "T_map_body");
  const auto T_map_odom = messages::to_isometry(message->T_map_odom, "T_map_odom");
  if (!T_map_body || !T_map_odom) return;
  const std::size_t before = poses_.size();
  append(poses_, message->header.utime, T_map_body);
  if (poses_.size() > before) {
    corrections_.push_back({*T_map_odom, T_map_odom->inverse() * *T_map_body,
                            message->correction_utime, message->epoch});
  }
  add_latency(message->header.utime, message->header.sent_steady_us, frame_to_pose_ms_);
  add_latencies(not_corrected_yet_, message->correction_utime, message->header.sent_steady_us,
                frame_to_correction_ms_);
}

evaluation::Trajectory RunRecorder::final_trajectory() const {
  if (poses_.empty()) return odometry_;
  evaluation::Trajectory final = poses_;
  std::size_t later = 0;
  for (std::size_t i = 0; i < final.size(); ++i) {
    later = std::max(later, i);
    while (later < corrections_.size() && corrections_[later].rests_on < final[i].utime) ++later;
    if (later == corrections_.size()) break;
    if (corrections_[later].epoch == corrections_[i].epoch)
      final[i].T = corrections_[later].T_map_odom * corrections_[i].T_odom_body;
  }
  return final;
}

void RunRecorder::add_latencies(std::map<Utime, HostTime>& waiting, Utime through, HostTime sent_us,
                                std::vector<double>& latencies) {
  const auto end = waiting.upper_bound(through);
  for (auto frame = waiting.begin(); frame != end; ++frame) {
    latencies.push_back(1e-3 * static_cast<double>(sent_us - frame->second));
  }
  waiting.erase(waiting.begin(), end);
}

void RunRecorder::hear_map(const bus::RawMessage& raw) {
  const auto message = bus::decode<map_delta_t>(raw.bytes);
  if (!message) return;
  last_result_us_ = node_.host_time();
  add_latencies(not_mapped_yet_, message->complete_through_utime, message->header.sent_steady_us,
                frame_to_map_ms_);
}

void RunRecorder::hear_truth(const bus::RawMessage& raw) {
  const auto message = bus::decode<pose_t>(raw.bytes);
  if (!message) return;
  append(truth_, message->header.utime, messages::to_isometry(message->T_map_body, "T_map_body"));
}

void RunRecorder::hear_contacts(const bus::RawMessage& raw) {
  const auto message = bus::decode<sim_state_t>(raw.bytes);
  if (!message) return;
  collisions_ = static_cast<std::uint64_t>(std::max<std::int64_t>(message->collisions, 0));
}

void RunRecorder::hear_plan(const bus::RawMessage& raw) {
  if (auto message = bus::decode<plan_state_t>(raw.bytes)) plan_state_ = std::move(*message);
}

void RunRecorder::hear_status(const bus::RawMessage& raw) {
  auto message = bus::decode<process_status_t>(raw.bytes);
  if (!message) return;
  sessions_[message->process].insert_or_assign(message->header.session, std::move(*message));
}

std::map<std::string, std::uint64_t> RunRecorder::restarts() const {
  std::map<std::string, std::uint64_t> restarts;
  for (const auto& [process, sessions] : sessions_) {
    if (process != node_.process()) restarts[process] = sessions.size() - 1;
  }
  return restarts;
}

std::map<std::string, double> RunRecorder::cpu_cores() const {
  std::map<std::string, double> cores;
  for (const auto& [process, sessions] : sessions_) {
    double cpu_s = 0;
    double uptime_s = 0;
    for (const auto& [session, status] : sessions) {
      cpu_s += status.cpu_s;
      uptime_s += 1e-6 * static_cast<double>(status.uptime_us);
    }
    if (uptime_s > 0) cores[process] = cpu_s / uptime_s;
  }
  return cores;
}

template <class Count>
std::map<std::string, std::uint64_t> RunRecorder::sum(Count count) const {
  std::map<std::string, std::uint64_t> sums;
  for (const auto& [process, sessions] : sessions_) {
    if (process == node_.process()) continue;
    for (const auto& [session, status] : sessions) {
      for (const channel_status_t& channel : status.channels) {
        if (channel.received == 0 && count(channel) == 0) continue;
        sums[channel.channel] += static_cast<std::uint64_t>(count(channel));
      }
    }
  }
  return sums;
}

std::map<std::string, std::uint64_t> RunRecorder::lost() const {
  return sum([](const channel_status_t& channel) { return channel.lost; });
}
std::map<std::string, std::uint64_t> RunRecorder::skipped() const {
  return sum([](const channel_status_t& channel) { return channel.skipped; });
}
std::map<std::string, std::uint64_t> RunRecorder::refused() const {
  return sum([](const channel_status_t& channel) { return channel.refused; });
}

}  // namespace cairn::cli
