// SPDX-License-Identifier: Apache-2.0
#include "simulation/playground.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "scenes.hpp"
#include "simulation/person_look.hpp"

namespace cairn::simulation {
namespace {

const RobotConfig kRobot;
/// What a number of contacts may leave inside of each other by rounding.
constexpr double kRounding_m = 1e-6;

/// True if the point is deeper in the box than rounding explains.
bool deep_in(const Isometry& T_world_box, const Eigen::Vector3d& half_m,
             const Eigen::Vector3d& point) {
  const Eigen::Vector3d inside = T_world_box.inverse() * point;
  return ((half_m - inside.cwiseAbs()).array() > kRounding_m).all();
}

/// Points all over a box, at most 2 cm apart on its edges and faces.
template <class Look>
void for_each_point(const Isometry& T_world_box, const Eigen::Vector3d& half_m, Look&& look) {
  constexpr double kApart_m = 0.02;
  const Eigen::Array3i count = (2 * half_m.array() / kApart_m).ceil().cast<int>() + 1;
  for (int i = 0; i < count.x(); ++i) {
    for (int j = 0; j < count.y(); ++j) {
      for (int k = 0; k < count.z(); ++k) {
        const bool outer = i == 0 || j == 0 || k == 0 || i == count.x() - 1 || j == count.y() - 1 ||
                           k == count.z() - 1;
        if (!outer) continue;
        const Eigen::Array3d share = Eigen::Array3d(i, j, k) / (count - 1).cast<double>().max(1.0);
        look(T_world_box * Eigen::Vector3d(half_m.array() * (2 * share - 1)));
      }
    }
  }
}

/// What the robot's body is in, by points of the one and of the other: nothing about separating
/// axes. The body is its box over what tracks climb.
std::string what_it_is_in(const World& world, const Playground& ground) {
  const Isometry& T_world_body = ground.body().T_world_body();
  const double height_m = kRobot.height_m - kClimb_m;
  const Eigen::Vector3d half_m(0.5 * kRobot.length_m, 0.5 * kRobot.width_m, 0.5 * height_m);
  const Isometry T_world_middle =
      T_world_body * Eigen::Translation3d(0, 0, kClimb_m + 0.5 * height_m);
  std::string in;
  for (const Box& box : world.boxes) {
    const double apart_m = (box.T_world_box.inverse() * T_world_middle.translation())
                               .cwiseAbs()
                               .cwiseMax(box.half_size_m)
                               .
                               operator-(box.half_size_m)
                               .norm();
    if (apart_m > half_m.norm()) continue;
    for_each_point(T_world_middle, half_m, [&](const Eigen::Vector3d& point) {
      if (deep_in(box.T_world_box, box.half_size_m, point)) in = box.name;
    });
    if (box.half_size_m.maxCoeff() > 1) continue;  // too big to be inside the body
    for_each_point(box.T_world_box, box.half_size_m, [&](const Eigen::Vector3d& point) {
      if (deep_in(T_world_middle, half_m, point)) in = box.name;
    });
  }
  for (const PersonPose& pose : ground.people()) {
    const Person& person = world.people[pose.person];
    for (const Box& part : person_boxes(person, pose)) {
      for_each_point(T_world_middle, half_m, [&](const Eigen::Vector3d& point) {
        if (deep_in(part.T_world_box, part.half_size_m, point)) in = person.name;
      });
      for_each_point(part.T_world_box, part.half_size_m, [&](const Eigen::Vector3d& point) {
        if (deep_in(T_world_middle, half_m, point)) in = person.name;
      });
    }
  }
  return in;
}

/// Duties as a careless driver gives them: now and then others, often full ahead.
class CarelessDriver {
 public:
  explicit CarelessDriver(unsigned seed) : random_{seed} {}

  void drive(Playground& ground) {
    if (left_for_ == 0) {
      std::uniform_real_distribution<double> duty(-0.7, 0.9);
      left_ = duty(random_);
      right_ = random_() % 3 == 0 ? left_ : duty(random_);
      left_for_ = 20 + static_cast<int>(random_() % 300);
    }
    --left_for_;
    ground.step(left_, right_);
  }

 private:
  std::mt19937 random_;
  double left_ = 0;
  double right_ = 0;
  int left_for_ = 0;
};

class PlaygroundOf : public testing::TestWithParam<const char*> {};

TEST_P(PlaygroundOf, NeverHasTheRobotInsideOfAnything) {
  const auto world = std::make_shared<const World>(load_world(world_file(GetParam())).value());
  std::int64_t collisions = 0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    auto ground = Playground::create(world, kRobot, {}, world->people.size(), seed);
    ASSERT_TRUE(ground) << ground.error().message;
    CarelessDriver driver(seed);
    for (int step = 0; step < 24'000; ++step) {
      driver.drive(*ground);
      if (step % 10 != 0) continue;
      ASSERT_EQ(what_it_is_in(*world, *ground), "") << "seed " << seed << ", step " << step;
    }
    collisions += ground->body().collisions();
  }
  EXPECT_GT(collisions, 5);
}

INSTANTIATE_TEST_SUITE_P(Worlds, PlaygroundOf,
                         testing::Values("room", "apartment", "office", "hand-drawn", "plain",
                                         "symmetric-room"),
                         [](const auto& world) {
                           std::string name = world.param;
                           std::erase(name, '-');
                           return name;
                         });

TEST(Playground, IsTheSameForTheSameSeed) {
  const auto world = std::make_shared<const World>(load_world(world_file("apartment")).value());
  auto one = Playground::create(world, kRobot, {}, 2, 5).value();
  auto same = Playground::create(world, kRobot, {}, 2, 5).value();
  CarelessDriver driver_of_one(1);
  CarelessDriver driver_of_same(1);
  for (int step = 0; step < 12'000; ++step) {
    driver_of_one.drive(one);
    driver_of_same.drive(same);
    ASSERT_EQ(one.body().T_world_body().matrix(), same.body().T_world_body().matrix());
    for (std::size_t i = 0; i < 2; ++i) ASSERT_EQ(one.people()[i].at_m, same.people()[i].at_m);
  }
  EXPECT_EQ(one.body().collisions(), same.body().collisions());
}

TEST(Playground, PeopleDoNotTouchARobotThatStands) {
  for (const char* name : {"room", "apartment"}) {
    const auto world = std::make_shared<const World>(load_world(world_file(name)).value());
    auto ground = Playground::create(world, kRobot, {}, 2, 9);
    ASSERT_TRUE(ground) << ground.error().message;
    for (int step = 0; step < 60'000; ++step) {
      ground->step(0, 0);
      ASSERT_EQ(ground->body().contacts(), 0) << step;
    }
  }
}

TEST(Playground, HasNoMorePeopleThanTheWorld) {
  const auto world = std::make_shared<const World>(load_world(room_file()).value());
  const auto crowd = Playground::create(world, kRobot, {}, 50, 1);
  ASSERT_FALSE(crowd);
  EXPECT_NE(crowd.error().message.find("50"), std::string::npos);
}

}  // namespace
}  // namespace cairn::simulation
