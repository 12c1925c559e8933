// SPDX-License-Identifier: Apache-2.0
#include "simulation/disparity_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "simulation/random_hash.hpp"
#include "stereo/rectifier.hpp"

namespace cairn::simulation {
namespace {

using stereo::DisparityImage;
using stereo::Reason;

constexpr int kStep_px = DisparityModel::kStep_px;
constexpr float kEnd_px = static_cast<float>(DisparityModel::kEnd_px);
/// Below this the matcher's best answer is the first that it looks at.
constexpr float kFarthest_px = 2;
/// Sizes of what an error, and what a drop-out, have in common on a surface.
constexpr double kErrorPatch_m = 0.04;
constexpr double kDropPatch_m = 0.1;
constexpr float kSurfaceShare = 0.55F;  ///< of an error's variance
constexpr float kDropSurfaceShare = 0.8F;
/// A change of disparity from cell to cell that is an edge and no slope.
constexpr float kJump_px = 3;
constexpr int kEdgeReach = 4;  ///< cells

/// How answers of one kind are: by confidence 0 to 3.
struct Kind {
  std::array<float, 4> up_to;     ///< share of answers with this confidence or less
  std::array<float, 4> sigma_px;  ///< of their error
  float bias_px;
};
constexpr Kind kPlain{{0.05F, 0.13F, 0.24F, 1}, {1.43F, 0.54F, 0.40F, 0.31F}, 0.05F};
/// The floor as a low camera sees it: disparity changes by over half a pixel from row to row.
constexpr Kind kSlanted{{0.65F, 0.88F, 0.96F, 1}, {1.55F, 0.73F, 0.53F, 0.44F}, -0.3F};
constexpr Kind kBesideEdge{{0.32F, 0.68F, 0.98F, 1}, {1.5F, 0.52F, 0.40F, 0.40F}, 0.04F};
constexpr float kSlanted_px_per_px = 0.6F;

/// By cells to the nearest edge, 1 to kEdgeReach, and farther off.
constexpr std::array<float, kEdgeReach + 1> kDropsAtEdge{0.21F, 0.13F, 0.10F, 0.08F, 0.02F};
constexpr float kDropsOnSlantedFloor = 0.023F;
/// Share of background cells that bear the foreground's disparity, by cells to its edge.
constexpr std::array<float, 3> kBleeds{0.31F, 0.1F, 0.03F};
/// Seen by the left eye alone: by chance the true answer, or the foreground's.
constexpr float kCoveredRight = 0.15F;
constexpr float kCoveredForeground = 0.15F;
/// Too near, or outside the right picture: shares of made-up answers, and of these in confidence 0.
constexpr float kMadeUpNear = 0.15F;
constexpr float kMadeUpOutside = 0.04F;
constexpr float kMadeUpUnsure = 0.87F;
constexpr float kBleedUnsure = 0.88F;

float unit(std::uint64_t hash) { return static_cast<float>(hash >> 40) * 0x1.0p-24F; }

/// Of mean 0 and deviation 1, within 3.5: four even numbers' sum.
float near_normal(std::uint64_t hash) {
  const auto part = [&](int shift) { return static_cast<float>((hash >> shift) & 0xffff); };
  const float sum = part(0) + part(16) + part(32) + part(48);
  return (sum * (1.0F / 65536) - 2) * 1.7320508F;
}

/// One image in the making.
class Matching {
 public:
  Matching(const cv::Mat_<float>& truth_px, const stereo::RectifiedCamera& camera,
           const Isometry& T_world_camera, std::uint64_t seed, std::uint64_t frame_seed)
      : truth_px_{truth_px},
        camera_{camera},
        T_world_camera_{T_world_camera},
        depth_per_px_{1 / camera.f_px},
        drop_seed_{hash64(seed, 1)},
        error_seed_{hash64(seed, 2)},
        frame_seed_{frame_seed},
        edge_(static_cast<std::size_t>(truth_px.cols)),
        left_edge_(edge_.size()),
        right_edge_(edge_.size()),
        covered_by_px_(edge_.size()) {}

