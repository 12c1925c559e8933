// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "core/result.hpp"
#include "motor/byte_link.hpp"

namespace cairn::simulation {

/// The wheel controller's side of a serial line that is no hardware: a pseudo-terminal, whose other
/// side a motor process opens by its name as it would a serial port. That side may close and open
/// again at any time. What nobody reads is kept up to what the kernel holds, then `write` says so.
class PseudoTerminal : public motor::ByteLink {
 public:
  /// `link` becomes a symbolic link to the other side, in place of an older one; its folder is made
  /// if it is missing. It is an error if there is anything else of that name.
  [[nodiscard]] static Result<std::unique_ptr<PseudoTerminal>> open(
      const std::filesystem::path& link);

  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;
  /// The link goes with it, unless another has taken its place.
  ~PseudoTerminal() override;

  [[nodiscard]] Result<std::vector<std::uint8_t>> read() override;
  [[nodiscard]] Result<void> write(std::span<const std::uint8_t> bytes) override;

  [[nodiscard]] const std::filesystem::path& link() const { return link_; }

 private:
  PseudoTerminal(int controller_side, int host_side, std::filesystem::path link,
                 std::filesystem::path device);

  int controller_side_;
  int host_side_;  ///< kept open, so that a motor that closes it does not end the line
  std::filesystem::path link_;
  std::filesystem::path device_;
};

}  // namespace cairn::simulation
