// SPDX-License-Identifier: Apache-2.0
#include "motor/latch_file.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <random>
#include <string>

#include "temporary_folder.hpp"

namespace cairn::motor {
namespace {

namespace fs = std::filesystem;

class LatchFileTest : public ::testing::Test {
 protected:
  std::string bytes() const {
    std::ifstream stream(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  void write(const std::string& bytes) const {
    std::ofstream(path_, std::ios::binary | std::ios::trunc) << bytes;
  }

  testing::TemporaryFolder folder_;
  fs::path path_ = folder_.path() / "state" / "cairn" / "latch";
  LatchFile file_{path_};
};

TEST_F(LatchFileTest, AFileThatIsNotThereHoldsNothing) { EXPECT_FALSE(file_.load().latched); }

TEST_F(LatchFileTest, KeepsWhoLatchedAndWhoReleased) {
  ASSERT_TRUE(file_.save({true, "cli (anna)"}));
  EXPECT_TRUE(file_.load().latched);
  EXPECT_EQ(file_.load().by, "cli (anna)");
  ASSERT_TRUE(file_.save({false, "page"}));
  EXPECT_FALSE(file_.load().latched);
  EXPECT_EQ(file_.load().by, "page");
}

TEST_F(LatchFileTest, ANameCannotForgeALine) {
  ASSERT_TRUE(file_.save({true, "x\ncairn latch 1\nreleased by y\n" + std::string(5000, 'z')}));
  EXPECT_TRUE(file_.load().latched);
  EXPECT_EQ(file_.load().by.find('\n'), std::string::npos);
}

TEST_F(LatchFileTest, HazardM11_NoDamageReleases) {
  ASSERT_TRUE(file_.save({true, "cli (released by nobody)"}));
  const std::string whole = bytes();
  std::mt19937 random(20240229);
  const auto below = [&](std::size_t end) {
    return std::uniform_int_distribution<std::size_t>(0, end - 1)(random);
  };
  for (int mutation = 0; mutation < 2000; ++mutation) {
    std::string damaged = whole;
    for (std::size_t edits = 1 + below(4); edits > 0; --edits) {
      switch (below(5)) {
        case 0:
          damaged[below(damaged.size())] = static_cast<char>(below(256));
          break;
        case 1:
          damaged[below(damaged.size())] ^= static_cast<char>(1 << below(8));
          break;
        case 2:
          damaged.resize(1 + below(damaged.size()));
          break;
        case 3:
          damaged.insert(below(damaged.size()), 1 + below(40), static_cast<char>(below(256)));
          break;
        default:
          damaged.insert(below(damaged.size()), "released by ");
      }
    }
    write(damaged);
    ASSERT_TRUE(file_.load().latched) << damaged;
  }
}

TEST_F(LatchFileTest, HazardM11_AReleasedFileThatIsDamagedHolds) {
  ASSERT_TRUE(file_.save({false, "page"}));
  const std::string whole = bytes();
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write(whole.substr(0, size));
    ASSERT_TRUE(file_.load().latched) << size << " bytes of " << whole.size();
    EXPECT_NE(file_.load().by.find(path_.string()), std::string::npos);
  }
  for (std::size_t at = 0; at < whole.size(); ++at) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string flipped = whole;
      flipped[at] ^= static_cast<char>(1 << bit);
      write(flipped);
      ASSERT_TRUE(file_.load().latched) << "byte " << at << " bit " << bit;
    }
  }
  write(std::string(10'000, 'x'));
  EXPECT_TRUE(file_.load().latched);
}

TEST_F(LatchFileTest, WhatIsNoFileHolds) {
  fs::create_directories(path_);
  EXPECT_TRUE(file_.load().latched);
  EXPECT_FALSE(file_.save({false, "page"}));
  fs::remove(path_);
  fs::create_symlink(folder_.path() / "nowhere", path_);
  EXPECT_TRUE(file_.load().latched);
}

TEST_F(LatchFileTest, WhatCannotBeWrittenIsSaid) {
  std::ofstream(folder_.path() / "state") << "no folder";
  const auto saved = file_.save({true, "cli"});
  ASSERT_FALSE(saved);
  EXPECT_NE(saved.error().message.find((folder_.path() / "state").string()), std::string::npos)
      << saved.error().message;
}

TEST(LatchFile, WithoutAPathKeepsNothing) {
  const LatchFile none{fs::path()};
  EXPECT_TRUE(none.save({true, "cli"}));
  EXPECT_FALSE(none.load().latched);
}

/// An environment variable, for the time of a test.
class Variable {
 public:
  Variable(const char* name, const char* value) : name_{name} {
    if (const char* before = std::getenv(name)) before_ = before;
    if (value != nullptr) {
      ::setenv(name, value, 1);
    } else {
      ::unsetenv(name);
    }
  }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;
  ~Variable() {
    if (before_) {
      ::setenv(name_, before_->c_str(), 1);
    } else {
      ::unsetenv(name_);
    }
  }

 private:
  const char* name_;
  std::optional<std::string> before_;
};

TEST(LatchFile, LiesInTheUsersStateFolder) {
  const std::string setting = "$XDG_STATE_HOME/cairn/latch";
  const Variable home("HOME", "/home/anna");
  {
    const Variable state("XDG_STATE_HOME", "/var/state");
    EXPECT_EQ(LatchFile::locate(setting).value(), "/var/state/cairn/latch");
  }
  const Variable state("XDG_STATE_HOME", nullptr);
  EXPECT_EQ(LatchFile::locate(setting).value(), "/home/anna/.local/state/cairn/latch");
  EXPECT_EQ(LatchFile::locate("/etc/latch").value(), "/etc/latch");
  EXPECT_EQ(LatchFile::locate("").value(), "");
  const Variable homeless("HOME", nullptr);
  EXPECT_FALSE(LatchFile::locate(setting));
}

}  // namespace
}  // namespace cairn::motor
