// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/options.hpp"

#include <CLI/CLI.hpp>

namespace cairn::spy {
namespace {

constexpr int kExitUsage = 2;

/// Unlike CLI::Range it refuses what is not a number.
std::string in_range(std::string& text) {
  double value = 0;
  const bool good = CLI::detail::lexical_cast(text, value) && value >= 0.01 && value <= 86'400;
  return good ? "" : text + " is not a number of seconds from 0.01 to 86400";
}

}  // namespace

tl::expected<Options, int> parse_options(int argc, char** argv) {
  Options options;
  const CLI::Validator seconds(in_range, "0.01 to 86400");
  CLI::App app{
      "spy: shows what goes over the bus or lies in a recording: every channel's rate, jitter, "
      "bandwidth, loss, latency and sender, how the processes are, and any message's fields",
      "cairn-spy"};
  auto* url = app.add_option("--lcm-url", options.lcm_url,
                             "udpm://GROUP:PORT?ttl=0; default $LCM_DEFAULT_URL, else "
                             "udpm://239.255.76.67:7667?ttl=0");
  auto* log = app.add_option("--log", options.log,
                             "read this recording instead, in its own time, as fast as it goes")
                  ->type_name("LOG")
                  ->excludes(url);
  auto* once = app.add_flag("--once", options.once, "print one report over the whole time and end");
  app.add_option("--seconds", options.seconds, "how long to listen before the report of --once")
      ->check(seconds)
      ->capture_default_str()
      ->needs(once)
      ->excludes(log);
  app.add_flag("--json", options.json,
               "for scripts: one JSON object a report (without --once: one a line, once a second)");
  app.add_option("--channel", options.channel, "show the fields of this channel's newest message")
      ->type_name("NAME");
  app.set_version_flag("--version", std::string("cairn ") + CAIRN_VERSION);
  app.footer(
      "On a terminal: arrow keys choose a channel, enter shows its fields, p stops and starts, q "
      "ends.\n\n"
      "Examples:\n"
      "  cairn-spy\n"
      "  cairn-spy --once --channel POSE\n"
      "  cairn-spy --log logs/run.lcmlog --once --json");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return tl::make_unexpected(app.exit(error) == 0 ? 0 : kExitUsage);
  }
  return options;
}

}  // namespace cairn::spy
