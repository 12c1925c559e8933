// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "bus/node.hpp"
#include "procs/cli/demo_plan.hpp"
#include "procs/cli/explore_order.hpp"
#include "procs/cli/run_recorder.hpp"
#include "procs/cli/run_results.hpp"
#include "procs/cli/simulated_place.hpp"

namespace cairn::cli {

/// One that watches a demo, on a bus node of its own: records it, has the robot explore, knows how
/// far it is, and when it is over.
class DemoWatch {
 public:
  /// Plan, place and node must outlive this.
  [[nodiscard]] static Result<std::unique_ptr<DemoWatch>> create(const DemoPlan& plan,
                                                                 SimulatedPlace& place,
                                                                 bus::Node& node);

  DemoWatch(const DemoPlan& plan, SimulatedPlace& place, bus::Node& node,
            std::unique_ptr<RunRecorder> recorder);

  /// Takes in what was heard since; to be called now and then.
  void update();

  /// Why the demo is over; nothing while it goes on.
  [[nodiscard]] std::optional<RunEnd> end() const;

  /// Time, coverage, way, and what the planner says, in one line.
  [[nodiscard]] std::string progress() const;

  [[nodiscard]] const RunRecorder& recorder() const { return *recorder_; }

  /// What is true of the run, for its report.
  [[nodiscard]] RunTruth truth() const;

 private:
  const DemoPlan& plan_;
  SimulatedPlace& place_;
  std::unique_ptr<RunRecorder> recorder_;
  ExploreOrder order_;
  std::size_t visited_ = 0;  ///< of the true poses
  double way_m_ = 0;
};

}  // namespace cairn::cli
