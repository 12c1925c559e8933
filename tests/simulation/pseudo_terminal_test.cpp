// SPDX-License-Identifier: Apache-2.0
#include "simulation/pseudo_terminal.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <string>

#include "temporary_folder.hpp"

namespace cairn::simulation {
namespace {

namespace fs = std::filesystem;

/// Reads until there are as many bytes as wanted, for at most 5 s.
template <class Read>
std::string read_at_least(std::size_t count, Read&& read_some) {
  std::string all;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  while (all.size() < count && std::chrono::steady_clock::now() < end) all += read_some();
  return all;
}

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

class PseudoTerminalTest : public ::testing::Test {
 protected:
  cairn::testing::TemporaryFolder folder_;
  fs::path link_ = folder_.path() / "run" / "wheels";
};

TEST_F(PseudoTerminalTest, CarriesEveryByteBothWaysAndClosesAndOpensAgain) {
  auto terminal = PseudoTerminal::open(link_);
  ASSERT_TRUE(terminal) << terminal.error().message;
  ASSERT_TRUE(fs::is_symlink(link_));
  std::string all_bytes;
  for (int byte = 0; byte < 256; ++byte) all_bytes += static_cast<char>(byte);
  for (int time = 0; time < 2; ++time) {
    const int host = ::open(link_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    ASSERT_GE(host, 0);
    ASSERT_EQ(::write(host, all_bytes.data(), all_bytes.size()), 256);
    EXPECT_EQ(read_at_least(256,
                            [&] {
                              const auto got = (*terminal)->read().value();
                              return std::string(got.begin(), got.end());
                            }),
              all_bytes);
    ASSERT_TRUE((*terminal)->write(bytes_of(all_bytes)));
    EXPECT_EQ(read_at_least(256,
                            [&] {
                              char portion[256];
                              const ssize_t got = ::read(host, portion, sizeof portion);
                              return std::string(portion,
                                                 got > 0 ? static_cast<std::size_t>(got) : 0);
                            }),
              all_bytes);
    ::close(host);
    EXPECT_TRUE((*terminal)->read());
  }
}

TEST_F(PseudoTerminalTest, SaysSoWhenNobodyReads) {
  auto terminal = PseudoTerminal::open(link_).value();
  bool full = false;
  for (int i = 0; i < 10'000 && !full; ++i) full = !terminal->write(bytes_of(std::string(40, 'x')));
  EXPECT_TRUE(full);
}

TEST_F(PseudoTerminalTest, TheLinkGoesWithIt) {
  PseudoTerminal::open(link_).value().reset();
  EXPECT_FALSE(fs::exists(fs::symlink_status(link_)));
}

TEST_F(PseudoTerminalTest, ANewerOneTakesTheLinkAndKeepsIt) {
  auto older = PseudoTerminal::open(link_).value();
  auto newer = PseudoTerminal::open(link_).value();
  older.reset();
  EXPECT_TRUE(fs::exists(link_));
  newer.reset();
  EXPECT_FALSE(fs::exists(fs::symlink_status(link_)));
}

TEST_F(PseudoTerminalTest, TakesNobodysFile) {
  fs::create_directories(link_.parent_path());
  std::ofstream(link_) << "mine";
  const auto terminal = PseudoTerminal::open(link_);
  ASSERT_FALSE(terminal);
  EXPECT_NE(terminal.error().message.find(link_.string()), std::string::npos);
  EXPECT_TRUE(fs::is_regular_file(link_));
}

}  // namespace
}  // namespace cairn::simulation