  void match(DisparityImage& image) {
    for (int row = 0; row < truth_px_.rows; ++row) {
      find_edges(row);
      find_covered(row);
      for (int col = 0; col < truth_px_.cols; ++col) match_cell(row, col, image);
    }
  }

 private:
  struct Chance {
    std::uint64_t surface;  ///< the same for the same place of a surface
    std::uint64_t frame;    ///< new in each frame
  };

  /// Cells to the nearest jump along the row; where the nearer surface is, to its left or right.
  void find_edges(int row) {
    const float* const truth = truth_px_[row];
    const int cols = truth_px_.cols;
    int since = kEdgeReach + 1;
    int since_nearer = kEdgeReach + 1;
    for (int col = 0; col < cols; ++col) {
      const float jump = col > 0 ? truth[col - 1] - truth[col] : 0;
      since = std::abs(jump) > kJump_px ? 1 : std::min(since + 1, kEdgeReach + 1);
      if (jump > kJump_px) {
        since_nearer = 1;
      } else {
        since_nearer =
            jump < -kJump_px ? kEdgeReach + 1 : std::min(since_nearer + 1, kEdgeReach + 1);
      }
      edge_[index(col)] = since;
      left_edge_[index(col)] = since_nearer;
    }
    since = kEdgeReach + 1;
    since_nearer = kEdgeReach + 1;
    for (int col = cols - 1; col >= 0; --col) {
      const float jump = col + 1 < cols ? truth[col + 1] - truth[col] : 0;
      since = std::abs(jump) > kJump_px ? 1 : std::min(since + 1, kEdgeReach + 1);
      if (jump > kJump_px) {
        since_nearer = 1;
      } else {
        since_nearer =
            jump < -kJump_px ? kEdgeReach + 1 : std::min(since_nearer + 1, kEdgeReach + 1);
      }
      edge_[index(col)] = std::min(edge_[index(col)], since);
      right_edge_[index(col)] = since_nearer;
    }
  }

  /// The disparity that hides a cell from the right eye; 0: it sees it.
  void find_covered(int row) {
    const float* const truth = truth_px_[row];
    float leftmost_px = std::numeric_limits<float>::infinity();
    float by_px = 0;
    for (int col = truth_px_.cols - 1; col >= 0; --col) {
      const float right_px = static_cast<float>(col * kStep_px) - truth[col];
      const bool covered = right_px > leftmost_px - 0.5F;
      covered_by_px_[index(col)] = covered ? by_px : 0;
      if (right_px < leftmost_px) {
        leftmost_px = right_px;
        by_px = truth[col];
      }
    }
  }

  void match_cell(int row, int col, DisparityImage& image) {
    const float truth = truth_px_(row, col);
    if (truth < kFarthest_px) return none(row, col, Reason::kOutOfRange, image);
    const Chance drop = chance(row, col, kDropPatch_m, drop_seed_);
    if (truth >= kEnd_px) {
      return make_up(row, col, drop, kMadeUpNear, kEnd_px, Reason::kOutOfRange, image);
    }
    const float to_border_px = static_cast<float>(col * kStep_px);
    if (truth > to_border_px) {
      return make_up(row, col, drop, kMadeUpOutside, to_border_px, Reason::kNoData, image);
    }
    const float lot =
        unit(unit(hash64(drop.frame, 3)) < kDropSurfaceShare ? drop.surface : drop.frame);
    if (const float by_px = covered_by_px_[index(col)]; by_px > 0) {
      if (lot < kCoveredRight) return answer(row, col, truth, kBesideEdge, image);
      if (lot < kCoveredRight + kCoveredForeground) return bleed(row, col, by_px, drop, image);
      return none(row, col, Reason::kNoData, image);
    }
    if (bleeds(row, col, drop, image)) return;
    const float slope = slope_down(row, col);
    const int edge = edge_[index(col)];
    const bool slanted = slope >= kSlanted_px_per_px;
    float drops = kDropsAtEdge[static_cast<std::size_t>(edge - 1)];
    if (slanted && edge > kEdgeReach) drops = kDropsOnSlantedFloor;
    drops += drops_by_slope_across(row, col);
    if (lot < drops) return none(row, col, Reason::kAmbiguous, image);
    answer(row, col, truth, slanted ? kSlanted : edge <= kEdgeReach ? kBesideEdge : kPlain, image);
  }

