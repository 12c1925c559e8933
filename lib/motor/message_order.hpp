// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "core/time.hpp"
#include "motor/refusal.hpp"

namespace cairn::motor {

/// Who sent a message and when, as its header says.
struct SentStamp {
  HostTime sent_us = 0;
  std::int64_t session = 0;
  std::int32_t sequence = 0;
};

/// Tells new messages of one kind of sender from replayed and outrun ones.
class MessageOrder {
 public:
  /// Good: higher in sequence than the last one of its session and not sent before it, or of a
  /// session that is new and sent after the last one of the old.
  [[nodiscard]] Verdict take(const SentStamp& stamp) {
    if (any_ && stamp.session == last_.session) {
      if (stamp.sequence <= last_.sequence)
        return refuse("replayed", "header.sequence: " + std::to_string(stamp.sequence) + " after " +
                                      std::to_string(last_.sequence));
      if (stamp.sent_us < last_.sent_us)
        return refuse("replayed", "header.sent_steady_us: sent before the one before it");
    } else if (any_ && stamp.sent_us <= last_.sent_us) {
      return refuse("replayed", "header.session: of a sender that was replaced since");
    }
    any_ = true;
    last_ = stamp;
    return {};
  }

 private:
  bool any_ = false;
  SentStamp last_;
};

}  // namespace cairn::motor
