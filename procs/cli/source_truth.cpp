// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/source_truth.hpp"

#include "bus/channels.hpp"
#include "bus/codec.hpp"
#include "bus/recording.hpp"
#include "camera/frame_source.hpp"
#include "messages/calibration_messages.hpp"
#include "messages/geometry_messages.hpp"
#include "procs/cli/truth.hpp"

namespace cairn::cli {

namespace channels = bus::channels;

namespace {

/// What truth by lines (KITTI) needs: the times of the source's frames, of which some may have been
/// skipped, and where the camera sits; and what the source itself knows of the truth.
struct SourceFrames {
  std::vector<Utime> utimes;
  Isometry T_body_left = Isometry::Identity();
  evaluation::Trajectory truth;
};

void take(const bus::RawMessage& raw, SourceFrames& frames) {
  if (raw.channel == channels::StereoFrame::name) {
    const auto header = bus::peek_header(raw.bytes);
    if (header) frames.utimes.push_back(header->utime);
  } else if (raw.channel == channels::Calibration::name) {
    const auto message = bus::decode<rig_calibration_t>(raw.bytes);
    const auto rig = message ? messages::to_rig(*message) : tl::make_unexpected(message.error());
    if (rig) frames.T_body_left = rig->T_body_left;
  } else if (raw.channel == channels::Truth::name) {
    const auto message = bus::decode<pose_t>(raw.bytes);
    if (!message) return;
    const auto T = messages::to_isometry(message->T_map_body, "T_map_body");
    const Utime utime = message->header.utime;
    if (T && (frames.truth.empty() || frames.truth.back().utime < utime))
      frames.truth.push_back({utime, *T});
  }
}

Result<SourceFrames> frames_of_recording(const std::filesystem::path& recording) {
  auto reader = bus::RecordingReader::open(recording);
  if (!reader) return tl::make_unexpected(reader.error());
  SourceFrames frames;
  while (const auto event = reader->next()) take(event->message, frames);
  return frames;
}

Result<SourceFrames> frames_of(const RunPlan& plan) {
  if (!plan.source_is_dataset) return frames_of_recording(plan.source);
  auto dataset = camera::open_dataset(plan.source.string());
  if (!dataset) return tl::make_unexpected(dataset.error());
  return SourceFrames{dataset->info.utimes, dataset->frames->rig().T_body_left, {}};
}

}  // namespace

Result<RunTruth> source_truth(const RunPlan& plan) {
  auto frames = frames_of(plan);
  if (!frames) return tl::make_unexpected(frames.error());
  RunTruth truth;
  if (plan.truth.empty()) {
    truth.T_truth_body = std::move(frames->truth);
    return truth;
  }
  auto read = read_body_truth(plan.truth, plan.truth_format, plan.truth_frame, frames->utimes,
                              frames->T_body_left);
  if (!read) return tl::make_unexpected(read.error());
  truth.T_truth_body = std::move(*read);
  return truth;
}

}  // namespace cairn::cli
