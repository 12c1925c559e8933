// SPDX-License-Identifier: Apache-2.0
#include <csignal>
#include <iostream>
#include <memory>
#include <random>

#include "bus/node.hpp"
#include "bus/recording.hpp"
#include "bus/stop_signal.hpp"
#include "procs/cli/command.hpp"

namespace cairn::cli {
namespace {

struct Options {
  std::string out;
  std::string lcm_url;
};

int record(const Options& options) {
  bus::StopSignal stop;
  const auto bus = bus::open_bus(options.lcm_url);
  if (!bus) return failed(bus.error().message);
  auto writer = bus::RecordingWriter::create(options.out);
  if (!writer) return failed(writer.error().message);
  const bus::SteadyClock clock;
  bus::Node node("recorder", **bus, clock, {}, std::random_device{}());
  Result<void> state;
  std::int64_t messages = 0;
  node.on_raw([&](const bus::RawMessage& raw) {
    if (raw.channel == "LCM_SELF_TEST" || !state) return;
    state = writer->write(node.host_time(), raw.channel, raw.bytes);
    messages += state ? 1 : 0;
  });
  if (!node.wiring()) return failed(node.wiring().error().message);
  node.every_host(100'000, [&] {
    if (state) state = writer->flush();
  });
  std::cerr << "recording into " << options.out << "; stop with Ctrl-C\n";
  constexpr std::int64_t kSpin_us = 50'000;
  while (state && !stop.arrived()) node.spin_once(kSpin_us);
  if (state) state = writer->flush();
  if (!state)
    return failed(state.error().message + "; " + std::to_string(messages) +
                  " messages before it are safe");
  std::cerr << messages << " messages recorded\n";
  return 0;
}

}  // namespace

void add_record(CLI::App& app, Run& run) {
  auto options = std::make_shared<Options>();
  CLI::App* command =
      app.add_subcommand("record", "record everything on the bus, as lcm-logger does");
  options->out = "logs/recording.lcmlog";
  command->add_option("--out", options->out, "file; one that exists is not written over")
      ->capture_default_str();
  command->add_option("--lcm-url", options->lcm_url, "bus to listen to");
  command->footer("Example:\n  cairn record --out logs/kitchen.lcmlog");
  command->callback([&run, options] { run = [options] { return record(*options); }; });
}

}  // namespace cairn::cli