  void answer(int row, int col, float truth, const Kind& kind, DisparityImage& image) {
    const Chance common = chance(row, col, kErrorPatch_m, error_seed_);
    const float sureness = unit(hash64(common.surface, 4));
    std::size_t confidence = 0;
    while (confidence < 3 && sureness > kind.up_to[confidence]) ++confidence;
    // An error reaches over some pixels: two cells by two share what is new in the frame.
    const std::uint64_t block =
        hash64(frame_seed_, static_cast<std::uint64_t>((row / 2) * truth_px_.cols + col / 2));
    const float error = std::sqrt(kSurfaceShare) * near_normal(common.surface) +
                        std::sqrt(1 - kSurfaceShare) * near_normal(block);
    put(row, col, truth + kind.bias_px + kind.sigma_px[confidence] * error,
        static_cast<std::uint8_t>(confidence), image);
  }

  bool bleeds(int row, int col, const Chance& drop, DisparityImage& image) {
    for (const auto& [cells, side] :
         {std::pair{left_edge_[index(col)], -1}, {right_edge_[index(col)], 1}}) {
      if (cells > static_cast<int>(kBleeds.size())) continue;
      if (unit(hash64(drop.surface, 5)) >= kBleeds[static_cast<std::size_t>(cells - 1)]) continue;
      const float nearer_px = truth_px_(row, std::clamp(col + side * cells, 0, truth_px_.cols - 1));
      if (nearer_px >= kEnd_px) continue;
      bleed(row, col, nearer_px, drop, image);
      return true;
    }
    return false;
  }

  void bleed(int row, int col, float nearer_px, const Chance& drop, DisparityImage& image) {
    const bool sure = unit(hash64(drop.surface, 6)) >= kBleedUnsure;
    put(row, col, std::min(nearer_px, kEnd_px - 1) + 0.5F * near_normal(drop.frame), sure ? 1 : 0,
        image);
  }

  void make_up(int row, int col, const Chance& drop, float share, float end_px, Reason otherwise,
               DisparityImage& image) {
    if (unit(drop.surface) >= share) return none(row, col, otherwise, image);
    const float disparity = kFarthest_px + unit(hash64(drop.surface, 7)) * (end_px - kFarthest_px);
    const bool sure = unit(hash64(drop.surface, 8)) >= kMadeUpUnsure;
    put(row, col, disparity, sure ? 1 : 0, image);
  }

  static void put(int row, int col, float disparity_px, std::uint8_t confidence,
                  DisparityImage& image) {
    if (disparity_px < kFarthest_px || disparity_px >= kEnd_px)
      return none(row, col, Reason::kOutOfRange, image);
    image.disparity_16ths(row, col) = static_cast<std::uint16_t>(16 * disparity_px + 0.5F);
    image.code(row, col) = confidence;
  }

  static void none(int row, int col, Reason reason, DisparityImage& image) {
    image.disparity_16ths(row, col) = 0;
    image.code(row, col) = static_cast<std::uint8_t>(reason);
  }

  /// Change of disparity per pixel downwards; 0 beside an edge.
  [[nodiscard]] float slope_down(int row, int col) const {
    if (row == 0 || row + 1 == truth_px_.rows) return 0;
    const float above = truth_px_(row, col) - truth_px_(row - 1, col);
    const float below = truth_px_(row + 1, col) - truth_px_(row, col);
    if (std::abs(below - above) > kJump_px) return 0;
    return std::abs(above + below) / (2 * kStep_px);
  }

