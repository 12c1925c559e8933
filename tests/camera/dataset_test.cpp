// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "camera/frame_source.hpp"
#include "camera/scratch.hpp"
#include "core/geometry.hpp"

namespace cairn::camera {
namespace {

namespace fs = std::filesystem;

using testing::noise_image;
using testing::six_digits;

constexpr const char* kRectified =
    "left: l/*.png\nright: r/*.png\nrate_hz: 15\nrectified: true\n"
    "camera: {fx_px: 30, fy_px: 30, cx_px: 16, cy_px: 12, baseline_m: 0.1}\n";

const std::string kSensor0 =
    "%YAML:1.0\n"
    "sensor_type: camera\ncomment: made up\n"
    "T_BS:\n  cols: 4\n  rows: 4\n"
    "  data: [1, 0, 0, 0,\n         0, 1, 0, 0,\n         0, 0, 1, 0,\n         0, 0, 0, 1]\n"
    "rate_hz: 20\nresolution: [32, 24]\ncamera_model: pinhole\n"
    "intrinsics: [30, 30, 16, 12] #fu, fv, cu, cv\n"
    "distortion_model: radial-tangential\ndistortion_coefficients: [-0.1, 0.01, 0, 0]\n";

std::string sensor1() {
  std::string text = kSensor0;
  return text.replace(text.find("1, 0, 0, 0,"), 11, "1, 0, 0, 0.1,");
}

class Datasets : public testing::ScratchTest {
 protected:
  [[nodiscard]] Result<Dataset> open() const { return open_dataset(folder_.string()); }
  [[nodiscard]] std::string error() const {
    const auto dataset = open();
    return dataset ? "" : dataset.error().message;
  }
  [[nodiscard]] static bool names(const std::string& message, const std::string& part) {
    return message.find(part) != std::string::npos;
  }
  void pairs(int count, const std::string& left = "l/", const std::string& right = "r/") const {
    for (int i = 0; i < count; ++i) {
      write_image(left + six_digits(i) + ".png", noise_image(2 * i));
      write_image(right + six_digits(i) + ".png", noise_image(2 * i + 1));
    }
  }
  void rectified(int count) const {
    pairs(count);
    write("dataset.yaml", kRectified);
  }
  /// Frames 50 ms apart.
  void euroc(int count, bool with_csv) const {
    std::string csv = "#timestamp [ns],filename\r\n";
    for (int i = 0; i < count; ++i) {
      const std::string stamp = std::to_string(1'400'000'000'000'000'600LL + i * 50'000'000LL);
      write_image("mav0/cam0/data/" + stamp + ".png", noise_image(2 * i));
      write_image("mav0/cam1/data/" + stamp + ".png", noise_image(2 * i + 1));
      csv += stamp + "," + stamp + ".png\r\n";
    }
    write("mav0/cam0/sensor.yaml", kSensor0);
    write("mav0/cam1/sensor.yaml", sensor1());
    if (!with_csv) return;
    write("mav0/cam0/data.csv", csv);
    write("mav0/cam1/data.csv", csv);
  }
  void kitti(int count) const {
    pairs(count, "image_0/", "image_1/");
    write("calib.txt",
          "P0: 30 0 16 0 0 30 12 0 0 0 1 0\nP1: 30 0 16 -3 0 30 12 0 0 0 1 0\n"
          "P2: 30 0 16 1 0 30 12 0 0 0 1 0\nTr: 1 0 0 0 0 1 0 0 0 0 1 0\n");
  }
};

TEST_F(Datasets, FramesComeInOrderWithTheirTimesAndPixels) {
  rectified(12);
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  FrameSource& frames = *dataset->frames;
  EXPECT_EQ(frames.size(), 12);
  EXPECT_EQ(frames.rig().width_px, 32);
  for (int i = 0; i < 12; ++i) {
    const auto frame = frames.next();
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->index, i);
    EXPECT_EQ(frame->utime, std::llround(i * 1e6 / 15));
    EXPECT_TRUE(testing::same_bytes(frame->left, noise_image(2 * i)));
    EXPECT_TRUE(testing::same_bytes(frame->right, noise_image(2 * i + 1)));
  }
  EXPECT_TRUE(frames.finished());
}

TEST_F(Datasets, SeekThenNextGivesWhatReadingThroughGives) {
  rectified(6);
  const auto dataset = open();
  for (const std::int64_t index : {4, 0, 5, 2, 2}) {
    dataset->frames->seek(index);
    const auto frame = dataset->frames->next();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->index, index);
    EXPECT_TRUE(testing::same_bytes(frame->left, noise_image(2 * static_cast<int>(index))));
  }
  dataset->frames->seek(99);
  EXPECT_TRUE(dataset->frames->finished());
  dataset->frames->seek(-1);
  EXPECT_EQ(dataset->frames->next()->index, 0);
}

