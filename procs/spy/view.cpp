// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/view.hpp"

#include <algorithm>
#include <cstdio>

#include "procs/spy/field_lines.hpp"
#include "procs/spy/printable.hpp"
#include "procs/spy/quantities.hpp"
#include "procs/spy/summary_text.hpp"

namespace cairn::spy {
namespace {

constexpr std::size_t kFewestRowsWithProcesses = 10;
constexpr std::ptrdiff_t kToTheEnd = 1'000'000'000;

Style style_of(const ChannelSummary& channel) {
  if (channel.stale) return Style::kAlarm;
  return channel.lost > 0 || channel.undecodable > 0 ? Style::kWarning : Style::kPlain;
}

Style style_of(const ProcessSummary& process) {
  if (process.health == "ill" || process.health == "silent" || !process.same_types)
    return Style::kAlarm;
  return process.health == "waiting" ? Style::kWarning : Style::kPlain;
}

/// `first` moved as little as it takes for `index` to be among the `count` rows from it on.
std::size_t scrolled_to(std::size_t first, std::size_t index, std::size_t count) {
  if (index < first) return index;
  return index >= first + count ? index - count + 1 : first;
}

std::string sender_line(const SenderSummary& sender) {
  char session[17];
  std::snprintf(session, sizeof(session), "%016llx",
                static_cast<unsigned long long>(sender.session));
  const std::string process = sender.process.empty() ? "unknown" : printable(sender.process);
  return "from " + process + ", session " + session + ": " + grouped(sender.count) +
         " messages, lost " + grouped(sender.lost) + ", last " +
         duration_text(static_cast<double>(sender.age_us)) + " ago";
}

}  // namespace

View::View(const Schema& schema, std::string source, std::string channel)
    : schema_{schema},
      source_{std::move(source)},
      selected_{std::move(channel)},
      open_{!selected_.empty()} {}

void View::press(Key key) {
  const auto page = static_cast<std::ptrdiff_t>(page_);
  switch (key) {
    case Key::kNone:
      break;
    case Key::kUp:
      return move(-1);
    case Key::kDown:
      return move(1);
    case Key::kPageUp:
      return move(-page);
    case Key::kPageDown:
      return move(page);
    case Key::kHome:
      return move(-kToTheEnd);
    case Key::kEnd:
      return move(kToTheEnd);
    case Key::kEnter:
      open_ = !selected_.empty();
      first_field_ = 0;
      break;
    case Key::kBack:
      open_ = false;
      break;
    case Key::kPause:
      paused_ = !paused_;
      break;
    case Key::kQuit:
      quit_ = true;
      break;
  }
}

void View::move(std::ptrdiff_t step) {
  if (open_) {
    first_field_ = static_cast<std::size_t>(
        std::clamp<std::ptrdiff_t>(static_cast<std::ptrdiff_t>(first_field_) + step, 0,
                                   static_cast<std::ptrdiff_t>(last_first_field_)));
    return;
  }
  if (channels_.empty()) return;
  const auto now = std::find(channels_.begin(), channels_.end(), selected_) - channels_.begin();
  const auto last = static_cast<std::ptrdiff_t>(channels_.size()) - 1;
  selected_ = channels_[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(now + step, 0, last))];
}

StyledLine View::title(const Snapshot& snapshot) const {
  std::string text = paused_ ? "cairn spy STOPPED  " : "cairn spy  ";
  text += headline(snapshot.traffic) + "  " + source_;
  if (snapshot.damage) {
    char share[32];
    std::snprintf(share, sizeof(share), "  read %.0f %%", 100 * snapshot.progress);
    text += share;
  }
  return {text, Style::kTitle};
}

void View::draw_processes(const TrafficSummary& traffic, ScreenSize size,
                          std::vector<StyledLine>& lines) const {
  if (traffic.processes.empty() || size.rows < kFewestRowsWithProcesses) return;
  const std::vector<std::string> rows = process_table(traffic).lines(size.columns);
  const std::size_t room = size.rows / 3;
  const std::size_t shown = std::min(traffic.processes.size(), room);
  lines.push_back({rows[0], Style::kHeading});
  for (std::size_t i = 0; i < shown; ++i)
    lines.push_back({rows[i + 1], style_of(traffic.processes[i])});
  if (shown < traffic.processes.size()) {
    lines.push_back(
        {"... " + std::to_string(traffic.processes.size() - shown) + " more", Style::kFaint});
  }
  lines.push_back({});
}

