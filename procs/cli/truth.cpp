// SPDX-License-Identifier: Apache-2.0
#include "procs/cli/truth.hpp"

#include <fstream>
#include <sstream>

namespace cairn::cli {

Result<std::string> guess_format(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) return fail(file.string() + ": cannot open");
  for (std::string line; std::getline(stream, line);) {
    if (line.empty() || line.front() == '#') continue;
    if (line.find(',') != std::string::npos) return std::string("euroc");
    std::istringstream fields(line);
    int count = 0;
    for (std::string field; fields >> field;) ++count;
    if (count == 12) return std::string("kitti");
    if (count == 8) return std::string("tum");
    break;
  }
  return fail(file.string() + ": is neither TUM (8 numbers a line), KITTI (12) nor EuRoC (commas)");
}

Result<evaluation::Trajectory> read_body_truth(const std::filesystem::path& file,
                                               std::string format, std::string frame,
                                               std::span<const Utime> frame_times,
                                               const Isometry& T_body_left) {
  if (format.empty()) {
    auto guessed = guess_format(file);
    if (!guessed) return tl::make_unexpected(guessed.error());
    format = *guessed;
  }
  if (frame.empty()) frame = format == "kitti" ? "left_camera" : "body";
  auto poses = evaluation::read_trajectory(file, format, frame_times);
  if (!poses) return poses;
  if (frame == "left_camera") return evaluation::body_from_left_camera(*poses, T_body_left);
  const Isometry T_first_world = poses->front().T.inverse();
  for (evaluation::StampedPose& pose : *poses) pose.T = T_first_world * pose.T;
  return poses;
}

}  // namespace cairn::cli
