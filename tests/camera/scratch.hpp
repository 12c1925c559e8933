// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <random>
#include <string>

namespace cairn::camera::testing {

namespace fs = std::filesystem;

/// A test with a folder of its own, and the means to lay out small recordings in it.
class ScratchTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() /
              ("cairn-camera-" + std::to_string(::getpid()) + "-" +
               ::testing::UnitTest::GetInstance()->current_test_info()->test_suite_name() + "-" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// A new file each time: overwriting one makes some file systems wait for the disk.
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    fs::remove(folder_ / name);
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  [[nodiscard]] std::string read(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write_image(const std::string& name, const cv::Mat& image) const {
    fs::create_directories((folder_ / name).parent_path());
    ASSERT_TRUE(cv::imwrite((folder_ / name).string(), image));
  }
  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_ / name).string();
  }

  fs::path folder_;
};

inline std::string six_digits(int number) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%06d", number);
  return text.data();
}

/// Noise: no two frames are alike, and no codec finds it too easy.
inline cv::Mat noise_image(int seed, int type = CV_8UC1, cv::Size size = {32, 24}) {
  cv::Mat image(size, type);
  cv::RNG rng(static_cast<std::uint64_t>(seed) + 1);
  rng.fill(image, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 65536 : 256);
  return image;
}

inline bool same_bytes(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  return a.empty() || cv::norm(a, b, cv::NORM_INF) == 0;
}

/// One to six random damages: a byte changed, a span dropped, doubled or filled, the end cut off.
inline std::string corrupted(std::string bytes, std::mt19937& rng) {
  const auto below = [&rng](std::size_t limit) {
    return limit == 0 ? std::size_t{0} : std::size_t{rng()} % limit;
  };
  for (std::size_t damages = 1 + below(6); damages > 0 && !bytes.empty(); --damages) {
    const std::size_t at = below(bytes.size());
    const std::size_t length = 1 + below(std::min<std::size_t>(16, bytes.size() - at));
    switch (below(6)) {
      case 0:
        bytes[at] = static_cast<char>(below(256));
        break;
      case 1:
        bytes.erase(at, length);
        break;
      case 2:
        bytes.insert(at, bytes.substr(at, length));
        break;
      case 3:
        bytes.replace(at, length, std::string(length, static_cast<char>(below(256))));
        break;
      case 4:
        bytes[at] = "{}[]:,-&*#!|>'\"%@`?\n 09eE.+"[below(28)];
        break;
      default:
        if (below(4) == 0) bytes.resize(at);
    }
  }
  return bytes;
}

}  // namespace cairn::camera::testing
