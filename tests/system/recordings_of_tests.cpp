// SPDX-License-Identifier: Apache-2.0
#include "system/recordings_of_tests.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cmath>
#include <stdexcept>

#include "camera/rig_calibration.hpp"
#include "data_folder.hpp"
#include "simulation/drive_path.hpp"
#include "simulation/sequence.hpp"
#include "simulation/world.hpp"

namespace cairn::testing {

namespace fs = std::filesystem;

void render_room(const fs::path& folder, std::size_t frames) {
  const auto world = simulation::load_world(fs::path(CAIRN_SOURCE_DIR) / "config/worlds/room.yaml");
  Isometry T_body_left = Isometry::Identity();
  T_body_left.translate(Eigen::Vector3d(0, 0.127, 0.45)).rotate(R_body_camera_forward());
  const double f_px = 320 / std::tan(M_PI / 6);
  const auto rig = camera::rectified_rig(f_px, f_px, 319.5, 239.5, 0.254, 640, 480, T_body_left);
  auto path = simulation::drive_round(simulation::room_tour_m(), {});
  path.resize(frames);
  simulation::SequenceConfig config;
  config.map_resolution_m = 0.05;
  const auto rendered = simulation::render_sequence(*world, rig, path, config, folder, {});
  if (!rendered) throw std::runtime_error(rendered.error().message);
}

fs::path rendered_room() {
  const fs::path folder = fs::path(CAIRN_BINARY_DIR) / "rendered_room";
  // Tests run side by side; the first one renders.
  const int lock = ::open((folder.string() + ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  ::flock(lock, LOCK_EX);
  if (!fs::exists(folder / "dataset.yaml")) {
    fs::remove_all(folder);
    render_room(folder, 60);
  }
  ::close(lock);
  return folder;
}

std::optional<fs::path> real_street() {
  const auto data = data_folder();
  if (!data || !fs::exists(*data / "sequence/kitti_1/dataset.yaml")) return std::nullopt;
  return *data / "sequence/kitti_1";
}

std::string program(const std::string& name) { return fs::path(CAIRN_BINARY_DIR) / "bin" / name; }

}  // namespace cairn::testing
