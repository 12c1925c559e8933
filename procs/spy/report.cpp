// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/report.hpp"

#include <cstdlib>

#include "bus/udp_url.hpp"
#include "procs/spy/field_lines.hpp"
#include "procs/spy/printable.hpp"
#include "procs/spy/summary_json.hpp"
#include "procs/spy/summary_text.hpp"

namespace cairn::spy {
namespace {

Json message_json(const Schema& schema, const Options& options, const Snapshot& snapshot) {
  const auto newest = snapshot.newest.find(options.channel);
  if (newest == snapshot.newest.end()) return nullptr;
  auto fields = read_message(schema, *newest->second.type, *newest->second.bytes);
  if (!fields) return nullptr;
  return {{"channel", options.channel},
          {"type", newest->second.type->name},
          {"fields", std::move(*fields)}};
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::string message_text(const Schema& schema, const Options& options, const Snapshot& snapshot) {
  const auto newest = snapshot.newest.find(options.channel);
  if (newest == snapshot.newest.end()) return "";
  const MessageType& type = *newest->second.type;
  const auto fields = read_message(schema, type, *newest->second.bytes);
  if (!fields) return "";
  return printable(options.channel) + " (" + type.name + ")\n" +
         joined(field_lines(schema, type, *fields));
}

}  // namespace

std::string source_of(const Options& options) {
  if (!options.log.empty()) return printable(options.log);
  if (!options.lcm_url.empty()) return printable(options.lcm_url);
  const char* from_environment = std::getenv("LCM_DEFAULT_URL");
  return from_environment != nullptr ? printable(from_environment) : bus::UdpUrl{}.text();
}

std::string json_report(const Schema& schema, const Options& options, const Snapshot& snapshot) {
  Json report{{"source", source_of(options)}, {"live", options.log.empty()}, {"damage", nullptr}};
  if (snapshot.damage)
    report["damage"] = {{"places", snapshot.damage->places}, {"bytes", snapshot.damage->bytes}};
  report.update(to_json(snapshot.traffic));
  if (!options.channel.empty()) report["message"] = message_json(schema, options, snapshot);
  return report.dump(options.once ? 2 : -1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string text_report(const Schema& schema, const Options& options, const Snapshot& snapshot) {
  if (!options.channel.empty()) return message_text(schema, options, snapshot);
  std::string text = headline(snapshot.traffic) + "\n";
  if (snapshot.damage && !snapshot.damage->text.empty())
    text += printable(snapshot.damage->text) + "\n";
  if (!snapshot.traffic.channels.empty())
    text += "\n" + joined(channel_table(snapshot.traffic).lines());
  if (!snapshot.traffic.processes.empty())
    text += "\n" + joined(process_table(snapshot.traffic).lines());
  const std::string problems = joined(problem_lines(snapshot.traffic));
  if (!problems.empty()) text += "\nundecodable:\n" + problems;
  return text;
}

std::string hint(const Options& options, const Snapshot& snapshot) {
  if (snapshot.traffic.messages == 0) {
    return "nothing heard on " + source_of(options) +
           "; is a process group running, and with the same --lcm-url?";
  }
  if (!options.channel.empty() && !snapshot.newest.contains(options.channel))
    return "no whole message heard on channel " + printable(options.channel);
  return "";
}

}  // namespace cairn::spy
