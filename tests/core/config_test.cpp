// SPDX-License-Identifier: Apache-2.0
#include "core/config.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>

namespace cairn {
namespace {

struct Inner {
  double speed_mps = 0.3;
  void visit(ConfigVisitor& v) { v.number("speed_mps", speed_mps, {0, 2}, "m/s", "how fast"); }
};

struct Outer {
  int count = 4;
  bool on = true;
  std::string name = "a: \"b\"";
  std::string kind = "dry";
  std::vector<double> xyz_m = {1, 2, 3};
  std::vector<std::string> words = {"one", "two: 3"};
  Inner inner;
  std::vector<Inner> steps;

  void visit(ConfigVisitor& v) {
    v.integer("count", count, 1, 9, "", "how many");
    v.flag("on", on, "whether");
    v.text("name", name, "who");
    v.choice("kind", kind, {"dry", "wet"}, "which");
    v.numbers("xyz_m", xyz_m, 3, 3, {}, "m", "where");
    v.texts("words", words, "what is said");
    v.group("inner", inner, "the inside");
    v.list("steps", steps, "one after the other");
  }
};

constexpr std::array<std::string_view, 2> kSections{"mapper", "stereo"};

class Config : public ::testing::Test {
 protected:
  void SetUp() override {
    file_ = std::filesystem::temp_directory_path() /
            ("cairn-config-" + std::to_string(::getpid()) + "-" +
             ::testing::UnitTest::GetInstance()->current_test_info()->name() + ".yaml");
  }
  void TearDown() override { std::filesystem::remove(file_); }

  Result<Outer> load(const std::string& yaml, std::vector<std::string> overrides = {}) {
    std::ofstream(file_) << yaml;
    return load_config<Outer>({file_, std::move(overrides)}, "mapper", kSections);
  }
  std::string error(const std::string& yaml, std::vector<std::string> overrides = {}) {
    const auto loaded = load(yaml, std::move(overrides));
    return loaded ? "" : loaded.error().message;
  }
  std::string at(int line) const { return file_.string() + ":" + std::to_string(line) + ": "; }

