// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "core/result.hpp"
#include "motor/byte_link.hpp"

struct sp_port;

namespace cairn::motor {

/// A serial line by libserialport: 8 data bits, no parity, one stop bit, no flow control. It is
/// ours alone while it is open.
class SerialLink : public ByteLink {
 public:
  /// `device` is a serial port (`/dev/ttyUSB0`, a link in `/dev/serial/by-id`) or a symbolic link
  /// to a pseudo-terminal. What had come before is thrown away. The error names the device, what is
  /// wrong (no such device, no right, no serial device, in use) and what to do.
  [[nodiscard]] static Result<std::unique_ptr<SerialLink>> open(const std::filesystem::path& device,
                                                                int baud);

  SerialLink(const SerialLink&) = delete;
  SerialLink& operator=(const SerialLink&) = delete;
  ~SerialLink() override;

  [[nodiscard]] Result<std::vector<std::uint8_t>> read() override;
  [[nodiscard]] Result<void> write(std::span<const std::uint8_t> bytes) override;

 private:
  SerialLink(std::filesystem::path device, sp_port* port)
      : device_{std::move(device)}, port_{port} {}
  [[nodiscard]] Result<void> set_up(int baud);
  [[nodiscard]] Result<void> still_there() const;

  std::filesystem::path device_;
  sp_port* port_;
};

}  // namespace cairn::motor
