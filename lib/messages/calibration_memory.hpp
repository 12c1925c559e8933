// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/rig_calibration_t.hpp>
#include <cstdint>
#include <map>
#include <vector>

#include "camera/rig_calibration.hpp"
#include "core/result.hpp"
#include "core/state_folder.hpp"
#include "messages/calibration_messages.hpp"

namespace cairn::messages {

/// The calibrations that a process has heard of, by id. The newest is kept in the state folder, so
/// that a restarted process need not wait a second for the next CALIBRATION: frames name the
/// calibration that they were taken with, so an old one is never mistaken for a new one.
class CalibrationMemory {
 public:
  explicit CalibrationMemory(const StateFolder& state) : state_{state} {
    const auto bytes = state.load(kName);
    rig_calibration_t message{};
    if (!bytes || message.decode(bytes->data(), 0, static_cast<int>(bytes->size())) < 0) return;
    if (auto rig = to_rig(message)) rigs_.insert_or_assign(rig->id, std::move(*rig));
  }

  /// Keeps it; refuses what to_rig refuses.
  [[nodiscard]] Result<void> put(const rig_calibration_t& message) {
    auto rig = to_rig(message);
    if (!rig) return tl::make_unexpected(rig.error());
    const auto [known, fresh] = rigs_.try_emplace(rig->id, *rig);
    if (!fresh) return {};
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    return state_.save(kName, bytes);
  }

  /// The rig of this id, or null.
  [[nodiscard]] const camera::RigCalibration* find(std::int64_t calibration_id) const {
    const auto found = rigs_.find(static_cast<std::uint64_t>(calibration_id));
    return found == rigs_.end() ? nullptr : &found->second;
  }

 private:
  static constexpr const char* kName = "calibration";
  StateFolder state_;
  std::map<std::uint64_t, camera::RigCalibration> rigs_;
};

}  // namespace cairn::messages
