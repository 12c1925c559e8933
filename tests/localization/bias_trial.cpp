#include <gtest/gtest.h>

#include <iostream>
#include <map>
#include <numbers>

#include "localization/refinement.hpp"
#include "rendered_map.hpp"
using namespace cairn;
using namespace cairn::localization;
using cairn::testing::on_floor;
TEST(Bias, Show) {
  const double kDegree = std::numbers::pi / 180;
  for (double noise : {0.0, 0.3, 0.6})
    for (double res : {0.02, 0.01}) {
      const auto world = cairn::testing::world_named("room");
      cairn::testing::NoisyEyes eyes(world, noise, 5);
      cairn::testing::OwnMap own(res);
      Utime now = 0;
      const double places[4][2] = {{-1.2, -1.1}, {1, 0.8}, {-1, 1}, {1.2, -0.9}};
      for (auto& p : places)
        for (int i = 0; i < 36; ++i) {
          auto T = on_floor(p[0], p[1], i * 10 * kDegree);
          own.see(eyes.look(T, ++now), T);
        }
      own.tell(now);
      cairn::testing::Fielded f;
      f.take_all(own.replica);
      std::map<std::string, std::array<double, 4>> stat;
      for (auto& p : places)
        for (int i = 0; i < 12; ++i) {
          auto T = on_floor(p[0] + 0.13, p[1] + 0.1, (i * 30 + 7) * kDegree);
          View v = make_view(eyes.look(T, ++now), {}, 1);
          for (auto& b : v.beams) {
            Eigen::Vector3d q = T * b.point_m;
            if ((f.field.at(f.field.cell_at(q)) & 0x7f) > 12) continue;
            auto* patch = f.surfaces.near(q, f.field, own.replica);
            if (!patch || patch->directions != 1) continue;
            Eigen::Vector3d n = patch->across[0];
            const double c = n.dot(T.linear() * b.along);
            if (c < 0) n = -n;
            const double off =
                n.dot(q - patch->middle_m);  // + = beyond the patch, away from viewer
            if (std::abs(off) > 0.06) continue;
            std::string kind = std::abs(n.z()) > 0.9   ? (n.z() < 0 ? "floor" : "ceil")
                               : std::abs(n.z()) < 0.1 ? "wall"
                                                       : "other";
            int rb = b.range_m < 1.5 ? 1 : b.range_m < 2.5 ? 2 : b.range_m < 4 ? 3 : 5;
            kind += " r" + std::to_string(rb) + (std::abs(c) > 0.6 ? " steep" : " graze");
            auto& s = stat[kind];
            s[0]++;
            s[1] += off;
            s[2] += off * off;
            s[3] += patch->sigma_m[0];
          }
        }
      std::cout << "noise " << noise << " res " << res << "\n";
      for (auto& [k, s] : stat)
        if (s[0] > 30)
          std::cout << "   " << k << " n " << s[0] << " mean " << 1e3 * s[1] / s[0] << " mm, sd "
                    << 1e3 * std::sqrt(s[2] / s[0] - s[1] / s[0] * s[1] / s[0]) << " patch sigma "
                    << 1e3 * s[3] / s[0] << "\n";
    }
}
