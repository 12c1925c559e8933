// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/modes.hpp"

#include <unistd.h>

#include <cstdio>
#include <iostream>

#include "bus/stop_signal.hpp"
#include "core/time.hpp"
#include "procs/spy/embedded_types.hpp"
#include "procs/spy/feed.hpp"
#include "procs/spy/report.hpp"
#include "procs/spy/terminal.hpp"
#include "procs/spy/view.hpp"

namespace cairn::spy {
namespace {

constexpr int kRedrawPeriod_ms = 100;
constexpr std::int64_t kProgressPeriod_us = 200'000;

Result<std::unique_ptr<Feed>> open_feed(const Schema& schema, const Options& options,
                                        PaceWindow window) {
  if (!options.log.empty()) {
    auto reader = bus::RecordingReader::open(options.log);
    if (!reader) return tl::make_unexpected(reader.error());
    return std::make_unique<RecordedFeed>(schema, std::move(*reader), window);
  }
  if (options.lcm_url.starts_with("file:"))
    return fail(options.lcm_url + ": a recording is read with --log");
  auto opened = bus::open_bus(options.lcm_url);
  if (!opened) return tl::make_unexpected(opened.error());
  if (auto subscribed = (*opened)->subscribe(bus::kAllChannels); !subscribed)
    return tl::make_unexpected(subscribed.error());
  return std::make_unique<LiveFeed>(schema, std::move(*opened), window);
}

void print(const Schema& schema, const Options& options, const Snapshot& snapshot) {
  std::cout << (options.json ? json_report(schema, options, snapshot)
                             : text_report(schema, options, snapshot))
            << std::flush;
  if (const std::string text = hint(options, snapshot); !text.empty()) std::cerr << text << "\n";
}

/// Waits for the end of a recording and shows how far it is; false when told to stop.
bool wait_for_end(Feed& feed, bus::StopSignal& stop) {
  const bool on_terminal = ::isatty(STDERR_FILENO) != 0;
  std::int64_t waited_us = 0;
  while (!feed.ended()) {
    if (stop.arrived(waited_us == 0 ? kProgressPeriod_us / 10 : kProgressPeriod_us)) return false;
    waited_us += kProgressPeriod_us;
    if (on_terminal && waited_us > kMicrosecondsPerSecond)
      std::fprintf(stderr, "\rreading %3.0f %%", 100 * feed.snapshot().progress);
  }
  if (on_terminal && waited_us > kMicrosecondsPerSecond) std::fprintf(stderr, "\r\033[K");
  return true;
}

int report_once(const Schema& schema, const Options& options, Feed& feed, bus::StopSignal& stop) {
  if (options.log.empty()) {
    (void)stop.arrived(static_cast<std::int64_t>(options.seconds * 1e6));
  } else if (!wait_for_end(feed, stop)) {
    return 1;
  }
  print(schema, options, feed.snapshot());
  return 0;
}

int report_every_second(const Schema& schema, const Options& options, Feed& feed,
                        bus::StopSignal& stop) {
  while (!stop.arrived(kMicrosecondsPerSecond)) {
    print(schema, options, feed.snapshot());
    if (!options.json) std::cout << "\n";
  }
  return 0;
}

int show(const Schema& schema, const Options& options, Feed& feed, bus::StopSignal& stop,
         Terminal& terminal) {
  View view(schema, source_of(options), options.channel);
  Snapshot snapshot;
  while (!view.quit() && !stop.arrived()) {
    if (!options.log.empty() && feed.ended()) view.set_paused(true);
    if (!view.paused() || !options.log.empty()) snapshot = feed.snapshot();
    terminal.paint(view.draw(snapshot, terminal.size()));
    const Key key = terminal.key(kRedrawPeriod_ms);
    view.press(key);
    if (key == Key::kPause) feed.set_running(!view.paused());
  }
  return 0;
}

}  // namespace

int run(const Options& options) {
  bus::StopSignal stop;
  const auto schema = Schema::parse(embedded_files());
  if (!schema) {
    std::cerr << schema.error().message << "\n";
    return 1;
  }
  const bool recorded = !options.log.empty();
  const bool on_terminal = ::isatty(STDIN_FILENO) != 0 && ::isatty(STDOUT_FILENO) != 0;
  const bool one_report = options.once || (recorded && (options.json || !on_terminal));
  const auto feed =
      open_feed(*schema, options, one_report ? PaceWindow::kWhole : PaceWindow::kNewest);
  if (!feed) {
    std::cerr << feed.error().message << "\n";
    return 1;
  }
  if (one_report) return report_once(*schema, options, **feed, stop);
  if (options.json || !on_terminal) return report_every_second(*schema, options, **feed, stop);
  const auto terminal = Terminal::open();
  if (!terminal) {
    std::cerr << terminal.error().message << "; showing a plain table\n";
    return report_every_second(*schema, options, **feed, stop);
  }
  return show(*schema, options, **feed, stop, **terminal);
}

}  // namespace cairn::spy
