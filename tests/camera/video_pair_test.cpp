// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "camera/frame_source.hpp"
#include "camera/scratch.hpp"

namespace cairn::camera {
namespace {

const cv::Size kSize{64, 48};

class VideoPairs : public testing::ScratchTest {
 protected:
  /// Frame i is evenly grey at 20 + 8 i.
  void write_video(const std::string& name, int count, cv::Size size = kSize,
                   double rate_hz = 12) const {
    cv::VideoWriter writer(path(name), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate_hz, size);
    ASSERT_TRUE(writer.isOpened());
    for (int i = 0; i < count; ++i)
      writer.write(cv::Mat(size, CV_8UC3, cv::Scalar::all(20 + 8 * i)));
  }
  [[nodiscard]] auto open(const std::string& left, const std::string& right) const {
    return open_video_pair(
        path(left), path(right),
        rectified_rig(60, 60, 32, 24, 0.1, kSize.width, kSize.height, Isometry::Identity()));
  }
  [[nodiscard]] std::string error(const std::string& left, const std::string& right) const {
    const auto pair = open(left, right);
    return pair ? "" : pair.error().message;
  }
};

TEST_F(VideoPairs, FramesComeInOrderAndSeekIsExact) {
  write_video("l.avi", 14);
  write_video("r.avi", 14);
  const auto pair = open("l.avi", "r.avi");
  ASSERT_TRUE(pair) << pair.error().message;
  FrameSource& frames = **pair;
  EXPECT_EQ(frames.size(), 14);
  EXPECT_NEAR(frames.rate_hz(), 12, 1e-9);
  std::vector<Frame> through;
  while (!frames.finished()) through.push_back(frames.next().value());
  ASSERT_EQ(through.size(), 14U);
  for (std::size_t i = 0; i < through.size(); ++i) {
    EXPECT_EQ(through[i].utime, std::llround(static_cast<double>(i) * 1e6 / 12));
    ASSERT_EQ(through[i].left.type(), CV_8UC1);
    EXPECT_NEAR(cv::mean(through[i].left)[0], 20 + 8 * static_cast<double>(i), 2);
    EXPECT_NEAR(cv::mean(through[i].right)[0], 20 + 8 * static_cast<double>(i), 2);
  }
  for (const std::int64_t index : {9, 3, 13, 0, 1}) {
    frames.seek(index);
    const Frame frame = frames.next().value();
    EXPECT_EQ(frame.index, index);
    EXPECT_TRUE(testing::same_bytes(frame.left, through[static_cast<std::size_t>(index)].left));
    EXPECT_TRUE(testing::same_bytes(frame.right, through[static_cast<std::size_t>(index)].right));
  }
}

TEST_F(VideoPairs, WhatDoesNotPairOrOpenIsRefusedByName) {
  write_video("l.avi", 12);
  write_video("short.avi", 11);
  write_video("large.avi", 12, {80, 48});
  write_video("slow.avi", 12, kSize, 6);
  write("junk.avi", "no video at all");
  EXPECT_NE(error("l.avi", "short.avi").find("12 frames"), std::string::npos);
  EXPECT_NE(error("l.avi", "short.avi").find("short.avi has 11"), std::string::npos);
  EXPECT_NE(error("l.avi", "large.avi").find("large.avi: is 80 x 48"), std::string::npos);
  EXPECT_NE(error("l.avi", "slow.avi").find("slow.avi has 6"), std::string::npos);
  EXPECT_NE(error("l.avi", "junk.avi").find("junk.avi: is not a video"), std::string::npos);
  EXPECT_NE(error("l.avi", "none.avi").find("none.avi: no such file"), std::string::npos);
}

TEST_F(VideoPairs, AVideoCutOffAfterItsIndexWasWrittenGivesErrorsNotSilence) {
  write_video("l.avi", 12);
  write_video("r.avi", 12);
  const std::string whole = read("r.avi");
  write("r.avi", whole.substr(0, whole.size() / 2));
  const auto pair = open("l.avi", "r.avi");
  if (!pair) {
    EXPECT_NE(pair.error().message.find("r.avi"), std::string::npos);
    return;
  }
  int frames = 0;
  int errors = 0;
  while (!(*pair)->finished()) {
    const auto frame = (*pair)->next();
    ++(frame ? frames : errors);
    if (!frame) {
      EXPECT_NE(frame.error().message.find("r.avi"), std::string::npos);
    }
  }
  EXPECT_GT(errors, 0);
  EXPECT_EQ(frames + errors, 12);
}

}  // namespace
}  // namespace cairn::camera
