// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "procs/spy/feed.hpp"
#include "procs/spy/lcm_schema.hpp"

namespace cairn::spy {

enum class Key { kNone, kUp, kDown, kPageUp, kPageDown, kHome, kEnd, kEnter, kBack, kPause, kQuit };

enum class Style { kPlain, kTitle, kHeading, kSelected, kWarning, kAlarm, kFaint };

struct StyledLine {
  std::string text;
  Style style = Style::kPlain;
};

struct ScreenSize {
  std::size_t rows = 0;
  std::size_t columns = 0;
};

/// What the terminal shows, apart from any terminal: keys in, lines out.
class View {
 public:
  /// `channel`: opened at once; empty for the table.
  View(const Schema& schema, std::string source, std::string channel);

  void press(Key key);

  /// At most `size.rows` lines, none wider than `size.columns`.
  [[nodiscard]] std::vector<StyledLine> draw(const Snapshot& snapshot, ScreenSize size);

  [[nodiscard]] bool quit() const { return quit_; }
  [[nodiscard]] bool paused() const { return paused_; }
  void set_paused(bool paused) { paused_ = paused; }

 private:
  void move(std::ptrdiff_t step);
  [[nodiscard]] StyledLine title(const Snapshot& snapshot) const;
  void draw_processes(const TrafficSummary& traffic, ScreenSize size,
                      std::vector<StyledLine>& lines) const;
  void draw_channels(const TrafficSummary& traffic, ScreenSize size,
                     std::vector<StyledLine>& lines);
  void draw_fields(const Snapshot& snapshot, ScreenSize size, std::vector<StyledLine>& lines);
  void append_page(const std::vector<StyledLine>& rows, std::size_t first,
                   std::vector<StyledLine>& lines);
  [[nodiscard]] std::vector<StyledLine> field_view_head(const TrafficSummary& traffic,
                                                        ScreenSize size) const;

  const Schema& schema_;
  std::string source_;
  std::string selected_;  ///< a channel's name: rows may come and go around it
  bool open_;
  bool paused_ = false;
  bool quit_ = false;
  std::vector<std::string> channels_;  ///< as drawn last
  std::size_t page_ = 1;               ///< rows of the scrolled part, as drawn last
  std::string position_;               ///< which rows those are, as drawn last
  std::size_t first_channel_ = 0;
  std::size_t first_field_ = 0;
  std::size_t last_first_field_ = 0;  ///< the farthest that fields can be scrolled
};

}  // namespace cairn::spy
