// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace cairn {

/// Why something could not be done, in words that name the file, line, field or message.
struct Error {
  std::string message;
};

/// A value, or the reason why there is none. Bad input is a Result, never an exception across a
/// module's door.
template <class T>
using Result = tl::expected<T, Error>;

[[nodiscard]] inline tl::unexpected<Error> fail(std::string message) {
  return tl::make_unexpected(Error{std::move(message)});
}

}  // namespace cairn
