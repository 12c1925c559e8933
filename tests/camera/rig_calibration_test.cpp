// SPDX-License-Identifier: Apache-2.0
#include "camera/rig_calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <set>

#include "camera/scratch.hpp"

namespace cairn::camera {
namespace {

class RigFile : public testing::ScratchTest {
 protected:
  [[nodiscard]] std::string error_of(const std::string& text) const {
    write("rig.yaml", text);
    const auto rig = load_rig(path("rig.yaml"));
    return rig ? "" : rig.error().message;
  }
};
class Rig : public testing::ScratchTest {};

/// Numbers with all their bits in use.
RigCalibration random_rig(std::uint32_t seed) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto camera = [&] {
    CameraModel model{500 + 100 * unit(rng), 500 + 100 * unit(rng), 320 + 30 * unit(rng),
                      240 + 30 * unit(rng),  Distortion::kNone,     {}};
    const std::size_t counts[] = {0, 4, 5, 8, 4};
    const std::size_t kind = rng() % 5;
    model.distortion = kind == 0   ? Distortion::kNone
                       : kind == 4 ? Distortion::kEquidistant
                                   : Distortion::kRadialTangential;
    for (std::size_t i = 0; i < counts[kind]; ++i) model.coefficients.push_back(unit(rng) / 3);
    return model;
  };
  RigCalibration rig;
  rig.width_px = 640;
  rig.height_px = 480;
  rig.left = camera();
  rig.right = camera();
  rig.T_right_left.linear() = exp_so3(0.05 * Eigen::Vector3d(unit(rng), unit(rng), unit(rng)));
  rig.T_right_left.translation() = Eigen::Vector3d(-0.254, 0.01 * unit(rng), 0.01 * unit(rng));
  rig.T_body_left.linear() = exp_so3(Eigen::Vector3d(unit(rng), unit(rng), unit(rng)));
  rig.T_body_left.translation() = Eigen::Vector3d(unit(rng), unit(rng), unit(rng));
  rig.id = calibration_id(rig);
  return rig;
}

TEST_F(Rig, SavedAndLoadedHasTheIdenticalId) {
  for (std::uint32_t seed = 0; seed < 100; ++seed) {
    const RigCalibration rig = random_rig(seed);
    const auto saved = save_rig(path("rig.yaml"), rig);
    ASSERT_TRUE(saved) << saved.error().message;
    const auto loaded = load_rig(path("rig.yaml"));
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ(loaded->id, rig.id) << "seed " << seed;
    EXPECT_EQ(loaded->T_right_left.matrix(), rig.T_right_left.matrix());
    EXPECT_EQ(loaded->T_body_left.matrix(), rig.T_body_left.matrix());
    EXPECT_EQ(loaded->left.coefficients, rig.left.coefficients);
    EXPECT_EQ(loaded->right.distortion, rig.right.distortion);
  }
}

TEST_F(Rig, TheIdChangesWithEveryNumberAndOnlyWithThem) {
  const RigCalibration rig = random_rig(3);
  const std::vector<std::function<void(RigCalibration&)>> changes{
      [](RigCalibration& r) { r.width_px += 1; },
      [](RigCalibration& r) { r.height_px += 1; },
      [](RigCalibration& r) { r.left.fx_px = std::nextafter(r.left.fx_px, 1e9); },
      [](RigCalibration& r) { r.left.cy_px = std::nextafter(r.left.cy_px, 1e9); },
      [](RigCalibration& r) { r.right.fy_px = std::nextafter(r.right.fy_px, 1e9); },
      [](RigCalibration& r) { r.right.coefficients.push_back(0); },
      [](RigCalibration& r) { r.left.distortion = Distortion::kEquidistant; },
      [](RigCalibration& r) { std::swap(r.left, r.right); },
      [](RigCalibration& r) { r.T_right_left.translation().x() += 1e-12; },
      [](RigCalibration& r) { r.T_body_left.linear()(2, 1) += 1e-12; },
      [](RigCalibration& r) { r.rectified = !r.rectified; }};
  std::set<std::uint64_t> ids{rig.id};
  for (const auto& change : changes) {
    RigCalibration changed = rig;
    change(changed);
    ids.insert(calibration_id(changed));
  }
  EXPECT_EQ(ids.size(), changes.size() + 1);
  EXPECT_FALSE(ids.contains(0));

  RigCalibration renamed = rig;
  renamed.id = 42;
  EXPECT_EQ(calibration_id(renamed), rig.id);
  RigCalibration zero = rig;
  RigCalibration negative_zero = rig;
  zero.T_body_left.translation().x() = 0.0;
  negative_zero.T_body_left.translation().x() = -0.0;
  EXPECT_EQ(calibration_id(zero), calibration_id(negative_zero));
}

TEST_F(Rig, NumbersThatBelongToNoRigAreRefusedByName) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<std::string, std::function<void(RigCalibration&)>>> cases{
      {"width_px", [](RigCalibration& r) { r.width_px = 0; }},
      {"left.fx_px", [](RigCalibration& r) { r.left.fx_px = -1; }},
      {"right.fy_px", [nan](RigCalibration& r) { r.right.fy_px = nan; }},
      {"right.cx_px", [nan](RigCalibration& r) { r.right.cx_px = nan; }},
      {"left.coefficients",
       [](RigCalibration& r) {
         r.left.distortion = Distortion::kEquidistant;
         r.left.coefficients = {0, 0, 0};
       }},
      {"right.coefficients",
       [nan](RigCalibration& r) {
         r.right.distortion = Distortion::kEquidistant;
         r.right.coefficients = {0, 0, nan, 0};
       }},
      {"baseline", [](RigCalibration& r) { r.T_right_left.translation() *= 0.001; }},
      {"swapped", [](RigCalibration& r) { r.T_right_left.translation() *= -1; }},
      {"behind",
       [](RigCalibration& r) { r.T_right_left.translation() = Eigen::Vector3d(0, 0, -0.2); }},
      {"orthonormal", [](RigCalibration& r) { r.T_right_left.linear()(0, 0) += 1e-4; }},
      {"mirrors", [](RigCalibration& r) { r.T_body_left.linear().col(0) *= -1; }},
      {"T_body_left", [nan](RigCalibration& r) { r.T_body_left.translation().x() = nan; }},
      {"rectified", [](RigCalibration& r) { r.rectified = true; }}};
  for (const auto& [word, spoil] : cases) {
    RigCalibration rig = random_rig(2);
    spoil(rig);
    const auto checked = check(rig);
    ASSERT_FALSE(checked) << word;
    EXPECT_NE(checked.error().message.find(word), std::string::npos) << checked.error().message;
    EXPECT_FALSE(save_rig(path("bad.yaml"), rig));
    EXPECT_FALSE(testing::fs::exists(path("bad.yaml")));
  }
}

