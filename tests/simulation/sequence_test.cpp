// SPDX-License-Identifier: Apache-2.0
#include "simulation/sequence.hpp"

#include "camera/frame_source.hpp"
#include "core/atomic_file.hpp"
#include "evaluation/temporary_files.hpp"
#include "scenes.hpp"
#include "simulation/drive_path.hpp"

namespace cairn::simulation {
namespace {

class Sequence : public evaluation::TemporaryFiles {
 protected:
  static World room() { return load_world(room_file()).value(); }
  static evaluation::Trajectory path(std::size_t frames) {
    auto tour = drive_round(room_tour_m(), {});
    tour.resize(frames);
    return tour;
  }
  Result<void> render(const std::string& name, std::size_t frames,
                      const SequenceConfig& config = {}) const {
    return render_sequence(room(), test_rig(160, 120), path(frames), config, folder_ / name, {});
  }
};

TEST_F(Sequence, IsADatasetThatOpens) {
  std::vector<std::size_t> progress;
  const auto written = render_sequence(
      room(), test_rig(160, 120), path(4), {}, folder_ / "run",
      [&](std::size_t done, std::size_t all) { progress.push_back(10 * all + done); });
  ASSERT_TRUE(written) << written.error().message;
  EXPECT_EQ(progress, (std::vector<std::size_t>{41, 42, 43, 44}));

  auto dataset = camera::open_dataset((folder_ / "run").string());
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_EQ(dataset->frames->size(), 4);
  EXPECT_EQ(dataset->info.truth_frame, "body");
  const auto& rig = dataset->frames->rig();
  const auto expected = test_rig(160, 120);
  EXPECT_EQ(rig.width_px, 160);
  EXPECT_NEAR(rig.left.fx_px, expected.left.fx_px, 1e-9);
  EXPECT_NEAR(rig.baseline_m(), 0.254, 1e-12);
  EXPECT_LT((rig.T_body_left.matrix() - expected.T_body_left.matrix()).cwiseAbs().maxCoeff(), 1e-9);

  const auto eyes = Renderer::create(room(), expected, {}, 1);
  ASSERT_TRUE(eyes);
  const auto truth = evaluation::read_tum(dataset->info.truth_file);
  ASSERT_TRUE(truth) << truth.error().message;
  ASSERT_EQ(truth->size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto frame = dataset->frames->next();
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->utime, (*truth)[i].utime);
    EXPECT_LT(((*truth)[i].T.matrix() - path(4)[i].T.matrix()).cwiseAbs().maxCoeff(), 1e-9);
    const auto pair = eyes->render(path(4)[i].T, static_cast<std::int64_t>(i));
    EXPECT_EQ(cv::norm(frame->left, pair.left, cv::NORM_INF), 0);
    EXPECT_EQ(cv::norm(frame->right, pair.right, cv::NORM_INF), 0);
  }
}

TEST_F(Sequence, APitchedCameraKeepsItsPitch) {
  auto rig = test_rig(160, 120);
  rig.T_body_left.linear() = rotation_from_rpy(0.02, 0.15, -0.1) * R_body_camera_forward();
  ASSERT_TRUE(render_sequence(room(), rig, path(1), {}, folder_ / "run", {}));
  const auto dataset = camera::open_dataset((folder_ / "run").string());
  ASSERT_TRUE(dataset) << dataset.error().message;
  EXPECT_LT((dataset->frames->rig().T_body_left.matrix() - rig.T_body_left.matrix())
                .cwiseAbs()
                .maxCoeff(),
            1e-9);
}

TEST_F(Sequence, TheSameSeedGivesTheSameFiles) {
  ASSERT_TRUE(render("a", 2));
  ASSERT_TRUE(render("b", 2));
  SequenceConfig other;
  other.seed = 2;
  ASSERT_TRUE(render("c", 2, other));
  for (const char* name : {"left/000001.png", "right/000001.png", "truth.txt", "dataset.yaml"}) {
    const auto a = read_file(folder_ / "a" / name);
    const auto b = read_file(folder_ / "b" / name);
    ASSERT_TRUE(a && b) << name;
    EXPECT_EQ(*a, *b) << name;
  }
  EXPECT_NE(read_file(folder_ / "a/left/000001.png").value(),
            read_file(folder_ / "c/left/000001.png").value());
}

TEST_F(Sequence, NeverMixesTwoRecordings) {
  ASSERT_TRUE(render("run", 3));
  const auto shorter = render("run", 2);
  ASSERT_FALSE(shorter);
  EXPECT_NE(shorter.error().message.find("000002.png: belongs to a longer recording"),
            std::string::npos);
  EXPECT_TRUE(camera::open_dataset((folder_ / "run").string()));
  EXPECT_TRUE(render("run", 3));
}

TEST_F(Sequence, RefusesWhatItCannotSay) {
  auto rig = test_rig(160, 120);
  rig.rectified = false;
  EXPECT_FALSE(render_sequence(room(), rig, path(1), {}, folder_ / "run", {}));
  EXPECT_FALSE(render_sequence(room(), test_rig(160, 120), {}, {}, folder_ / "run", {}));
  write("file", "in the way");
  const auto blocked =
      render_sequence(room(), test_rig(160, 120), path(1), {}, folder_ / "file", {});
  ASSERT_FALSE(blocked);
  EXPECT_NE(blocked.error().message.find("file"), std::string::npos);
}

}  // namespace
}  // namespace cairn::simulation
