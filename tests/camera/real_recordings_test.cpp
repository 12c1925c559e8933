// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <opencv2/imgcodecs.hpp>

#include "camera/frame_source.hpp"
#include "camera/scratch.hpp"
#include "data_folder.hpp"

namespace cairn::camera {
namespace {

class RealRecordings : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto data = cairn::testing::data_folder();
    if (!data) GTEST_SKIP() << "no real recordings here: set CAIRN_DATA to their folder";
    sequences_ = *data / "sequence";
  }
  [[nodiscard]] Dataset open(const std::string& name) const {
    auto dataset = open_dataset((sequences_ / name).string());
    if (!dataset) throw std::runtime_error(dataset.error().message);
    return std::move(*dataset);
  }

  std::filesystem::path sequences_;
};

TEST_F(RealRecordings, Kitti) {
  const Dataset kitti = open("kitti_1");
  FrameSource& frames = *kitti.frames;
  EXPECT_EQ(frames.size(), 51);
  EXPECT_DOUBLE_EQ(frames.rate_hz(), 10);
  EXPECT_FALSE(frames.is_depth());
  EXPECT_TRUE(frames.rig().rectified);
  EXPECT_EQ(frames.rig().width_px, 1226);
  EXPECT_EQ(frames.rig().height_px, 370);
  // P1's fourth number is -fx * B.
  EXPECT_NEAR(frames.rig().baseline_m(), 379.8145 / 707.0912, 1e-6);
  EXPECT_DOUBLE_EQ(frames.rig().T_body_left.translation().z(), 1.65);
  EXPECT_EQ(kitti.info.truth_format, "kitti");
  EXPECT_EQ(kitti.info.truth_frame, "left_camera");
  EXPECT_TRUE(std::filesystem::exists(kitti.info.truth_file));
  EXPECT_DOUBLE_EQ(kitti.info.map_resolution_m, 0.2);
  EXPECT_DOUBLE_EQ(kitti.info.map_max_range_m, 30);
  for (int i = 0; i < 51; ++i) {
    ASSERT_FALSE(frames.finished());
    const auto frame = frames.next();
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->index, i);
    EXPECT_EQ(frame->utime, i * 100'000);
    const std::string name = testing::six_digits(i) + ".png";
    for (const auto& [image, folder] :
         {std::pair{frame->left, "image_l"}, {frame->right, "image_r"}}) {
      const auto file = sequences_ / "kitti_1" / folder / name;
      EXPECT_TRUE(testing::same_bytes(image, cv::imread(file.string(), cv::IMREAD_GRAYSCALE)));
    }
  }
  EXPECT_TRUE(frames.finished());
  EXPECT_FALSE(frames.next());
}

TEST_F(RealRecordings, EurocStandingStill) {
  const Dataset euroc = open("euroc_v101_static");
  FrameSource& frames = *euroc.frames;
  EXPECT_EQ(frames.size(), 12);
  EXPECT_NEAR(frames.rate_hz(), 20, 1e-3);
  EXPECT_FALSE(frames.rig().rectified);
  EXPECT_EQ(frames.rig().left.distortion, Distortion::kRadialTangential);
  EXPECT_EQ(frames.rig().right.coefficients,
            (std::vector<double>{-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05}));

  // The numbers of cam0.yaml and cam1.yaml, and a general matrix inverse.
  Eigen::Matrix4d T_BS0;
  Eigen::Matrix4d T_BS1;
  T_BS0 << 0.0148655429818, -0.999880929698, 0.00414029679422, -0.0216401454975,  //
      0.999557249008, 0.0149672133247, 0.025715529948, -0.064676986768,           //
      -0.0257744366974, 0.00375618835797, 0.999660727178, 0.00981073058949, 0, 0, 0, 1;
  T_BS1 << 0.0125552670891, -0.999755099723, 0.0182237714554, -0.0198435579556,  //
      0.999598781151, 0.0130119051815, 0.0251588363115, 0.0453689425024,         //
      -0.0253898008918, 0.0179005838253, 0.999517347078, 0.00786212447038, 0, 0, 0, 1;
  const Eigen::Matrix4d T_right_left = T_BS1.inverse() * T_BS0;
  EXPECT_LT((frames.rig().T_right_left.matrix() - T_right_left).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((frames.rig().T_body_left.matrix() - T_BS0).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NEAR(frames.rig().baseline_m(), 0.110, 0.0005);
  EXPECT_LT(frames.rig().T_right_left.translation().x(), -0.109);
  EXPECT_EQ(euroc.info.truth_format, "tum");
  EXPECT_EQ(euroc.info.truth_frame, "body");

  const std::vector<Utime> first_times{1403715275212143, 1403715275262143, 1403715275312143};
  for (int i = 0; i < 12; ++i) {
    const auto frame = frames.next();
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->left.size(), cv::Size(752, 480));
    if (i < 3) {
      EXPECT_EQ(frame->utime, first_times[static_cast<std::size_t>(i)]);
    }
  }
}

TEST_F(RealRecordings, KitchenDepth) {
  const Dataset kitchen = open("kitchen_depth");
  FrameSource& frames = *kitchen.frames;
  EXPECT_TRUE(frames.is_depth());
  EXPECT_EQ(frames.size(), 250);
  EXPECT_DOUBLE_EQ(frames.rig().left.fx_px, 585);
  EXPECT_DOUBLE_EQ(frames.rig().baseline_m(), 0.254);
  EXPECT_TRUE(frames.rig().rectified);
  frames.seek(3);
  const auto frame = frames.next();
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->utime, 400'000);  // 3 / 7.5 s
  EXPECT_TRUE(frame->left.empty());
  ASSERT_EQ(frame->depth_m.type(), CV_32FC1);
  const cv::Mat raw =
      cv::imread((sequences_ / "kitchen_depth/depth/000012.png").string(), cv::IMREAD_UNCHANGED);
  int answers = 0;
  for (int y = 0; y < raw.rows; ++y) {
    for (int x = 0; x < raw.cols; ++x) {
      const int value = raw.at<std::uint16_t>(y, x);
      const float depth_m = frame->depth_m.at<float>(y, x);
      if (value == 0 || value == 65535) {
        ASSERT_EQ(depth_m, 0.0F);
      } else {
        ASSERT_NEAR(depth_m, value / 1000.0, 1e-6 * value);
        ++answers;
      }
    }
  }
  EXPECT_GT(answers, raw.rows * raw.cols / 2);
}

TEST_F(RealRecordings, AFrameIsTheSameBytesHoweverItIsReached) {
  const Dataset through = open("kitti_1");
  const Dataset jumping = open("kitti_1");
  std::vector<Frame> frames;
  while (!through.frames->finished()) frames.push_back(through.frames->next().value());
  for (const std::int64_t index : {50, 7, 7, 0, 23}) {
    jumping.frames->seek(index);
    const Frame frame = jumping.frames->next().value();
    const Frame& expected = frames[static_cast<std::size_t>(index)];
    EXPECT_EQ(frame.index, index);
    EXPECT_EQ(frame.utime, expected.utime);
    EXPECT_TRUE(testing::same_bytes(frame.left, expected.left));
    EXPECT_TRUE(testing::same_bytes(frame.right, expected.right));
  }
  EXPECT_EQ(through.frames->rig().id, jumping.frames->rig().id);
}

}  // namespace
}  // namespace cairn::camera
