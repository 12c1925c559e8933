// SPDX-License-Identifier: Apache-2.0
#include <spdlog/spdlog.h>

#include <cstdlib>

#include "bus/bus.hpp"
#include "bus/recording_bus.hpp"
#include "bus/udp_bus.hpp"

namespace cairn::bus {
namespace {

Result<std::unique_ptr<Bus>> open_file_url(const std::string& url) {
  constexpr std::string_view kScheme = "file://";
  std::string path = url.substr(kScheme.size());
  std::string out;
  if (const std::size_t question = path.find('?'); question != std::string::npos) {
    const std::string option = path.substr(question + 1);
    if (!option.starts_with("out=")) {
      return fail(url + ": unknown option '" + option + "' (known: out=RECORDING)");
    }
    out = option.substr(4);
    path.resize(question);
  }
  return open_recording_bus(path, out);
}

}  // namespace

std::string effective_url(const std::string& url) {
  const char* from_environment = std::getenv("LCM_DEFAULT_URL");
  return !url.empty() ? url : (from_environment != nullptr ? from_environment : UdpUrl{}.text());
}

Result<std::unique_ptr<Bus>> open_bus(const std::string& url) {
  const std::string effective = effective_url(url);
  if (effective.starts_with("file://")) return open_file_url(effective);
  const auto parsed = parse_udp_url(effective);
  if (!parsed) return tl::make_unexpected(parsed.error());
  std::string warning;
  auto bus = open_udp_bus(*parsed, &warning);
  if (!warning.empty()) spdlog::warn("{}", warning);
  return bus;
}

}  // namespace cairn::bus
