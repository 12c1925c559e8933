// SPDX-License-Identifier: Apache-2.0
#include "evaluation/trajectory.hpp"

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>

#include "data_folder.hpp"
#include "evaluation/corruption.hpp"
#include "evaluation/temporary_files.hpp"

namespace cairn::evaluation {
namespace {

class TrajectoryFile : public TemporaryFiles {};

Isometry pose(double x_m, double y_m, double z_m, double roll, double pitch, double yaw) {
  Isometry T = Isometry::Identity();
  T.linear() = rotation_from_rpy(roll, pitch, yaw);
  T.translation() = Eigen::Vector3d(x_m, y_m, z_m);
  return T;
}

Trajectory random_trajectory(std::size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> metres(-50, 50);
  std::uniform_real_distribution<double> radians(-3, 3);
  Trajectory poses;
  for (std::size_t i = 0; i < count; ++i) {
    poses.push_back({1'403'715'275'212'143 + static_cast<Utime>(i) * 66'667,
                     pose(metres(random), metres(random), metres(random), radians(random),
                          radians(random), radians(random))});
  }
  return poses;
}

std::string error_of(const Result<Trajectory>& read) {
  return read ? "no error" : read.error().message;
}

TEST_F(TrajectoryFile, TumComesBackAsItWasWritten) {
  const Trajectory written = random_trajectory(200);
  ASSERT_TRUE(write_tum(folder_ / "a.tum", written));
  const auto read = read_tum(folder_ / "a.tum");
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) {
    EXPECT_EQ((*read)[i].utime, written[i].utime);
    EXPECT_LT(((*read)[i].T.translation() - written[i].T.translation()).norm(), 1e-9);
    EXPECT_LT(rotation_angle_rad((*read)[i].T.linear().transpose() * written[i].T.linear()), 1e-9);
  }
}

TEST_F(TrajectoryFile, TumTextIsFixed) {
  // Half a turn about z after a quarter about it: (0, 0, sin 45, cos 45); utime keeps its leading
  // zeros.
  const Trajectory poses{{0, Isometry::Identity()},
                         {1'000'050, pose(1, -2.5, 0, 0, 0, std::numbers::pi / 2)}};
  EXPECT_EQ(tum_text(poses),
            "0.000000 0.000000000 0.000000000 0.000000000 "
            "0.000000000000 0.000000000000 0.000000000000 1.000000000000\n"
            "1.000050 1.000000000 -2.500000000 0.000000000 "
            "0.000000000000 0.000000000000 0.707106781187 0.707106781187\n");
}

TEST_F(TrajectoryFile, TumSkipsCommentsAndBlankLines) {
  const auto read = read_tum(write("a", "# t x\n\n1.5 1 2 3 0 0 0 1\r\n  \n2.5\t4 5 6 0 0 0 -1"));
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[0].utime, 1'500'000);
  EXPECT_EQ((*read)[1].T.translation(), Eigen::Vector3d(4, 5, 6));
}

TEST_F(TrajectoryFile, BadLinesAreNamed) {
  const std::string good = "1 0 0 0 0 0 0 1\n";
  const auto error = [&](const std::string& text) { return error_of(read_tum(write("a", text))); };
  const std::string at_2 = (folder_ / "a").string() + ":2: ";
  EXPECT_EQ(error(good + "2 0 0 0 0 0 0"),
            at_2 + "7 fields where 't x y z qx qy qz qw' is expected");
  EXPECT_EQ(error(good + "2 0 0 zero 0 0 0 1"), at_2 + "field 4 'zero' is not a finite number");
  EXPECT_EQ(error(good + "2 0 0 nan 0 0 0 1"), at_2 + "field 4 'nan' is not a finite number");
  EXPECT_EQ(error(good + "2 0 0 1e999 0 0 0 1"), at_2 + "field 4 '1e999' is not a finite number");
  EXPECT_EQ(error(good + "2 0 0 1e10 0 0 0 1"), at_2 + "the position is over 1e9 m away");
  EXPECT_EQ(error(good + "2 0 0 0 0 0 0 0.9"), at_2 + "the quaternion's length is not 1");
  EXPECT_EQ(error(good + "1 0 0 0 0 0 0 1"), at_2 + "the time does not rise");
  EXPECT_EQ(error(good + "1403715275212143104 0 0 0 0 0 0 1"), at_2 + "the time is not in seconds");
  EXPECT_EQ(error("# nothing\n"), (folder_ / "a").string() + ": holds no pose");
  EXPECT_NE(error_of(read_tum(folder_ / "missing")).find("cannot open"), std::string::npos);
}

