// SPDX-License-Identifier: Apache-2.0
#include "evaluation/report.hpp"

#include <fstream>
#include <numeric>
#include <sstream>

#include "evaluation/temporary_files.hpp"

namespace cairn::evaluation {
namespace {

class ReportFile : public TemporaryFiles {};

TEST(Percentiles, ByHand) {
  std::vector<double> hundred(100);
  std::iota(hundred.rbegin(), hundred.rend(), 1.0);  // 100 down to 1
  const auto of_hundred = percentiles(hundred);
  EXPECT_EQ(of_hundred->p50, 50);
  EXPECT_EQ(of_hundred->p95, 95);
  EXPECT_EQ(of_hundred->p99, 99);
  const auto of_three = percentiles({3, 1, 2});
  EXPECT_EQ(of_three->p50, 2);
  EXPECT_EQ(of_three->p99, 3);
  EXPECT_EQ(percentiles({7})->p50, 7);
  EXPECT_FALSE(percentiles({}));
}

TEST(Report, WhatWasNotMeasuredIsNull) {
  EXPECT_EQ(to_json(Report{}).dump(),
            R"({"finished":false,"reason":"","mode":"full","coverage":null,)"
            R"("trajectory":{"length_m":null,"ate_rmse_m":null,"final_ate_rmse_m":null,)"
            R"("odometry_ate_rmse_m":null,"rpe_1m":null,"end_error_m":null,)"
            R"("end_error_fraction":null,"end_yaw_error_rad":null},)"
            R"("map":{"resolution_m":null,"tolerance_m":null,"precision":null,"recall":null,)"
            R"("iou":null,"false_free_rate":null,"bytes":null},)"
            R"("latency_ms":{"frame_to_pose":null,"frame_to_correction":null,"frame_to_map":null},)"
            R"("dropped":null,"skipped":null,"restarts":null,"collisions":null,)"
            R"("realtime_factor":null,"cpu_cores":null})");
}

TEST(Report, WhatWasMeasuredStandsUnderItsKey) {
  Report report;
  report.finished = true;
  report.reason = "nothing reachable is unknown";
  report.trajectory.ate_rmse_m = 0.25;
  report.map.bytes = 123;
  report.latency_ms.frame_to_pose = Percentiles{1, 2, 3};
  report.dropped = {{"STEREO_FRAME", 0}, {"DISPARITY", 2}};
  report.restarts = std::map<std::string, std::uint64_t>{};
  const auto json = to_json(report);
  EXPECT_EQ(json["finished"], true);
  EXPECT_EQ(json["trajectory"]["ate_rmse_m"], 0.25);
  EXPECT_EQ(json["map"]["bytes"], 123);
  EXPECT_EQ(json["latency_ms"]["frame_to_pose"].dump(), R"({"p50":1.0,"p95":2.0,"p99":3.0})");
  EXPECT_EQ(json["dropped"].dump(), R"({"DISPARITY":2,"STEREO_FRAME":0})");
  EXPECT_EQ(json["restarts"].dump(), "{}");
}

TEST_F(ReportFile, IsWrittenWhole) {
  Report report;
  report.reason = "not UTF-8: \xff";
  const auto file = folder_ / "report.json";
  ASSERT_TRUE(write_report(file, report));
  std::ifstream in(file);
  const auto read = nlohmann::json::parse(in);
  EXPECT_EQ(read["mode"], "full");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);
  EXPECT_FALSE(write_report(folder_ / "missing" / "report.json", report));
}

}  // namespace
}  // namespace cairn::evaluation
