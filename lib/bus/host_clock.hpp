// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/time.hpp"

namespace cairn::bus {

/// Host time: monotonic, never stepped. Given to whoever needs it, so that tests and lockstep bring
/// their own.
class HostClock {
 public:
  virtual ~HostClock() = default;
  [[nodiscard]] virtual HostTime now_us() const = 0;
};

/// The machine's monotonic clock; the same for all processes since boot.
class SteadyClock : public HostClock {
 public:
  [[nodiscard]] HostTime now_us() const override;
};

/// A clock that stands still until it is set.
class ManualClock : public HostClock {
 public:
  [[nodiscard]] HostTime now_us() const override { return now_us_; }
  void set(HostTime now_us) { now_us_ = now_us; }

 private:
  HostTime now_us_ = 0;
};

}  // namespace cairn::bus
