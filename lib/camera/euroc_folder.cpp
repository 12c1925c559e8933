// SPDX-License-Identifier: Apache-2.0
#include "camera/euroc_folder.hpp"

#include <algorithm>
#include <set>

#include "camera/text_lines.hpp"
#include "camera/timestamps.hpp"
#include "core/config.hpp"

namespace cairn::camera {
namespace {

namespace fs = std::filesystem;

struct MatrixSection {
  int cols = 0;
  int rows = 0;
  std::vector<double> data;

  void visit(ConfigVisitor& v) {
    v.integer("cols", cols, 4, 4, "", "columns");
    v.integer("rows", rows, 4, 4, "", "rows");
    v.numbers("data", data, 16, 16, {}, "", "4 x 4, row by row");
  }
};

struct SensorFile {
  std::string sensor_type = "camera";
  std::string comment;
  MatrixSection T_BS;
  double rate_hz = 0;
  std::vector<double> resolution;
  std::string camera_model = "pinhole";
  std::vector<double> intrinsics;
  std::string distortion_model;
  std::vector<double> distortion_coefficients;

  void visit(ConfigVisitor& v) {
    v.choice("sensor_type", sensor_type, {"camera"}, "what it is");
    v.text("comment", comment, "in words");
    v.group("T_BS", T_BS, "maps the sensor into the body");
    v.number("rate_hz", rate_hz, {0.001, 1000}, "Hz", "nominal rate");
    v.numbers("resolution", resolution, 2, 2, {1, 32768}, "px", "width, height");
    v.choice("camera_model", camera_model, {"pinhole"}, "how it projects");
    v.numbers("intrinsics", intrinsics, 4, 4, {-1e6, 1e6}, "px", "fu, fv, cu, cv");
    v.choice("distortion_model", distortion_model,
             {"none", "radial-tangential", "radtan", "equidistant"}, "how the lens bends");
    v.numbers("distortion_coefficients", distortion_coefficients, 0, 8, {}, "",
              "in the model's order");
  }
};

struct Sensor {
  cv::Size size;
  CameraModel camera;
  Isometry T_body_sensor;
};

Result<Isometry> body_from_sensor(const std::vector<double>& data) {
  const Eigen::Matrix4d M =
      Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(data.data());
  constexpr double kPrintedTolerance = 1e-3;
  Isometry T = Isometry::Identity();
  T.linear() = nearest_rotation(M.topLeftCorner<3, 3>());
  T.translation() = M.topRightCorner<3, 1>();
  if ((T.matrix() - M).cwiseAbs().maxCoeff() > kPrintedTolerance) {
    return fail("T_BS.data: is not a rotation and a translation");
  }
  return T;
}

Result<Sensor> load_sensor(const fs::path& file) {
  const auto sensor = load_yaml<SensorFile>(file);
  if (!sensor) return tl::make_unexpected(sensor.error());
  const std::string place = file.string() + ": ";
  if (sensor->T_BS.data.empty()) return fail(place + "T_BS.data: is missing");
  if (sensor->resolution.empty()) return fail(place + "resolution: is missing");
  if (sensor->intrinsics.empty()) return fail(place + "intrinsics: is missing");
  if (sensor->distortion_model.empty()) return fail(place + "distortion_model: is missing");
  const auto T_body_sensor = body_from_sensor(sensor->T_BS.data);
  if (!T_body_sensor) return fail(place + T_body_sensor.error().message);

  Distortion distortion = Distortion::kRadialTangential;
  if (sensor->distortion_model == "none") distortion = Distortion::kNone;
  if (sensor->distortion_model == "equidistant") distortion = Distortion::kEquidistant;
  const auto& f = sensor->intrinsics;
  return Sensor{{static_cast<int>(sensor->resolution[0]), static_cast<int>(sensor->resolution[1])},
                {f[0], f[1], f[2], f[3], distortion, sensor->distortion_coefficients},
                *T_body_sensor};
}

struct CameraFiles {
  FileList files;
  std::vector<Utime> utimes;
};

/// One row of data.csv: the time in ns and the file's name.
Result<std::pair<Utime, std::string>> parse_row(const std::string& row) {
  const std::size_t comma = row.find(',');
  if (comma == std::string::npos) return fail("is not of the form time,name");
  const auto utime = parse_ns(row.substr(0, comma));
  if (!utime) return tl::make_unexpected(utime.error());
  const std::string name = row.substr(comma + 1);
  if (name.empty() || name.find('/') != std::string::npos) {
    return fail("'" + name + "' is not the name of a file");
  }
  return std::pair{*utime, name};
}

Result<CameraFiles> listed_files(const fs::path& folder, const fs::path& csv) {
  const auto there = list_files(folder, "*.png");
  if (!there) return tl::make_unexpected(there.error());
  std::set<fs::path> unlisted(there->begin(), there->end());
  const auto lines = read_lines(csv);
  if (!lines) return tl::make_unexpected(lines.error());
  CameraFiles camera;
  for (const TextLine& line : *lines) {
    const auto row = parse_row(line.text);
    if (!row) return fail(place(csv, line) + row.error().message);
    const auto& [utime, name] = *row;
    if (!camera.utimes.empty() && utime <= camera.utimes.back()) {
      return fail(place(csv, line) + "this time does not come after the one before");
    }
    if (unlisted.erase(folder / name) == 0) {
      return fail(place(csv, line) + (folder / name).string() + " is missing");
    }
    camera.files.push_back(folder / name);
    camera.utimes.push_back(utime);
  }
  if (!unlisted.empty()) return fail(unlisted.begin()->string() + ": is not in " + csv.string());
  return camera;
}

Result<CameraFiles> files_of(const fs::path& camera_folder) {
  const fs::path csv = camera_folder / "data.csv";
  std::error_code error;
  if (fs::exists(csv, error)) return listed_files(camera_folder / "data", csv);
  auto files = list_files(camera_folder / "data", "*.png");
  if (!files) return tl::make_unexpected(files.error());
  auto utimes = times_of_names_ns(*files);
  if (!utimes) return tl::make_unexpected(utimes.error());
  return CameraFiles{std::move(*files), std::move(*utimes)};
}

}  // namespace

Result<RigCalibration> load_euroc_rig(const fs::path& left_sensor, const fs::path& right_sensor) {
  const auto left = load_sensor(left_sensor);
  if (!left) return tl::make_unexpected(left.error());
  const auto right = load_sensor(right_sensor);
  if (!right) return tl::make_unexpected(right.error());
  if (left->size != right->size) {
    return fail(right_sensor.string() + ": resolution: is not that of " + left_sensor.string());
  }
  RigCalibration rig;
  rig.width_px = left->size.width;
  rig.height_px = left->size.height;
  rig.left = left->camera;
  rig.right = right->camera;
  rig.T_right_left = right->T_body_sensor.inverse() * left->T_body_sensor;
  rig.T_body_left = left->T_body_sensor;
  rig.id = calibration_id(rig);
  if (const auto checked = check(rig); !checked) {
    return fail(left_sensor.string() + ", " + right_sensor.string() + ": " +
                checked.error().message);
  }
  return rig;
}

Result<Recording> find_euroc_recording(const fs::path& mav0) {
  auto left = files_of(mav0 / "cam0");
  if (!left) return tl::make_unexpected(left.error());
  auto right = files_of(mav0 / "cam1");
  if (!right) return tl::make_unexpected(right.error());
  if (const auto paired = check_pairs(left->files, right->files, true); !paired) {
    return tl::make_unexpected(paired.error());
  }
  auto rig = load_euroc_rig(mav0 / "cam0" / "sensor.yaml", mav0 / "cam1" / "sensor.yaml");
  if (!rig) return tl::make_unexpected(rig.error());

  Recording recording;
  recording.left = std::move(left->files);
  recording.right = std::move(right->files);
  recording.utimes = std::move(left->utimes);
  recording.rate_hz = nominal_rate_hz(recording.utimes);
  recording.rig = std::move(*rig);
  const fs::path truth = mav0 / "state_groundtruth_estimate0" / "data.csv";
  std::error_code error;
  if (fs::exists(truth, error)) {
    recording.info.truth_file = truth.string();
    recording.info.truth_format = "euroc";
    recording.info.truth_frame = "body";
  }
  return recording;
}

}  // namespace cairn::camera
