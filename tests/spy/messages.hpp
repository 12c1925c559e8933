// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "bus/bus.hpp"
#include "bus/channels.hpp"
#include "bus/codec.hpp"
#include "procs/spy/embedded_types.hpp"

namespace cairn::spy {

inline const Schema& schema() {
  static const Schema kSchema = Schema::parse(embedded_files()).value();
  return kSchema;
}

template <class Message>
std::vector<std::uint8_t> bytes_of(const Message& message) {
  return bus::encode(message).value();
}

/// A message of a channel with this header.
template <class Channel>
bus::RawMessage message(std::int64_t session, std::int32_t sequence,
                        std::int64_t sent_steady_us = 0) {
  typename Channel::type message{};
  message.header.session = session;
  message.header.sequence = sequence;
  message.header.sent_steady_us = sent_steady_us;
  return {Channel::name, bytes_of(message)};
}

inline process_status_t process_status(const std::string& process, std::int64_t session) {
  process_status_t status{};
  status.process = process;
  status.header.session = session;
  status.health = process_status_t::HEALTH_OK;
  status.types_hash = bus::types_hash();
  return status;
}

}  // namespace cairn::spy
