// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/config.hpp"
#include "localization/distance_field.hpp"
#include "localization/free_floor.hpp"
#include "localization/odometry_chain.hpp"
#include "localization/particle.hpp"
#include "localization/pose_belief.hpp"
#include "localization/random_source.hpp"
#include "localization/sensor_model.hpp"
#include "localization/view.hpp"

namespace cairn::localization {

struct FilterConfig {
  std::string resampling = "systematic";
  int min_particles = 200;
  int max_particles = 2000;
  int global_particles = 6000;
  double along_share = 0.2;
  double body_middle_m = 0.2;
  double clearance_m = 0.18;
  double jitter_m = 0.01;
  double jitter_rad = 0.006;
  double weigh_every_m = 0.05;
  double weigh_every_rad = 0.05;
  double new_view_m = 0.5;
  double new_view_rad = 0.4;
  SensorConfig sensor;

  void visit(ConfigVisitor& v) {
    v.choice("resampling", resampling, {"systematic", "coarse"},
             "systematic: on effective count, with a share at random when the fit gets worse; "
             "coarse: the coarse random sorting of Ferrese 2012");
    v.integer("min_particles", min_particles, 20, 100'000, "", "when all are in one place");
    v.integer("max_particles", max_particles, 20, 100'000, "", "when they are spread");
    v.integer("global_particles", global_particles, 100, 1'000'000, "",
              "when it may be anywhere in the map");
    v.number("along_share", along_share, {0, 1}, "",
             "share of the particles, the best, that are also judged by what stands in the way of "
             "their beams");
    v.number("body_middle_m", body_middle_m, {0, 5}, "m",
             "height over the floor at which free space is looked for");
    v.number("clearance_m", clearance_m, {0, 5}, "m", "from the body's middle to its sides");
    v.number("jitter_m", jitter_m, {0, 1}, "m", "how far copies of a particle are spread");
    v.number("jitter_rad", jitter_rad, {0, 1}, "rad", "likewise turned");
    v.number("weigh_every_m", weigh_every_m, {0, 5}, "m",
             "views are weighed when it has moved so far: one that stands sees nothing new");
    v.number("weigh_every_rad", weigh_every_rad, {0, 3}, "rad", "or turned so far");
    v.number("new_view_m", new_view_m, {0.01, 20}, "m",
             "having moved so far it sees other things; with less, a view counts by its share of "
             "this");
    v.number("new_view_rad", new_view_rad, {0.01, 7}, "rad", "or having turned so far, likewise");
    v.group("sensor", sensor, "how guesses are compared with what is seen");
  }
};

/// A place where particles gather.
struct Cluster {
  PoseBelief pose;    ///< weighted mean and spread; roll and pitch as known
  double weight = 0;  ///< share of all
};

/// Monte Carlo localisation in the voxel map (Dellaert et al. 1999): particles moved by odometry
/// plus noise, weighed by how what was seen from them fits the map, resampled. Beside that, a share
/// of the particles is drawn anywhere in free space when the view fits less well than it used to
/// (augmented MCL: Gutmann and Fox 2002), so that a false lock is undone. Same calls, same results.
class ParticleFilter {
 public:
  ParticleFilter(const FilterConfig& config, std::uint64_t seed) : config_{config}, random_{seed} {}

  /// All particles around there.
  void start_at(const PoseBelief& pose);
  /// Anywhere in the map's free space at the height of `T_map_body`'s floor, with its tilt. False
  /// if the map has no free space there.
  [[nodiscard]] bool start_anywhere(const DistanceField& field, const Isometry& T_map_body);

  [[nodiscard]] bool started() const { return !particles_.empty(); }

  /// The body moved. Motion's noise goes into the particles; R_tilt comes from `T_chain_body`, a
  /// pose whose roll and pitch are the body's now.
  void move(const Motion& motion, const Isometry& T_chain_body);

  struct Update {
    bool weighed = false;  ///< else there was nothing new in it, or no map, and nothing else holds
    double best_fit = 0;   ///< mean likelihood of a beam from the best particle, 0 to 1
    double mean_fit = 0;   ///< likewise by weight over all
    double effective = 0;  ///< particles that share the weight
    double random_share = 0;  ///< of the particles, drawn anywhere after this update
    bool resampled = false;
  };
  /// A view from where the body now is. Weighed if it is the first, or from somewhere new.
  Update weigh(const DistanceField& field, const View& view);

  [[nodiscard]] std::span<const Particle> particles() const { return particles_; }
  [[nodiscard]] const Eigen::Matrix3d& R_tilt() const { return R_tilt_; }

  /// Where the particles gather, the heaviest first; those under 2 % are left out.
  [[nodiscard]] std::vector<Cluster> clusters() const;

 private:
  void weigh_all(const DistanceField& field, const SensorModel& model, std::vector<double>& logs);
  void resample(const DistanceField& field, Update& update);
  [[nodiscard]] std::size_t bins_held() const;
  [[nodiscard]] std::size_t wanted_count() const;
  [[nodiscard]] Particle anywhere(const FreeFloor& floor, double z_m);
  [[nodiscard]] Particle near(const Particle& particle, double spread);
  [[nodiscard]] double mean_z_m() const;

  FilterConfig config_;
  RandomSource random_;
  Eigen::Matrix3d R_tilt_ = Eigen::Matrix3d::Identity();
  std::vector<Particle> particles_;
  bool weighed_ = false;
  double way_m_ = 0;  ///< since the view that was weighed last
  double turned_rad_ = 0;
  double fit_lately_ = 0;  ///< short and long running means of the fit
  double fit_usually_ = 0;
};

}  // namespace cairn::localization
