// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/catalogue.hpp"

#include <map>

#include "bus/channels.hpp"

namespace cairn::spy {
namespace {

/// From the catalogue's words: "15-30 Hz" and "per frame" are steady; "on demand", "on change" and
/// "20 Hz until latched" are not.
bool is_steady(std::string_view rate) {
  const auto says = [&](std::string_view word) {
    return rate.find(word) != std::string_view::npos;
  };
  return (says("Hz") || says("per frame")) && !says("until") && !says("demand");
}

std::map<std::string, CatalogueEntry, std::less<>> make_catalogue() {
  std::map<std::string, CatalogueEntry, std::less<>> entries;
  bus::for_each_channel([&](auto channel) {
    using Channel = decltype(channel);
    entries[Channel::name] = {Channel::type_name, is_steady(Channel::rate)};
  });
  return entries;
}

}  // namespace

const CatalogueEntry* catalogue_entry(std::string_view channel) {
  static const auto kCatalogue = make_catalogue();
  const auto found = kCatalogue.find(channel);
  return found == kCatalogue.end() ? nullptr : &found->second;
}

}  // namespace cairn::spy