TEST_F(Datasets, UnpaddedNumbersAreInTheOrderOfTheirValues) {
  for (int i = 8; i < 12; ++i) {
    write_image("l/left" + std::to_string(i) + ".png", noise_image(i));
    write_image("r/right" + std::to_string(i) + ".png", noise_image(100 + i));
  }
  write("dataset.yaml", kRectified);
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  for (int i = 8; i < 12; ++i) {
    EXPECT_TRUE(testing::same_bytes(dataset->frames->next()->left, noise_image(i)));
  }
}

TEST_F(Datasets, AMissingImageIsNamedAtOpening) {
  rectified(12);
  const auto missing = [this](const std::string& name) {
    const std::string image = read(name);
    fs::remove(path(name));
    const std::string message = error();
    write(name, image);
    return names(message, name) && names(message, "missing") ? "" : "'" + message + "'";
  };
  EXPECT_EQ(missing("r/000005.png"), "");
  EXPECT_EQ(missing("l/000005.png"), "");
  EXPECT_EQ(missing("r/000000.png"), "");
  EXPECT_EQ(missing("r/000011.png"), "");
  EXPECT_EQ(error(), "");

  fs::remove(path("l/000007.png"));
  fs::remove(path("r/000007.png"));
  EXPECT_TRUE(names(error(), "l/000007.png: is missing")) << error();
  write("dataset.yaml",
        std::string(kRectified)
            .replace(std::string(kRectified).find("rate_hz: 15"), 11, "timestamps_us: times.txt"));
  std::string times;
  for (int i = 0; i < 12; ++i) times += i == 7 ? "" : std::to_string(i * 70'000) + "\n";
  write("times.txt", times);
  EXPECT_EQ(error(), "") << "with times of its own, a recording may have gaps";
}

TEST_F(Datasets, AMissingImageAmongOtherNamesIsNamedToo) {
  for (int i = 0; i < 5; ++i) {
    write_image("l/left_" + six_digits(i) + ".png", noise_image(i));
    if (i != 2) write_image("r/right_" + six_digits(i) + ".png", noise_image(i));
  }
  write("dataset.yaml", kRectified);
  EXPECT_TRUE(names(error(), "r/right_000002.png: is missing")) << error();
}

TEST_F(Datasets, NamesThatTellNothingPairByPositionAndMustBeAsMany) {
  for (const char* name : {"a", "b", "c"}) {
    write_image(std::string("l/") + name + ".png", noise_image(1));
    write_image(std::string("r/x") + name + ".png", noise_image(2));
  }
  write("dataset.yaml", kRectified);
  EXPECT_EQ(error(), "");
  fs::remove(path("r/xc.png"));
  EXPECT_TRUE(names(error(), "l/c.png: has no partner: 3 left and 2 right images")) << error();
}

TEST_F(Datasets, ABadImageIsAnErrorThatNamesItAndTheNextFrameComes) {
  rectified(7);
  write_image("l/000001.png", noise_image(1, CV_8UC1, {40, 24}));
  const std::string whole = read("r/000002.png");
  write("r/000002.png", whole.substr(0, whole.size() / 2));
  write("l/000003.png", "no image at all");
  write_image("r/000004.png", noise_image(1, CV_16UC1));
  write("l/000005.png", "");
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  FrameSource& frames = *dataset->frames;
  EXPECT_TRUE(frames.next());
  for (const auto& [name, reason] :
       std::vector<std::pair<std::string, std::string>>{{"l/000001.png", "40 x 24"},
                                                        {"r/000002.png", "whole image"},
                                                        {"l/000003.png", "image"},
                                                        {"r/000004.png", "16 bits"},
                                                        {"l/000005.png", "empty"}}) {
    const auto frame = frames.next();
    ASSERT_FALSE(frame) << name;
    EXPECT_TRUE(names(frame.error().message, name)) << frame.error().message;
    EXPECT_TRUE(names(frame.error().message, reason)) << frame.error().message;
  }
  const auto last = frames.next();
  ASSERT_TRUE(last);
  EXPECT_EQ(last->index, 6);
  EXPECT_TRUE(frames.finished());
}

TEST_F(Datasets, AnImageThatVanishesAfterOpeningIsAnError) {
  rectified(2);
  const auto dataset = open();
  fs::remove(path("l/000000.png"));
  const auto frame = dataset->frames->next();
  ASSERT_FALSE(frame);
  EXPECT_TRUE(names(frame.error().message, "l/000000.png"));
  EXPECT_TRUE(dataset->frames->next());
}

TEST_F(Datasets, EveryCutOfAnImageIsRefusedPngAndJpeg) {
  write("dataset.yaml",
        "left: l/*\nright: r/*\nrate_hz: 15\nrectified: true\n"
        "camera: {fx_px: 30, fy_px: 30, cx_px: 16, cy_px: 12, baseline_m: 0.1}\n");
  for (const char* extension : {".png", ".jpg"}) {
    fs::remove_all(folder_ / "l");
    fs::remove_all(folder_ / "r");
    for (int i = 0; i < 2; ++i) {
      write_image("l/" + six_digits(i) + extension, noise_image(i));
      write_image("r/" + six_digits(i) + extension, noise_image(i));
    }
    const auto dataset = open();
    ASSERT_TRUE(dataset) << dataset.error().message;
    const std::string cut_file = "r/000001" + std::string(extension);
    const std::string whole = read(cut_file);
    const std::size_t end = extension == std::string(".png") ? whole.size() - 12 : whole.size() - 1;
    for (std::size_t length = 0; length <= end; ++length) {
      write(cut_file, whole.substr(0, length));
      dataset->frames->seek(1);
      const auto frame = dataset->frames->next();
      // A PNG without its closing chunk of 12 bytes has all its pixels: then the frame must be
      // right.
      if (frame) {
        ASSERT_TRUE(length == end && extension == std::string(".png")) << length;
        EXPECT_TRUE(testing::same_bytes(frame->right, noise_image(1)));
      } else {
        ASSERT_TRUE(names(frame.error().message, cut_file)) << frame.error().message;
      }
    }
  }
}

TEST_F(Datasets, ColourBecomesGreyByBt601) {
  rectified(1);
  const cv::Mat colour = noise_image(9, CV_8UC3);
  write_image("l/000000.png", colour);
  write_image("r/000000.png", noise_image(9, CV_8UC4));
  const auto dataset = open();
  const auto frame = dataset->frames->next();
  ASSERT_TRUE(frame) << frame.error().message;
  ASSERT_EQ(frame->left.type(), CV_8UC1);
  ASSERT_EQ(frame->right.type(), CV_8UC1);
  for (int y = 0; y < colour.rows; ++y) {
    for (int x = 0; x < colour.cols; ++x) {
      const auto bgr = colour.at<cv::Vec3b>(y, x);
      ASSERT_NEAR(frame->left.at<std::uint8_t>(y, x),
                  0.114 * bgr[0] + 0.587 * bgr[1] + 0.299 * bgr[2], 0.51);
    }
  }
}

TEST_F(Datasets, AMountTurnsAndMovesTheCamera) {
  pairs(1);
  write("dataset.yaml",
        std::string(kRectified) + "mount: {xyz_m: [0.1, 0.2, 0.3], rpy_deg: [0, 90, 0]}\n");
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  const Isometry& T_body_left = dataset->frames->rig().T_body_left;
  EXPECT_NEAR((T_body_left * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(0.1, 0.2, -0.7)).norm(), 0,
              1e-12);
  write("dataset.yaml", kRectified);
  EXPECT_EQ(open()->frames->rig().T_body_left.linear(), R_body_camera_forward());
}

TEST_F(Datasets, DepthIsMetresWithInvalidValuesZero) {
  cv::Mat depth(24, 32, CV_16UC1, cv::Scalar(1500));
  depth.at<std::uint16_t>(3, 4) = 65535;
  depth.at<std::uint16_t>(5, 6) = 0;
  write_image("d/1.png", depth);
  write_image("d/2.png", noise_image(1));
  write("dataset.yaml",
        "depth: d/*.png\nscale_m: 0.002\ninvalid: [0, 65535]\nrate_hz: 3\n"
        "camera: {fx_px: 30, fy_px: 30, cx_px: 16, cy_px: 12, baseline_m: 0.1}\n");
  const auto dataset = open();
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_TRUE(dataset->frames->is_depth());
  const auto frame = dataset->frames->next();
  ASSERT_TRUE(frame);
  EXPECT_FLOAT_EQ(frame->depth_m.at<float>(0, 0), 3.0F);
  EXPECT_EQ(frame->depth_m.at<float>(3, 4), 0);
  EXPECT_EQ(frame->depth_m.at<float>(5, 6), 0);
  const auto eight_bits = dataset->frames->next();
  ASSERT_FALSE(eight_bits);
  EXPECT_TRUE(names(eight_bits.error().message, "d/2.png"));
}

TEST_F(Datasets, KeysThatDoNotFitTogetherAreRefused) {
  pairs(2);
  write_image("d/1.png", noise_image(1, CV_16UC1));
  write("cam0.yaml", kSensor0);
  write("cam1.yaml", sensor1());
  const std::string images = "left: l/*.png\nright: r/*.png\n";
  const std::string camera =
      "camera: {fx_px: 30, fy_px: 30, cx_px: 16, cy_px: 12, baseline_m: 0.1}\n";
  const std::string euroc = "calibration: {format: euroc, left: cam0.yaml, right: cam1.yaml}\n";
  const std::string rate = "rate_hz: 15\n";
  const std::string rectified = "rectified: true\n";
  const auto error_of = [this](const std::string& yaml) {
    write("dataset.yaml", yaml);
    return error();
  };
  EXPECT_EQ(error_of(images + rate + rectified + camera), "");
  EXPECT_EQ(error_of(images + rate + euroc), "");
  for (const auto& [yaml, part] : std::vector<std::pair<std::string, std::string>>{
           {"", "left: is missing"},
           {"left: l/*.png\n" + rate + rectified + camera, "right: is missing"},
           {images + rectified + camera, "rate_hz"},
           {images + rate + "timestamps: file_name_ns\n" + rectified + camera, "one of rate_hz"},
           {images + rate + rectified, "camera"},
           {images + rate + camera, "rectified is false"},
           {images + rate, "calibration"},
           {images + rate + rectified + camera + euroc, "calibration"},
           {images + rate + euroc + "mount: {xyz_m: [0, 0, 0]}\n", "mount"},
           {images + rate + rectified + camera + "scale_m: 0.1\n", "scale_m"},
           {"depth: d/*.png\n" + images + rate + camera, "depth"},
           {"depth: d/*.png\n" + rate + camera, "scale_m: is missing"},
           {images + rate + rectified + camera + "truth: {file: t}\n", "truth"},
           {images + rate + rectified + camera + "fps: 3\n", "dataset.yaml:6: fps: unknown key"},
           {images + "rate_hz: fast\n" + rectified + camera, "dataset.yaml:3: rate_hz"},
           {images + "rate_hz: 0\n" + rectified + camera, "dataset.yaml:3: rate_hz"},
           {"left: nothing/*.png\nright: r/*.png\n" + rate + rectified + camera, "nothing"},
           {"left: l/*.tif\nright: r/*.png\n" + rate + rectified + camera, "*.tif: no such files"},
           {images + rate + "calibration: {format: euroc, left: cam0.yaml, right: cam9.yaml}\n",
            "cam9.yaml"},
           {images + "timestamps_us: none.txt\n" + rectified + camera, "none.txt"}}) {
    const std::string message = error_of(yaml);
    EXPECT_TRUE(names(message, part)) << yaml << "-> '" << message << "'";
    EXPECT_TRUE(names(message, folder_.string())) << message;
  }
}

TEST_F(Datasets, TimesMustRiseAndBeAsManyAsFrames) {
  pairs(3);
  write("dataset.yaml",
        "left: l/*.png\nright: r/*.png\ntimestamps_us: times.txt\nrectified: true\n"
        "camera: {fx_px: 30, fy_px: 30, cx_px: 16, cy_px: 12, baseline_m: 0.1}\n");
  const auto error_of = [this](const std::string& times) {
    write("times.txt", times);
    return error();
  };
  EXPECT_EQ(error_of("# us\n5\n\n105\n207\n"), "");
  const auto dataset = open();
  EXPECT_EQ(dataset->frames->next()->utime, 5);
  EXPECT_EQ(dataset->frames->next()->utime, 105);
  EXPECT_EQ(dataset->frames->next()->utime, 207);
  EXPECT_TRUE(names(error_of("5\n105\n105\n"), "times.txt:3: "));
  EXPECT_TRUE(names(error_of("5\n4\n105\n"), "times.txt:2: "));
  EXPECT_TRUE(names(error_of("5\nsoon\n105\n"), "times.txt:2: 'soon'"));
  EXPECT_TRUE(names(error_of("5\n6.5\n105\n"), "times.txt:2: "));
  EXPECT_TRUE(names(error_of("5\n105\n"), "2 times for 3 frames"));
}

TEST_F(Datasets, AEurocFolderOpensByItsOwnFormWithAndWithoutList) {
  for (const bool with_csv : {false, true}) {
    fs::remove_all(folder_ / "mav0");
    euroc(5, with_csv);
    write("mav0/state_groundtruth_estimate0/data.csv", "#timestamp, p_x\n");
    for (const std::string& folder : {folder_.string(), path("mav0")}) {
      const auto dataset = open_dataset(folder);
      ASSERT_TRUE(dataset) << dataset.error().message;
      FrameSource& frames = *dataset->frames;
      EXPECT_EQ(frames.size(), 5);
      EXPECT_NEAR(frames.rate_hz(), 20, 1e-9);
      EXPECT_NEAR(frames.rig().baseline_m(), 0.1, 1e-12);
      EXPECT_EQ(frames.next()->utime, 1'400'000'000'000'001);
      EXPECT_EQ(frames.next()->utime, 1'400'000'000'050'001);
      EXPECT_EQ(dataset->info.truth_format, "euroc");
      EXPECT_EQ(dataset->info.truth_frame, "body");
      EXPECT_TRUE(fs::exists(dataset->info.truth_file));
    }
  }
}

TEST_F(Datasets, AEurocFolderNamesWhatIsMissingOrSurplus) {
  const std::string third = "1400000000100000600.png";
  for (const bool with_csv : {false, true}) {
    for (const std::string camera : {"cam0", "cam1"}) {
      fs::remove_all(folder_ / "mav0");
      euroc(5, with_csv);
      fs::remove(path("mav0/" + camera + "/data/" + third));
      EXPECT_TRUE(names(error(), camera + "/data/" + third)) << error();
      EXPECT_TRUE(names(error(), "missing")) << error();
    }
  }
  fs::remove_all(folder_ / "mav0");
  euroc(5, true);
  write_image("mav0/cam1/data/1400000000333000600.png", noise_image(0));
  EXPECT_TRUE(names(error(), "cam1/data/1400000000333000600.png: is not in")) << error();
  euroc(5, false);
  EXPECT_TRUE(names(error(), "1400000000333000600.png")) << error();
}

TEST_F(Datasets, AEurocSensorFileThatIsWrongIsNamed) {
  euroc(2, true);
  const auto error_of = [this](const std::string& from, const std::string& to) {
    std::string text = sensor1();
    write("mav0/cam1/sensor.yaml", text.replace(text.find(from), from.size(), to));
    return error();
  };
  EXPECT_TRUE(names(error_of("pinhole", "omni"), "cam1/sensor.yaml:13: camera_model"));
  EXPECT_TRUE(names(error_of("[32, 24]", "[32, 25]"), "resolution"));
  EXPECT_TRUE(names(error_of("1, 0, 0, 0.1", "1, 0.1, 0, 0.1"), "T_BS"));
  EXPECT_TRUE(names(error_of("0.1,", "-0.1,"), "swapped"));
  EXPECT_TRUE(names(error_of("[-0.1, 0.01, 0, 0]", "[-0.1, 0.01, 0]"), "coefficients"));
}

TEST_F(Datasets, AKittiFolderOpensWithAndWithoutTimes) {
  kitti(4);
  const auto at_rate = open();
  ASSERT_TRUE(at_rate) << at_rate.error().message;
  EXPECT_DOUBLE_EQ(at_rate->frames->rig().baseline_m(), 0.1);
  EXPECT_TRUE(at_rate->frames->rig().rectified);
  at_rate->frames->seek(3);
  EXPECT_EQ(at_rate->frames->next()->utime, 300'000);
  EXPECT_EQ(at_rate->info.truth_file, "");

  write("times.txt", "0.000000e+00\n1.037359e-01\n2.074819e-01\n3.112053e-01\n");
  write("poses.txt", "");
  const auto timed = open();
  ASSERT_TRUE(timed) << timed.error().message;
  timed->frames->seek(1);
  EXPECT_EQ(timed->frames->next()->utime, 103'736);
  EXPECT_EQ(timed->info.truth_format, "kitti");

  write("times.txt", "0.000000e+00\n2.074819e-01\n1.037359e-01\n3.112053e-01\n");
  EXPECT_TRUE(names(error(), "times.txt:3: ")) << error();
  write("times.txt", "0\n1\n2\n");
  EXPECT_TRUE(names(error(), "3 times for 4 images")) << error();
  fs::remove(path("times.txt"));
  fs::remove(path("image_1/000002.png"));
  EXPECT_TRUE(names(error(), "image_1/000002.png: is missing")) << error();
}

TEST_F(Datasets, AKittiCalibrationThatIsWrongIsNamed) {
  kitti(1);
  const std::string P0 = "P0: 30 0 16 0 0 30 12 0 0 0 1 0\n";
  const auto error_of = [this](const std::string& text) {
    write("calib.txt", text);
    return error();
  };
  EXPECT_EQ(error_of("30 0 16 0 0 30 12 0 0 0 1 0\n30 0 16 -3 0 30 12 0 0 0 1 0\n"), "");
  EXPECT_TRUE(names(error_of(P0), "P1: is missing"));
  EXPECT_TRUE(names(error_of(P0 + "P1: 30 0 16 -3 0 30\n"), "calib.txt:2: P1: has 6 numbers"));
  EXPECT_TRUE(names(error_of(P0 + "P1: 30 0 16 x 0 30 12 0 0 0 1 0\n"), "calib.txt:2: P1: 'x'"));
  EXPECT_TRUE(names(error_of(P0 + "P1: 30 0 16 3 0 30 12 0 0 0 1 0\n"), "swapped"));
  EXPECT_TRUE(names(error_of(P0 + "P1: 31 0 16 -3 0 30 12 0 0 0 1 0\n"), "P1: differs"));
  EXPECT_TRUE(names(error_of(P0 + P0), "P0: stands here twice"));
}

TEST_F(Datasets, AFolderThatIsNoDatasetSaysWhatWasLookedFor) {
  EXPECT_TRUE(names(error(), "dataset.yaml"));
  EXPECT_TRUE(names(open_dataset(path("nowhere")).error().message, "nowhere: no such folder"));
}

}  // namespace
}  // namespace cairn::camera