  std::filesystem::path file_;
};

TEST_F(Config, TakesWhatTheFileSaysAndKeepsTheOtherDefaults) {
  const auto loaded =
      load("mapper:\n  count: 7\n  inner: {speed_mps: 1.5}\n  steps: [{speed_mps: 1}, {}]\n");
  ASSERT_TRUE(loaded);
  EXPECT_EQ(loaded->count, 7);
  EXPECT_EQ(loaded->inner.speed_mps, 1.5);
  EXPECT_TRUE(loaded->on);
  ASSERT_EQ(loaded->steps.size(), 2U);
  EXPECT_EQ(loaded->steps[0].speed_mps, 1.0);
  EXPECT_EQ(loaded->steps[1].speed_mps, 0.3);
}

TEST_F(Config, AMisspeltKeyNamesFileLineAndTheLikelyKey) {
  EXPECT_EQ(error("mapper:\n  on: true\n  cuont: 7\n"),
            at(3) + "mapper.cuont: unknown key (did you mean 'count'?)");
}

TEST_F(Config, AMisspeltSectionIsNotPassedOver) {
  EXPECT_EQ(error("maper:\n  count: 7\n"),
            at(1) + "maper: unknown section (did you mean 'mapper'?)");
}

TEST_F(Config, AGroupThatTheSectionLacksIsTakenFromTheSectionOfItsName) {
  const std::array<std::string_view, 2> sections{"mapper", "inner"};
  const auto write_and_load = [&](const std::string& text) {
    std::ofstream(file_) << text;
    return load_config<Outer>({file_, {}}, "mapper", sections);
  };
  const auto shared = write_and_load("inner: {speed_mps: 1.5}\n");
  ASSERT_TRUE(shared) << shared.error().message;
  EXPECT_EQ(shared->inner.speed_mps, 1.5);
  const auto own = write_and_load("inner: {speed_mps: 1.5}\nmapper: {inner: {speed_mps: 0.5}}\n");
  ASSERT_TRUE(own) << own.error().message;
  EXPECT_EQ(own->inner.speed_mps, 0.5);
  const auto wrong = write_and_load("inner:\n  sped_mps: 1.5\n");
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().message,
            at(2) + "inner.sped_mps: unknown key (did you mean 'speed_mps'?)");
}

TEST_F(Config, OutOfRangeSaysTheRangeAndTheUnit) {
  EXPECT_EQ(error("mapper:\n  inner:\n    speed_mps: 60\n"),
            at(3) + "mapper.inner.speed_mps: 60 is out of range (allowed: 0 to 2 m/s)");
}

TEST_F(Config, WrongTypesAreEachNamed) {
  EXPECT_EQ(error("mapper:\n  count: many\n"),
            at(2) + "mapper.count: is not a whole number (allowed: 1 to 9)");
  EXPECT_EQ(error("mapper:\n  on: yes\n"), at(2) + "mapper.on: is not true or false");
  EXPECT_EQ(error("mapper:\n  kind: moist\n"),
            at(2) + "mapper.kind: 'moist' is not known (allowed: dry, wet)");
  EXPECT_EQ(error("mapper:\n  xyz_m: [1, 2]\n"),
            at(2) + "mapper.xyz_m: is not a list of 3 numbers (allowed: any number m)");
  EXPECT_EQ(error("mapper:\n  words: one\n"), at(2) + "mapper.words: is not a list of texts");
  EXPECT_EQ(error("mapper:\n  words: [one, [two]]\n"),
            at(2) + "mapper.words: holds an entry that is not a text");
  EXPECT_NE(error("mapper:\n  inner: {speed_mps: nan}\n"), "");
  EXPECT_NE(error("mapper:\n  inner: {speed_mps: .inf}\n"), "");
}

TEST_F(Config, ARepeatedKeyIsAnError) {
  EXPECT_EQ(error("mapper:\n  count: 1\n  count: 2\n"), at(3) + "mapper.count: stands here twice");
}

TEST_F(Config, AllErrorsAreReportedAtOnce) {
  const std::string text = error("mapper:\n  count: 0\n  on: 3\n");
  EXPECT_NE(text.find(at(2)), std::string::npos);
  EXPECT_NE(text.find(at(3)), std::string::npos);
}

TEST_F(Config, BrokenYamlNamesTheLine) {
  EXPECT_NE(error("mapper:\n  count: [1\n").find(file_.string() + ":"), std::string::npos);
}

TEST_F(Config, OverridesWinAndAreCheckedToo) {
  EXPECT_EQ(load("mapper: {count: 2}\n", {"count=3", "inner.speed_mps=0.5"})->count, 3);
  EXPECT_EQ(error("mapper: {}\n", {"inner.speed=1"}),
            "--set inner.speed=1: inner.speed: unknown key (did you mean 'speed_mps'?)");
  EXPECT_EQ(error("mapper: {}\n", {"count"}), "--set count: is not of the form key=value");
}

TEST_F(Config, AMissingFileIsNamed) {
  const auto loaded = load_config<Outer>({"/nowhere/robot.yaml", {}}, "mapper", kSections);
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().message, "/nowhere/robot.yaml: no such file");
}

TEST_F(Config, WhatIsPrintedLoadsBackTheSame) {
  Outer before;
  before.count = 8;
  before.inner.speed_mps = 0.1;
  before.steps.resize(2);
  before.words = {"", "a=\"b\"", "# c"};
  const std::string printed = print_config("mapper", [&](ConfigVisitor& v) { before.visit(v); });
  const auto after = load(printed);
  ASSERT_TRUE(after) << after.error().message << "\n" << printed;
  EXPECT_EQ(after->count, 8);
  EXPECT_EQ(after->name, before.name);
  EXPECT_EQ(after->inner.speed_mps, 0.1);
  EXPECT_EQ(after->steps.size(), 2U);
  EXPECT_EQ(after->words, before.words);
}

}  // namespace
}  // namespace cairn
