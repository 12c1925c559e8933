// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <cstdio>

#include "camera/mount.hpp"
#include "camera/rig_calibration.hpp"
#include "core/atomic_file.hpp"
#include "core/config.hpp"

namespace cairn::camera {
namespace {

struct NamedDistortion {
  const char* name;
  Distortion distortion;
};
constexpr std::array<NamedDistortion, 3> kDistortions{{
    {"none", Distortion::kNone},
    {"radial-tangential", Distortion::kRadialTangential},
    {"equidistant", Distortion::kEquidistant},
}};

struct CameraSection {
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;
  std::string distortion = "none";
  std::vector<double> coefficients;

  void visit(ConfigVisitor& v) {
    v.number("fx_px", fx_px, {1, 1e6}, "px", "focal length along a row");
    v.number("fy_px", fy_px, {1, 1e6}, "px", "focal length along a column");
    v.number("cx_px", cx_px, {-1e6, 1e6}, "px", "principal point; pixel centres at whole numbers");
    v.number("cy_px", cy_px, {-1e6, 1e6}, "px", "principal point");
    v.choice("distortion", distortion, {"none", "radial-tangential", "equidistant"},
             "how the lens bends");
    v.numbers("coefficients", coefficients, 0, 8, {}, "",
              "k1 k2 p1 p2 [k3 [k4 k5 k6]], or k1 k2 k3 k4 if equidistant");
  }
};

struct PoseSection {
  std::vector<double> xyz_m;
  std::vector<double> rotation;

  void visit(ConfigVisitor& v) {
    v.numbers("xyz_m", xyz_m, 3, 3, {-100, 100}, "m", "translation");
    v.numbers("rotation", rotation, 9, 9, {-1.001, 1.001}, "", "3 x 3, row by row");
  }
};

/// What the program writes: both poses in full, so that no bit is lost.
struct WrittenRig {
  int width_px = 0;
  int height_px = 0;
  bool rectified = false;
  CameraSection left;
  CameraSection right;
  PoseSection T_right_left;
  PoseSection T_body_left;

  void visit(ConfigVisitor& v) {
    v.integer("width_px", width_px, 1, 32768, "px", "image width");
    v.integer("height_px", height_px, 1, 32768, "px", "image height");
    v.flag("rectified", rectified, "images are already row-aligned and free of distortion");
    v.group("left", left, "the left camera");
    v.group("right", right, "the right camera");
    v.group("T_right_left", T_right_left, "maps left camera coordinates into the right camera");
    v.group("T_body_left", T_body_left, "maps left camera coordinates into the body");
  }
};

/// What a person may write: a mount instead of T_body_left.
struct ReadRig : WrittenRig {
  MountConfig mount;

  void visit(ConfigVisitor& v) {
    WrittenRig::visit(v);
    v.group("mount", mount, "instead of T_body_left: where the left camera sits and looks");
  }
};

CameraModel model(const CameraSection& section) {
  CameraModel camera{section.fx_px, section.fy_px,     section.cx_px,
                     section.cy_px, Distortion::kNone, section.coefficients};
  for (const auto& [name, distortion] : kDistortions) {
    if (section.distortion == name) camera.distortion = distortion;
  }
  return camera;
}

CameraSection section(const CameraModel& camera) {
  CameraSection section{camera.fx_px, camera.fy_px, camera.cx_px,
                        camera.cy_px, "none",       camera.coefficients};
  for (const auto& [name, distortion] : kDistortions) {
    if (camera.distortion == distortion) section.distortion = name;
  }
  return section;
}

/// A rotation that is not given is none.
Isometry pose(const PoseSection& section) {
  Isometry T = Isometry::Identity();
  if (section.xyz_m.size() == 3)
    T.translation() = Eigen::Map<const Eigen::Vector3d>(section.xyz_m.data());
  if (section.rotation.size() == 9) {
    T.linear() =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(section.rotation.data());
  }
  return T;
}

PoseSection section(const Isometry& T) {
  PoseSection section;
  for (int row = 0; row < 3; ++row) {
    section.xyz_m.push_back(T.translation()[row]);
    for (int column = 0; column < 3; ++column) section.rotation.push_back(T.linear()(row, column));
  }
  return section;
}

bool given(const PoseSection& section) {
  return !section.xyz_m.empty() || !section.rotation.empty();
}
bool given(const MountConfig& mount) { return !mount.xyz_m.empty() || !mount.rpy_deg.empty(); }

std::string hex(std::uint64_t id) {
  std::array<char, 20> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(id));
  return text.data();
}

}  // namespace

Result<RigCalibration> load_rig(const std::string& path) {
  auto file = load_yaml<ReadRig>(path);
  if (!file) return tl::make_unexpected(file.error());
  if (file->T_right_left.xyz_m.empty()) return fail(path + ": T_right_left.xyz_m: is missing");
  if (given(file->T_body_left) == given(file->mount)) {
    return fail(path + ": one of T_body_left and mount must be given");
  }
  RigCalibration rig;
  rig.width_px = file->width_px;
  rig.height_px = file->height_px;
  rig.left = model(file->left);
  rig.right = model(file->right);
  rig.T_right_left = pose(file->T_right_left);
  rig.T_body_left = given(file->mount) ? mounted(file->mount) : pose(file->T_body_left);
  rig.rectified = file->rectified;
  rig.id = calibration_id(rig);
  if (const auto checked = check(rig); !checked) return fail(path + ": " + checked.error().message);
  return rig;
}

Result<void> save_rig(const std::string& path, const RigCalibration& rig) {
  if (const auto checked = check(rig); !checked) return fail(path + ": " + checked.error().message);
  WrittenRig file;
  file.width_px = rig.width_px;
  file.height_px = rig.height_px;
  file.rectified = rig.rectified;
  file.left = section(rig.left);
  file.right = section(rig.right);
  file.T_right_left = section(rig.T_right_left);
  file.T_body_left = section(rig.T_body_left);
  const std::string text = "# A camera rig, id " + hex(calibration_id(rig)) +
                           ". What it means: config/calibration/README.md\n" +
                           print_config("", [&](ConfigVisitor& visitor) { file.visit(visitor); });
  return write_file_atomically(path, std::vector<std::uint8_t>(text.begin(), text.end()));
}

}  // namespace cairn::camera
