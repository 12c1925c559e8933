// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "camera/dataset_yaml.hpp"
#include "camera/euroc_folder.hpp"
#include "camera/frame_source.hpp"
#include "camera/image_decoding.hpp"
#include "camera/scratch.hpp"
#include "camera/timestamps.hpp"

namespace cairn::camera {
namespace {

namespace fs = std::filesystem;

using testing::corrupted;
using testing::noise_image;

constexpr int kRounds = 2000;
constexpr std::uint32_t kSeed = 20240917;

class Corruption : public testing::ScratchTest {
 protected:
  void SetUp() override {
    ScratchTest::SetUp();
    RecordProperty("seed", static_cast<int>(kSeed));
    std::printf("seed %u\n", kSeed);
    for (int i = 0; i < 3; ++i) {
      const std::string name = std::to_string(1'000'000'000LL + 50'000'000LL * i) + ".png";
      write_image("mav0/cam0/data/" + name, noise_image(2 * i));
      write_image("mav0/cam1/data/" + name, noise_image(2 * i + 1));
      write_image("image_0/" + name, noise_image(2 * i));
      write_image("image_1/" + name, noise_image(2 * i + 1));
    }
  }

  /// Damages one file in kRounds ways; `open` must answer each with a sound value or a message that
  /// names a path.
  template <class Open>
  void survives(const std::string& name, const Open& open) {
    const std::string whole = read(name);
    ASSERT_TRUE(open()) << "undamaged: " << open().error().message;
    std::mt19937 rng(kSeed);
    int refused = 0;
    for (int round = 0; round < kRounds; ++round) {
      write(name, corrupted(whole, rng));
      const auto opened = open();
      if (opened) continue;
      ++refused;
      EXPECT_NE(opened.error().message.find(folder_.string()), std::string::npos)
          << "round " << round << ": " << opened.error().message;
    }
    EXPECT_GT(refused, kRounds / 10);
    write(name, whole);
  }

  [[nodiscard]] Result<Dataset> open_soundly(const std::string& folder) const {
    auto dataset = open_dataset(folder);
    if (!dataset) return dataset;
    EXPECT_TRUE(check(dataset->frames->rig()));
    EXPECT_GT(dataset->frames->rate_hz(), 0);
    Utime before = INT64_MIN;
    while (!dataset->frames->finished()) {
      const auto frame = dataset->frames->next();
      if (!frame) continue;
      EXPECT_GT(frame->utime, before);
      before = frame->utime;
    }
    return dataset;
  }
};

constexpr const char* kSensor =
    "%YAML:1.0\nsensor_type: camera\ncomment: made up\n"
    "T_BS:\n  cols: 4\n  rows: 4\n"
    "  data: [1, 0, 0, 0.0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n"
    "rate_hz: 20\nresolution: [32, 24]\ncamera_model: pinhole\nintrinsics: [30, 30, 16, 12]\n"
    "distortion_model: radial-tangential\ndistortion_coefficients: [-0.1, 0.01, 0, 0]\n";

std::string right_sensor() {
  std::string text = kSensor;
  return text.replace(text.find("0.0,"), 4, "0.1,");
}

TEST_F(Corruption, OfADatasetYaml) {
  write("dataset.yaml",
        "left: image_0/*.png          # sorted by name\nright: image_1/*.png\n"
        "timestamps: file_name_ns\nrectified: true\n"
        "camera: {fx_px: 30, fy_px: 30, cx_px: 16, cy_px: 12, baseline_m: 0.1}\n"
        "mount: {xyz_m: [0, 0, 1.65], rpy_deg: [0, 0, 0]}\n"
        "truth: {file: poses.txt, format: kitti, frame: left_camera}\n"
        "map: {resolution_m: 0.2, max_range_m: 30}\n");
  survives("dataset.yaml", [this] { return open_soundly(folder_.string()); });
}

TEST_F(Corruption, OfAnEurocSensorFile) {
  write("mav0/cam0/sensor.yaml", kSensor);
  write("mav0/cam1/sensor.yaml", right_sensor());
  survives("mav0/cam1/sensor.yaml", [this] { return open_soundly(path("mav0")); });
}

TEST_F(Corruption, OfAnEurocList) {
  write("mav0/cam0/sensor.yaml", kSensor);
  write("mav0/cam1/sensor.yaml", right_sensor());
  write("mav0/cam0/data.csv",
        "#timestamp [ns],filename\n1000000000,1000000000.png\n1050000000,1050000000.png\n"
        "1100000000,1100000000.png\n");
  survives("mav0/cam0/data.csv", [this] { return open_soundly(path("mav0")); });
}

TEST_F(Corruption, OfAKittiCalibrationAndTimes) {
  fs::remove_all(folder_ / "mav0");
  write("calib.txt", "P0: 30 0 16 0 0 30 12 0 0 0 1 0\nP1: 30 0 16 -3 0 30 12 0 0 0 1 0\n");
  write("times.txt", "0.000000e+00\n1.037359e-01\n2.074819e-01\n");
  survives("calib.txt", [this] { return open_soundly(folder_.string()); });
  survives("times.txt", [this] { return open_soundly(folder_.string()); });
}

TEST_F(Corruption, OfAListOfTimes) {
  write("times_us.txt", "1000\n2000\n3500\n9007199254740993\n");
  survives("times_us.txt", [this] { return read_times_us(path("times_us.txt")); });
}

TEST_F(Corruption, OfARigFile) {
  RigCalibration rig;
  rig.width_px = 640;
  rig.height_px = 480;
  rig.left = {
      500.5, 501.5, 320.25, 240.125, Distortion::kRadialTangential, {-0.1, 0.02, 0, 0, 0.001}};
  rig.right = {500.5, 501.5, 320.25, 240.125, Distortion::kEquidistant, {-0.1, 0.02, 0, 0}};
  rig.T_right_left.translation() = Eigen::Vector3d(-0.254, 0, 0);
  ASSERT_TRUE(save_rig(path("rig.yaml"), rig));
  survives("rig.yaml", [this] {
    auto loaded = load_rig(path("rig.yaml"));
    EXPECT_TRUE(!loaded || check(*loaded));
    return loaded;
  });
}

TEST_F(Corruption, OfImages) {
  for (const std::string name : {"image.png", "image.jpg"}) {
    write_image(name, noise_image(7));
    survives(name, [&] { return read_grey_image(path(name)); });
  }
  write_image("depth.png", noise_image(7, CV_16UC1));
  survives("depth.png", [this] { return read_depth_image(path("depth.png"), 0.001, {0}); });
}

}  // namespace
}  // namespace cairn::camera
