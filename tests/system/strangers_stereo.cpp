// SPDX-License-Identifier: Apache-2.0
// A student's own stereo process: nothing of cairn but its message types. Takes STEREO_FRAME and
// CALIBRATION, matches at quarter size with OpenCV, sends DISPARITY as a plain grid. For rectified
// JPEG frames.
#include <cairn/disparity_t.hpp>
#include <cairn/rig_calibration_t.hpp>
#include <cairn/stereo_frame_t.hpp>
#include <lcm/lcm-cpp.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace {

constexpr int kStep_px = 4;

class StrangersStereo {
 public:
  explicit StrangersStereo(lcm::LCM& lcm) : lcm_{lcm} {}

  void on_calibration(const lcm::ReceiveBuffer*, const std::string&,
                      const cairn::rig_calibration_t* rig) {
    rig_ = *rig;
  }

  void on_frame(const lcm::ReceiveBuffer*, const std::string&, const cairn::stereo_frame_t* frame) {
    if (rig_.calibration_id != frame->calibration_id) return;
    cairn::disparity_t out{};
    out.header.utime = frame->header.utime;
    out.header.session = 4711;
    out.header.sequence = sequence_++;
    out.calibration_id = frame->calibration_id;
    out.step_px = kStep_px;
    out.columns = (frame->width_px + kStep_px - 1) / kStep_px;
    out.rows = (frame->height_px + kStep_px - 1) / kStep_px;
    out.camera.f_px = rig_.left.fx_px;
    out.camera.cx_px = rig_.left.cx_px - 0.5 * (kStep_px - 1);  // a cell's middle
    out.camera.cy_px = rig_.left.cy_px - 0.5 * (kStep_px - 1);
    out.camera.baseline_m = -rig_.T_right_left.position_m[0];
    out.camera.width_px = frame->width_px;
    out.camera.height_px = frame->height_px;
    out.camera.T_body_camera = rig_.T_body_left;
    const cv::Size size(out.columns, out.rows);
    cv::Mat disparity;  // 1/16 px of the small image
    matcher_->compute(small(frame->left, size), small(frame->right, size), disparity);
    out.packed.assign(1, 0);  // a plain grid
    for (int i = 0; i < size.area(); ++i) {
      const int sixteenths = std::max<int>(0, disparity.ptr<std::int16_t>()[i]) * kStep_px;
      out.packed.push_back(static_cast<std::uint8_t>(sixteenths));
      out.packed.push_back(static_cast<std::uint8_t>(sixteenths >> 8));
    }
    for (int i = 0; i < size.area(); ++i)
      out.packed.push_back(disparity.ptr<std::int16_t>()[i] > 0 ? 3 : 0);
    out.packed_size = static_cast<std::int32_t>(out.packed.size());
    lcm_.publish("DISPARITY", &out);
  }

 private:
  static cv::Mat small(const std::vector<std::uint8_t>& jpeg, cv::Size size) {
    cv::Mat image = cv::imdecode(jpeg, cv::IMREAD_GRAYSCALE);
    cv::resize(image, image, size, 0, 0, cv::INTER_AREA);
    return image;
  }

  lcm::LCM& lcm_;
  cairn::rig_calibration_t rig_{};
  cv::Ptr<cv::StereoSGBM> matcher_ = cv::StereoSGBM::create(0, 48, 5, 200, 800, 1, 31, 10, 50, 2);
  int sequence_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  lcm::LCM lcm(argc > 1 ? argv[1] : "");
  if (!lcm.good()) return 1;
  StrangersStereo stereo(lcm);
  lcm.subscribe("CALIBRATION", &StrangersStereo::on_calibration, &stereo);
  lcm.subscribe("STEREO_FRAME", &StrangersStereo::on_frame, &stereo);
  while (lcm.handle() == 0) {
  }
  return 0;
}
