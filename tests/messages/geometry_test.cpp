// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "messages/calibration_messages.hpp"
#include "messages/geometry_messages.hpp"

namespace cairn::messages {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool same_bits(const isometry_t& a, const isometry_t& b) {
  std::array<std::uint8_t, 7 * sizeof(double) + 8> bytes_a{};
  std::array<std::uint8_t, 7 * sizeof(double) + 8> bytes_b{};
  const int size = a.getEncodedSize();
  a.encode(bytes_a.data(), 0, size);
  b.encode(bytes_b.data(), 0, size);
  return bytes_a == bytes_b;
}

Isometry pose(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  Isometry T = Isometry::Identity();
  T.linear() = R;
  T.translation() = t;
  return T;
}

/// Rotations of all kinds: any, near the identity, near half turns, and with components that tie.
std::vector<Eigen::Matrix3d> rotations() {
  std::mt19937_64 rng(1);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Matrix3d> all;
  for (int i = 0; i < 20'000; ++i) {
    const Eigen::Vector3d axis =
        Eigen::Vector3d(normal(rng), normal(rng), normal(rng)).normalized();
    for (const double angle : {normal(rng), 1e-9 * normal(rng), M_PI + 1e-9 * normal(rng), M_PI}) {
      all.push_back(exp_so3(axis * angle));
    }
  }
  for (int roll = 0; roll < 8; ++roll) {
    for (int pitch = 0; pitch < 8; ++pitch) {
      for (int yaw = 0; yaw < 8; ++yaw) {
        all.push_back(rotation_from_rpy(roll * M_PI_4, pitch * M_PI_4, yaw * M_PI_4));
      }
    }
  }
  return all;
}

TEST(GeometryMessages, APoseThatWentThroughAMessageDoesSoAgainBitForBit) {
  for (const Eigen::Matrix3d& R : rotations()) {
    const isometry_t message = to_message(pose(R, {0.1, -7e5, 1e-300}));
    const auto T = to_isometry(message, "T");
    ASSERT_TRUE(T);
    ASSERT_TRUE(same_bits(to_message(*T), message)) << R;
    ASSERT_EQ(as_sent(*T).matrix(), T->matrix());
  }
}

TEST(GeometryMessages, PositionsAreExactAndRotationsGoodToTwelveDigits) {
  for (const Eigen::Matrix3d& R : rotations()) {
    const auto T = to_isometry(to_message(pose(R, {0.1, -7e5, 1e-300})), "T");
    ASSERT_EQ(T->translation(), Eigen::Vector3d(0.1, -7e5, 1e-300));
    ASSERT_LT(rotation_angle_rad(R.transpose() * T->linear()), 1e-12);
    ASSERT_LT((T->linear().transpose() * T->linear() - Eigen::Matrix3d::Identity()).norm(), 1e-14);
  }
}

TEST(GeometryMessages, TheQuaternionHasOneSign) {
  for (const Eigen::Matrix3d& R : rotations()) {
    const isometry_t message = to_message(pose(R, Eigen::Vector3d::Zero()));
    const double* q = message.orientation_xyzw;
    ASSERT_GE(q[3], 0);
    if (q[3] == 0) {
      ASSERT_GT(q[0] != 0 ? q[0] : q[1] != 0 ? q[1] : q[2], 0);
    }
    for (int i = 0; i < 4; ++i) ASSERT_FALSE(q[i] == 0 && std::signbit(q[i]));
  }
}

TEST(GeometryMessages, CameraAxesAreExact) {
  const Eigen::Matrix3d R = R_body_camera_forward();
  EXPECT_EQ(as_sent(pose(R, Eigen::Vector3d::Zero())).linear(), R);
  EXPECT_EQ(as_sent(Isometry::Identity()).matrix(), Isometry::Identity().matrix());
}

TEST(GeometryMessages, PosesThatCannotBeAreRefusedByName) {
  const isometry_t good = to_message(Isometry::Identity());
  const auto error = [](const isometry_t& message) {
    return to_isometry(message, "T_map_body").error().message;
  };
  isometry_t bad = good;
  bad.position_m[1] = kNan;
  EXPECT_EQ(error(bad), "T_map_body.position_m: not finite");
  bad.position_m[1] = -1.1e6;
  EXPECT_EQ(error(bad), "T_map_body.position_m: farther than 1e6 m");
  bad = good;
  bad.orientation_xyzw[0] = kInfinity;
  EXPECT_EQ(error(bad), "T_map_body.orientation_xyzw: not finite");
  bad.orientation_xyzw[0] = 0.1;
  EXPECT_EQ(error(bad), "T_map_body.orientation_xyzw: norm 1.004988, not a rotation");
  EXPECT_FALSE(to_isometry(isometry_t{}, "T"));
}

TEST(GeometryMessages, TwistsComeBackExactlyOrAreRefused) {
  const Twist twist{{0.1, -0.2, 1e-9}, {3, 2, 1}};
  twist_t message = to_message(twist);
  EXPECT_EQ(to_twist(message, "twist")->linear_mps, twist.linear_mps);
  EXPECT_EQ(to_twist(message, "twist")->angular_radps, twist.angular_radps);
  message.angular_radps[2] = kNan;
  EXPECT_EQ(to_twist(message, "twist").error().message, "twist: not finite");
}

TEST(GeometryMessages, CovariancesComeBackExactlyOrAreRefused) {
  const Covariance6 A = Covariance6::Random();
  const Covariance6 covariance = A * A.transpose();
  double row_by_row[36];
  set_covariance(row_by_row, covariance);
  EXPECT_EQ(row_by_row[6], covariance(1, 0));
  EXPECT_EQ(to_covariance(row_by_row, "c").value(), covariance);

  const auto error_with = [&](int index, double value) {
    double changed[36];
    std::copy(row_by_row, row_by_row + 36, changed);
    changed[index] = value;
    const auto result = to_covariance(changed, "c");
    return result ? std::string("none") : result.error().message;
  };
  EXPECT_EQ(error_with(3, kNan), "c: not finite");
  EXPECT_EQ(error_with(7, -1e-9), "c: negative variance in row 1");
  EXPECT_EQ(error_with(6, covariance(1, 0) + 0.1), "c: not symmetric in row 1, column 0");
  EXPECT_EQ(error_with(0, 1e-9), "c: correlation beyond 1 in row 1, column 0");
}

camera::RigCalibration rig() {
  camera::RigCalibration rig;
  rig.width_px = 640;
  rig.height_px = 480;
  rig.left = {501.2,
              500.9,
              319.7,
              240.3,
              camera::Distortion::kRadialTangential,
              {-0.3, 0.1, 1e-4, -2e-4, 0.02}};
  rig.right = {502.2, 501.9, 318.7, 241.3, camera::Distortion::kEquidistant, {0.1, 0.2, 0.3, 0.4}};
  rig.T_right_left = pose(exp_so3({0.01, -0.02, 0.005}), {-0.2541, 0.001, -0.0005});
  rig.T_body_left =
      pose(rotation_from_rpy(0.01, 0.2, -0.03) * R_body_camera_forward(), {0.1, 0.127, 0.3});
  rig.id = camera::calibration_id(rig);
  return rig;
}

TEST(CalibrationMessages, ReceiversHaveWhatTheSenderComputesWith) {
  const camera::RigCalibration sent = as_sent(rig());
  const auto received = to_rig(to_message(rig(), 77));
  ASSERT_TRUE(received) << received.error().message;
  EXPECT_EQ(received->id, sent.id);
  EXPECT_EQ(received->id, camera::calibration_id(*received));
  EXPECT_EQ(received->T_right_left.matrix(), sent.T_right_left.matrix());
  EXPECT_EQ(received->T_body_left.matrix(), sent.T_body_left.matrix());
  EXPECT_EQ(received->left.coefficients, rig().left.coefficients);
  EXPECT_EQ(received->right.distortion, camera::Distortion::kEquidistant);
  EXPECT_EQ(received->right.K(), rig().right.K());
  EXPECT_EQ(as_sent(sent).id, sent.id);
  EXPECT_EQ(to_message(rig(), 77).header.utime, 77);
}

TEST(CalibrationMessages, ARectifiedRigKeepsItsId) {
  Isometry T_body_left = Isometry::Identity();
  T_body_left.linear() = R_body_camera_forward();
  const auto rectified =
      camera::rectified_rig(718.856, 718.856, 607.2, 185.2, 0.537, 1226, 370, T_body_left);
  EXPECT_EQ(as_sent(rectified).id, rectified.id);
}

TEST(CalibrationMessages, WhatDoesNotAddUpIsRefusedByName) {
  const rig_calibration_t good = to_message(rig(), 0);
  const auto error = [](const rig_calibration_t& message) {
    return to_rig(message).error().message;
  };
  rig_calibration_t bad = good;
  bad.calibration_id ^= 1;
  EXPECT_EQ(error(bad), "CALIBRATION calibration_id: is not the hash of the content");
  bad = good;
  bad.left.fx_px += 1e-9;
  EXPECT_EQ(error(bad), "CALIBRATION calibration_id: is not the hash of the content");
  bad = good;
  bad.left.distortion = 3;
  EXPECT_EQ(error(bad), "CALIBRATION left.distortion: 3 is no known model");
  bad = good;
  bad.right.coefficient_count = 5;
  EXPECT_EQ(error(bad), "CALIBRATION right.coefficient_count: 5 does not fit");
  bad = good;
  bad.T_body_left.orientation_xyzw[3] = 2;
  EXPECT_NE(error(bad).find("CALIBRATION T_body_left.orientation_xyzw"), std::string::npos);
  bad = good;
  bad.right.fy_px = kNan;
  EXPECT_EQ(error(bad), "CALIBRATION: right.fy_px: is not a positive number");
}

}  // namespace
}  // namespace cairn::messages