TEST_F(Rig, RectifiedRigPutsAPointAtTheDisparityOfItsDepth) {
  const RigCalibration rig =
      rectified_rig(600, 600, 320, 240, 0.254, 640, 480, Isometry::Identity());
  ASSERT_TRUE(check(rig));
  EXPECT_DOUBLE_EQ(rig.baseline_m(), 0.254);
  EXPECT_EQ(rig.id, calibration_id(rig));
  const Eigen::Vector3d p_left(0.3, -0.2, 2.0);
  const Eigen::Vector3d p_right = rig.T_right_left * p_left;
  const double x_left_px = rig.left.fx_px * p_left.x() / p_left.z() + rig.left.cx_px;
  const double x_right_px = rig.right.fx_px * p_right.x() / p_right.z() + rig.right.cx_px;
  EXPECT_NEAR(x_left_px - x_right_px, 600 * 0.254 / 2.0, 1e-9);
}

TEST_F(RigFile, TheShippedExampleLoadsAndIsWhatItSays) {
  const auto rig =
      load_rig(std::string(CAIRN_SOURCE_DIR) + "/config/calibration/webcams-25cm.yaml");
  ASSERT_TRUE(rig) << rig.error().message;
  EXPECT_DOUBLE_EQ(rig->baseline_m(), 0.254);
  const double hfov_deg = 2 * std::atan(320 / rig->left.fx_px) * 180 / M_PI;
  EXPECT_NEAR(hfov_deg, 60, 1e-5);
  // Straight ahead for the camera is straight ahead for the body; down for it is down.
  EXPECT_NEAR(
      (rig->T_body_left.linear() * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(1, 0, 0)).norm(), 0,
      1e-12);
  EXPECT_NEAR(
      (rig->T_body_left.linear() * Eigen::Vector3d(0, 1, 0) - Eigen::Vector3d(0, 0, -1)).norm(), 0,
      1e-12);
  EXPECT_DOUBLE_EQ(rig->T_body_left.translation().z(), 0.30);
}

TEST_F(RigFile, AMountPitchedDownLooksDown) {
  ASSERT_EQ(error_of("width_px: 640\nheight_px: 480\n"
                     "left: {fx_px: 500, fy_px: 500, cx_px: 320, cy_px: 240}\n"
                     "right: {fx_px: 500, fy_px: 500, cx_px: 320, cy_px: 240}\n"
                     "T_right_left: {xyz_m: [-0.2, 0, 0]}\n"
                     "mount: {xyz_m: [0.1, 0.05, 0.3], rpy_deg: [0, 30, 0]}\n"),
            "");
  const auto rig = load_rig(path("rig.yaml"));
  const Eigen::Vector3d ahead = rig->T_body_left.linear() * Eigen::Vector3d::UnitZ();
  EXPECT_NEAR((ahead - Eigen::Vector3d(std::sqrt(0.75), 0, -0.5)).norm(), 0, 1e-12);
  EXPECT_NEAR((rig->T_body_left.translation() - Eigen::Vector3d(0.1, 0.05, 0.3)).norm(), 0, 0);
}

TEST_F(RigFile, AWrongFileIsRefusedWithFileAndLine) {
  const std::string head = "width_px: 640\nheight_px: 480\n";
  const std::string cameras =
      "left: {fx_px: 500, fy_px: 500, cx_px: 320, cy_px: 240}\n"
      "right: {fx_px: 500, fy_px: 500, cx_px: 320, cy_px: 240}\n";
  const std::string pose = "T_right_left: {xyz_m: [-0.2, 0, 0]}\n";
  const std::string mount = "mount: {xyz_m: [0, 0, 0.3]}\n";
  EXPECT_EQ(error_of(head + cameras + pose + mount), "");
  EXPECT_NE(error_of(head + "focal: 3\n" + cameras + pose + mount).find("rig.yaml:3: focal"),
            std::string::npos);
  EXPECT_NE(
      error_of(head + cameras + "T_right_left: {xyz_m: [-0.2, 0]}\n" + mount).find("rig.yaml:5:"),
      std::string::npos);
  EXPECT_NE(error_of(head + cameras + mount).find("T_right_left.xyz_m: is missing"),
            std::string::npos);
  EXPECT_NE(error_of(head + cameras + pose).find("T_body_left and mount"), std::string::npos);
  EXPECT_NE(error_of(head + pose + mount).find("left.fx_px"), std::string::npos);
  EXPECT_NE(load_rig(path("none.yaml")).error().message.find("none.yaml"), std::string::npos);
}

}  // namespace
}  // namespace cairn::camera