TEST_F(TrajectoryFile, KittiLinesGetTheFramesTimes) {
  // A quarter turn to the left about z, at (1, 2, 3).
  const auto file = write("a", "1 0 0 0 0 1 0 0 0 0 1 0\n0 -1 0 1 1 0 0 2 0 0 1 3\n");
  const std::vector<Utime> times{0, 100'000, 200'000};
  const auto read = read_kitti(file, times);
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->size(), 2U);
  EXPECT_EQ((*read)[1].utime, 100'000);
  EXPECT_LT(((*read)[1].T.matrix() - pose(1, 2, 3, 0, 0, std::numbers::pi / 2).matrix())
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
  EXPECT_EQ(error_of(read_kitti(file, std::span(times).first(1))),
            file.string() + ":2: pose 2, but there are only 1 frames");
  EXPECT_EQ(error_of(read_kitti(write("b", "1 0 0 0 0 1 0 0 0 0 -1 0\n"), times)),
            (folder_ / "b").string() + ":1: the left 3x3 is not a rotation");
}

TEST_F(TrajectoryFile, EurocPutsTheScalarFirst) {
  const auto read = read_euroc(write("a",
                                     "#timestamp [ns], p_x, p_y\n"
                                     "1403715275212143104,1,2,3,0,0,0,1,9,9,9\n"));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ((*read)[0].utime, 1'403'715'275'212'143);
  EXPECT_LT(((*read)[0].T.matrix() - pose(1, 2, 3, 0, 0, std::numbers::pi).matrix())
                .cwiseAbs()
                .maxCoeff(),
            1e-12);
  EXPECT_EQ(error_of(read_euroc(write("b", "1.5,1,2,3,1,0,0,0\n"))),
            (folder_ / "b").string() + ":1: field 1 '1.5' is not a whole number");
}

TEST_F(TrajectoryFile, UnknownFormatIsRefused) {
  EXPECT_EQ(error_of(read_trajectory("x.txt", "tun", {})),
            "x.txt: trajectory format 'tun' is not known (tum, kitti, euroc)");
}

TEST_F(TrajectoryFile, ReadersSurviveCorruption) {
  const std::string text = tum_text(random_trajectory(6));
  const std::string kitti = "1 0 0 0 0 1 0 0 0 0 1 0\n0 -1 0 1 1 0 0 2 0 0 1 3\n";
  const std::string euroc =
      "1403715275212143104,1,2,3,0,0,0,1\n1403715275212943104,1,2,3,0,0,0,1\n";
  const std::vector<Utime> times{0, 1, 2, 3};
  constexpr unsigned kSeed = 20240501;
  std::mt19937 random(kSeed);
  int accepted = 0;
  const auto check = [&](const Result<Trajectory>& read, int trial) {
    if (!read) {
      ASSERT_FALSE(read.error().message.empty()) << "seed " << kSeed << " trial " << trial;
      return;
    }
    ++accepted;
    for (const StampedPose& one : *read) {
      ASSERT_TRUE(one.T.matrix().allFinite()) << "seed " << kSeed << " trial " << trial;
      ASSERT_NEAR(one.T.linear().determinant(), 1, 1e-9) << "seed " << kSeed << " trial " << trial;
    }
  };
  for (int trial = 0; trial < 2000; ++trial) {
    check(read_tum(write("t", corrupted(text, random))), trial);
    check(read_kitti(write("k", corrupted(kitti, random)), times), trial);
    check(read_euroc(write("e", corrupted(euroc, random))), trial);
  }
  EXPECT_GT(accepted, 0);
}

TEST_F(TrajectoryFile, RealTruthFilesAreRead) {
  const auto data = testing::data_folder();
  if (!data) GTEST_SKIP() << "no data folder: set CAIRN_DATA";
  std::vector<Utime> times(1000);
  for (std::size_t i = 0; i < times.size(); ++i) times[i] = static_cast<Utime>(i) * 100'000;
  const auto kitti = read_kitti(*data / "sequence/kitti_1/poses.txt", times);
  ASSERT_TRUE(kitti) << kitti.error().message;
  EXPECT_EQ(kitti->size(), 51U);
  const auto kitchen = read_kitti(*data / "sequence/kitchen_depth/poses.txt", times);
  ASSERT_TRUE(kitchen) << kitchen.error().message;
  EXPECT_EQ(kitchen->size(), 250U);
  const auto euroc = read_tum(*data / "sequence/euroc_v101_static/groundtruth_tum.txt");
  ASSERT_TRUE(euroc) << euroc.error().message;
  EXPECT_EQ(euroc->front().utime, 1'403'715'274'302'140);
}

TEST(BodyFromLeftCamera, ForwardInTheCameraIsForwardInTheBody) {
  // The camera's world is arbitrary. The camera moves 2 m along its own z: the body moves 2 m along
  // its own x, wherever the camera sits on it.
  Isometry T_body_left = Isometry::Identity();
  T_body_left.linear() = R_body_camera_forward();
  T_body_left.translation() = Eigen::Vector3d(0.1, 0.127, 0.5);
  const Isometry T_world_c0 = pose(5, -3, 2, 0.3, -0.2, 1.1);
  Isometry ahead = Isometry::Identity();
  ahead.translation() = Eigen::Vector3d(0, 0, 2);
  const Trajectory body =
      body_from_left_camera(Trajectory{{0, T_world_c0}, {1, T_world_c0 * ahead}}, T_body_left);
  EXPECT_LT((body[0].T.matrix() - Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((body[1].T.matrix() - pose(2, 0, 0, 0, 0, 0).matrix()).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(BodyFromLeftCamera, ATurnOnTheSpotMovesTheCameraButNotTheBody) {
  Isometry T_body_left = Isometry::Identity();
  T_body_left.linear() = R_body_camera_forward();
  T_body_left.translation() = Eigen::Vector3d(0.2, 0.1, 0.4);
  const Isometry turned = pose(0, 0, 0, 0, 0, 0.8);
  const Trajectory camera{{0, T_body_left}, {1, turned * T_body_left}};
  EXPECT_GT(path_length_m(camera), 0.1);
  const Trajectory body = body_from_left_camera(camera, T_body_left);
  EXPECT_LT((body[1].T.matrix() - turned.matrix()).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace cairn::evaluation
