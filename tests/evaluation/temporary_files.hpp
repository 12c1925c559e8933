// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "temporary_folder.hpp"

namespace cairn::evaluation {

/// A fixture with a folder of its own, gone after the test.
class TemporaryFiles : public ::testing::Test {
 private:
  cairn::testing::TemporaryFolder own_;

 protected:
  /// A new file each time: some file systems wait for the disk when an old one is overwritten.
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::filesystem::remove(folder_ / name);
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }

  const std::filesystem::path folder_ = own_.path();
};

}  // namespace cairn::evaluation
