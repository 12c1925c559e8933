// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "core/config.hpp"
#include "localization/correction_schedule.hpp"
#include "localization/distance_field.hpp"
#include "localization/map_provenance.hpp"
#include "localization/odometry_chain.hpp"
#include "localization/particle_filter.hpp"
#include "localization/pose_belief.hpp"
#include "localization/refinement.hpp"
#include "localization/surface.hpp"
#include "localization/view.hpp"
#include "mapping/map_replica.hpp"
#include "stereo/disparity_image.hpp"

namespace cairn::localization {

struct LocalizerConfig {
  bool correct = false;
  ViewConfig view;
  MotionConfig motion;
  RefinementConfig refinement;
  FilterConfig filter;
  int field_blocks = 300;
  double fits_share = 0.6;
  double lost_share = 0.4;
  double lost_after_s = 0.5;
  double rival_better = 0.1;
  int rival_views = 8;
  int seed = 1;

  void visit(ConfigVisitor& v) {
    v.flag("correct", correct,
           "POSE is corrected by the map; false: odometry is passed on, as beside good visual "
           "odometry the corrections may still cost some millimetres");
    v.group("view", view, "which points of a frame are used");
    v.group("motion", motion, "how far odometry is to be trusted");
    v.group("refinement", refinement, "how the pose is fitted to the map");
    v.group("filter", filter, "the particle filter");
    v.number("fits_share", fits_share, {0.05, 1}, "",
             "share of the points on things that stand that must end at a surface of the map for a "
             "place to be taken");
    v.number("lost_share", lost_share, {0, 1}, "",
             "with a share under this the robot is not where it thinks");
    v.number("lost_after_s", lost_after_s, {0.1, 60}, "s", "after so long of that it is lost");
    v.number("rival_better", rival_better, {0, 1}, "",
             "by how much more of the points another place must fit to be taken instead");
    v.integer("rival_views", rival_views, 1, 1000, "", "in so many views in a row");
    v.integer("field_blocks", field_blocks, 10, 100'000, "",
              "blocks of 8 x 8 x 8 cells of the distance field brought up to date per frame, at "
              "most");
    v.integer("seed", seed, 0, 1 << 30, "", "of all that is random");
  }
};

/// What a restarted localizer goes on from.
struct LocalizerMemory {
  OdometryFrame frame;                         ///< the last one
  Isometry T_map_body = Isometry::Identity();  ///< there, as said
  Matrix6d covariance = Matrix6d::Zero();
  Certainty certainty = Certainty::kTracking;
};

/// Where the robot is in the map. Told of each frame's motion it says the pose at once; shown what
/// was seen it corrects where the odometry frame lies in the map, from two frames later on.
///
/// The particle filter decides which place it is: while the view fits the map from where the robot
/// is taken to be, that belief goes on by odometry and the refinement; where the filter's particles
/// gather elsewhere and the view fits clearly better from there, view after view, that place is
/// taken. Where nothing fits the robot is lost, and particles look for it all over the map.
class Localizer {
 public:
  explicit Localizer(const LocalizerConfig& config);

  struct Pose {
    Isometry T_map_odom = Isometry::Identity();
    Matrix6d covariance = Matrix6d::Zero();  ///< of T_map_body
    Certainty certainty = Certainty::kTracking;
    Utime correction_utime = 0;  ///< of the frame that the correction in use rests on
  };

  /// The next frame, in order.
  [[nodiscard]] Pose move(const OdometryFrame& frame);

  struct Update {
    bool known_frame = false;  ///< else move() was not told of it, or long ago, and nothing is done
    bool in_time = true;       ///< false: POSE should have used it already
    Fit fit;                   ///< of the view, from where the robot is taken to be
  };

  /// What was seen at a frame that move() was told of, with the map as it is to be used at that
  /// frame and what changed in it since the last time.
  Update update(const stereo::DisparityImage& seen, const mapping::MapReplica& map,
                const mapping::MapReplica::Changes& changes);

  /// Forgets where it is, and looks for it all over the map.
  void forget();
  /// Somebody says where it is.
  void start_at(const Isometry& T_map_body, double sigma_m, double sigma_rad);

  /// Nothing before the first frame.
  [[nodiscard]] std::optional<LocalizerMemory> memory() const;
  void resume(const LocalizerMemory& memory);

  [[nodiscard]] const PoseBelief& belief() const { return belief_; }
  [[nodiscard]] const ParticleFilter& filter() const { return filter_; }
  /// How often another place was taken.
  [[nodiscard]] std::int64_t relocalised() const { return relocalised_; }

 private:
  struct Step {
    Utime utime = 0;
    Motion motion;
  };

  void take_motion(const Step& step);
  void refresh_field(const View& view);
  [[nodiscard]] Refinement corrected(const MapView& map, const View& view);
  /// Whether the map says anything about a view from there; how much of what stands it bears out;
  /// whether that is enough.
  [[nodiscard]] static bool shown(const Fit& fit, const View& view);
  [[nodiscard]] static double share(const Fit& fit);
  [[nodiscard]] bool fits(const Fit& fit, const View& view) const;
  void be_at(const PoseBelief& pose);
  void look_around(const MapView& map, const View& view, const Fit& fit);
  void consider_rival(const MapView& map, const View& view, const Fit& fit,
                      const std::vector<Cluster>& clusters);
  void judge(const View& view, const Fit& fit);
  [[nodiscard]] bool another_place_fits(const View& view,
                                        const std::vector<Cluster>& clusters) const;

  LocalizerConfig config_;
  OdometryChain chain_;
  CorrectionSchedule schedule_;
  std::deque<Step> steps_;  ///< not taken into the belief yet
  PoseBelief belief_;       ///< at belief_utime_, the last frame seen
  Utime belief_utime_ = 0;
  ParticleFilter filter_;
  DistanceField field_;
  Surfaces surfaces_;
  MapProvenance provenance_;
  double way_m_ = 0;  ///< since the map was last learned from
  double turned_rad_ = 0;
  Certainty certainty_ = Certainty::kTracking;
  bool search_ = false;     ///< all over the map, as soon as it shows free space
  bool forgotten_ = false;  ///< the belief is of no account
  bool looks_alike_ = false;
  int fits_again_ = 0;  ///< views in a row that fit from where the belief is
  std::optional<Utime> misfit_since_;
  Isometry rival_ = Isometry::Identity();  ///< where it may be instead
  int rival_views_ = 0;
  std::int64_t relocalised_ = 0;
};

}  // namespace cairn::localization