void View::draw_channels(const TrafficSummary& traffic, ScreenSize size,
                         std::vector<StyledLine>& lines) {
  channels_.clear();
  for (const ChannelSummary& channel : traffic.channels) channels_.push_back(channel.channel);
  if (channels_.empty()) {
    lines.push_back({"nothing heard yet", Style::kFaint});
    return;
  }
  if (selected_.empty()) selected_ = channels_.front();
  const auto selected = static_cast<std::size_t>(
      std::find(channels_.begin(), channels_.end(), selected_) - channels_.begin());
  const std::vector<std::string> rows = channel_table(traffic).lines(size.columns);
  page_ = size.rows > lines.size() + 2 ? size.rows - lines.size() - 2 : 1;
  first_channel_ = std::min(first_channel_, channels_.size() - std::min(page_, channels_.size()));
  if (selected < channels_.size()) first_channel_ = scrolled_to(first_channel_, selected, page_);
  lines.push_back({rows[0], Style::kHeading});
  std::vector<StyledLine> styled;
  for (std::size_t i = 0; i < channels_.size(); ++i)
    styled.push_back(
        {rows[i + 1], i == selected ? Style::kSelected : style_of(traffic.channels[i])});
  append_page(styled, first_channel_, lines);
}

void View::append_page(const std::vector<StyledLine>& rows, std::size_t first,
                       std::vector<StyledLine>& lines) {
  const std::size_t end = std::min(first + page_, rows.size());
  for (std::size_t i = first; i < end; ++i) lines.push_back(rows[i]);
  if (end - first < rows.size()) {
    position_ = std::to_string(first + 1) + "-" + std::to_string(end) + " of " +
                std::to_string(rows.size()) + "   ";
  }
}

std::vector<StyledLine> View::field_view_head(const TrafficSummary& traffic,
                                              ScreenSize size) const {
  std::vector<StyledLine> lines;
  TrafficSummary one;
  for (const ChannelSummary& channel : traffic.channels) {
    if (channel.channel == selected_) one.channels.push_back(channel);
  }
  if (one.channels.empty()) return {{printable(selected_) + ": nothing heard yet", Style::kFaint}};
  const ChannelSummary& channel = one.channels.front();
  const std::vector<std::string> rows = channel_table(one).lines(size.columns);
  lines.push_back({rows[0], Style::kHeading});
  lines.push_back({rows[1], style_of(channel)});
  for (const SenderSummary& sender : channel.senders) {
    if (lines.size() > size.rows / 4) break;
    lines.push_back({sender_line(sender), Style::kFaint});
  }
  if (channel.undecodable > 0)
    lines.push_back({"undecodable: " + printable(channel.last_problem), Style::kWarning});
  lines.push_back({});
  return lines;
}

void View::draw_fields(const Snapshot& snapshot, ScreenSize size, std::vector<StyledLine>& lines) {
  for (StyledLine& line : field_view_head(snapshot.traffic, size)) lines.push_back(std::move(line));
  const auto newest = snapshot.newest.find(selected_);
  if (newest == snapshot.newest.end()) return;
  const MessageType& type = *newest->second.type;
  const auto fields = read_message(schema_, type, *newest->second.bytes);
  if (!fields) return;
  std::vector<StyledLine> texts;
  for (std::string& line : field_lines(schema_, type, *fields)) texts.push_back({std::move(line)});
  page_ = size.rows > lines.size() + 1 ? size.rows - lines.size() - 1 : 1;
  last_first_field_ = texts.size() - std::min(texts.size(), page_);
  first_field_ = std::min(first_field_, last_first_field_);
  append_page(texts, first_field_, lines);
}

std::vector<StyledLine> View::draw(const Snapshot& snapshot, ScreenSize size) {
  std::vector<StyledLine> lines{title(snapshot)};
  if (snapshot.damage && !snapshot.damage->text.empty())
    lines.push_back({printable(snapshot.damage->text), Style::kWarning});
  lines.push_back({});
  position_.clear();
  if (open_) {
    draw_fields(snapshot, size, lines);
  } else {
    draw_processes(snapshot.traffic, size, lines);
    draw_channels(snapshot.traffic, size, lines);
  }
  if (size.rows > 0) lines.resize(size.rows - 1);
  lines.push_back({position_ + (open_ ? "arrows scroll   esc back   p stop/start   q quit"
                                      : "arrows choose   enter fields   p stop/start   q quit"),
                   Style::kFaint});
  lines.resize(size.rows);
  for (StyledLine& line : lines) line.text = shortened(line.text, size.columns);
  return lines;
}

}  // namespace cairn::spy