  /// Walls seen at a small angle: their pictures differ too much in the two eyes.
  [[nodiscard]] float drops_by_slope_across(int row, int col) const {
    if (col == 0 || col + 1 == truth_px_.cols || edge_[index(col)] <= 1) return 0;
    const float slope =
        std::abs(truth_px_(row, col + 1) - truth_px_(row, col - 1)) / (2 * kStep_px);
    return std::clamp(4 * (slope - 0.35F), 0.0F, 0.65F);
  }

  [[nodiscard]] Chance chance(int row, int col, double patch_m, std::uint64_t patch_seed) const {
    constexpr std::uint64_t kBits = 21;
    const double depth_m =
        camera_.f_px * camera_.baseline_m / (truth_px_(row, col) + camera_.doffs_px);
    const Eigen::Vector3d at_m =
        T_world_camera_ *
        Eigen::Vector3d((col * kStep_px - camera_.cx_px) * depth_per_px_ * depth_m,
                        (row * kStep_px - camera_.cy_px) * depth_per_px_ * depth_m, depth_m);
    std::uint64_t patch = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto number = static_cast<std::int64_t>(std::floor(at_m[axis] / patch_m));
      patch = patch << kBits | (static_cast<std::uint64_t>(number) & ((1U << kBits) - 1));
    }
    const std::uint64_t surface = hash64(patch ^ patch_seed);
    return {surface, hash64(frame_seed_ ^ surface)};
  }

  static std::size_t index(int col) { return static_cast<std::size_t>(col); }

  const cv::Mat_<float>& truth_px_;
  const stereo::RectifiedCamera& camera_;
  const Isometry& T_world_camera_;
  double depth_per_px_;
  std::uint64_t drop_seed_;
  std::uint64_t error_seed_;
  std::uint64_t frame_seed_;
  std::vector<int> edge_;
  std::vector<int> left_edge_;
  std::vector<int> right_edge_;
  std::vector<float> covered_by_px_;
};

}  // namespace

Result<DisparityModel> DisparityModel::create(const World& world, const camera::RigCalibration& rig,
                                              std::uint64_t seed) {
  const auto rectifier = stereo::Rectifier::create(rig);
  if (!rectifier) return tl::make_unexpected(rectifier.error());
  const stereo::RectifiedCamera& camera = rectifier->camera();
  auto depth = DepthRenderer::create(
      world,
      camera::rectified_rig(camera.f_px, camera.f_px, camera.cx_px, camera.cy_px, camera.baseline_m,
                            camera.width_px, camera.height_px, camera.T_body_camera));
  if (!depth) return tl::make_unexpected(depth.error());
  return DisparityModel{std::move(*depth), camera, seed};
}

DisparityImage DisparityModel::see(const Isometry& T_world_body, std::int64_t frame, Utime utime,
                                   std::span<const PersonPose> people) const {
  cv::Mat_<float> disparity_px = depth_.left_m(T_world_body, kStep_px, people);
  const double focal_baseline = camera_.f_px * camera_.baseline_m;
  for (float& value : disparity_px) {
    if (value > 0) value = static_cast<float>(focal_baseline / value - camera_.doffs_px);
  }
  DisparityImage image;
  image.utime = utime;
  image.step_px = kStep_px;
  image.camera = camera_;
  image.disparity_16ths.create(disparity_px.size());
  image.code.create(disparity_px.size());
  const Isometry T_world_camera = T_world_body * camera_.T_body_camera;
  Matching(disparity_px, camera_, T_world_camera, seed_,
           hash64(seed_, static_cast<std::uint64_t>(frame)))
      .match(image);
  return image;
}

}  // namespace cairn::simulation
