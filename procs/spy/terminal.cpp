// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/terminal.hpp"

#define NCURSES_NOMACROS
#include <curses.h>

#include <algorithm>
#include <clocale>
#include <cstdio>

namespace cairn::spy {
namespace {

constexpr int kEscape = 27;
constexpr int kEscapeDelay_ms = 25;
constexpr short kRedPair = 1;
constexpr short kYellowPair = 2;

chtype attributes(Style style) {
  const bool colours = ::has_colors();
  switch (style) {
    case Style::kPlain:
      return A_NORMAL;
    case Style::kTitle:
      return A_BOLD;
    case Style::kHeading:
      return A_UNDERLINE;
    case Style::kSelected:
      return A_REVERSE;
    case Style::kWarning:
      return colours ? static_cast<chtype>(COLOR_PAIR(kYellowPair)) : A_BOLD;
    case Style::kAlarm:
      return colours ? static_cast<chtype>(COLOR_PAIR(kRedPair)) | A_BOLD : A_BOLD | A_STANDOUT;
    case Style::kFaint:
      return A_DIM;
  }
  return A_NORMAL;
}

}  // namespace

Result<std::unique_ptr<Terminal>> Terminal::open() {
  std::setlocale(LC_CTYPE, "");
  SCREEN* screen = ::newterm(nullptr, stdout, stdin);
  if (screen == nullptr) return fail("the terminal's kind ($TERM) is not known");
  std::unique_ptr<Terminal> terminal(new Terminal(screen));
  ::cbreak();
  ::noecho();
  ::keypad(stdscr, TRUE);
  ::set_escdelay(kEscapeDelay_ms);
  ::curs_set(0);
  if (::has_colors()) {
    ::start_color();
    ::use_default_colors();
    ::init_pair(kRedPair, COLOR_RED, -1);
    ::init_pair(kYellowPair, COLOR_YELLOW, -1);
  }
  return terminal;
}

Terminal::~Terminal() {
  ::endwin();
  ::delscreen(static_cast<SCREEN*>(screen_));
}

ScreenSize Terminal::size() const {
  return {static_cast<std::size_t>(std::max(0, ::getmaxy(stdscr))),
          static_cast<std::size_t>(std::max(0, ::getmaxx(stdscr)))};
}

void Terminal::paint(const std::vector<StyledLine>& lines) {
  ::erase();
  int row = 0;
  for (const StyledLine& line : lines) {
    ::attrset(static_cast<int>(attributes(line.style)));
    ::mvaddstr(row++, 0, line.text.c_str());
  }
  ::attrset(static_cast<int>(A_NORMAL));
  ::refresh();
}

Key Terminal::key(int timeout_ms) {
  ::timeout(timeout_ms);
  switch (::getch()) {
    case KEY_UP:
    case 'k':
      return Key::kUp;
    case KEY_DOWN:
    case 'j':
      return Key::kDown;
    case KEY_PPAGE:
      return Key::kPageUp;
    case KEY_NPAGE:
      return Key::kPageDown;
    case KEY_HOME:
    case 'g':
      return Key::kHome;
    case KEY_END:
    case 'G':
      return Key::kEnd;
    case KEY_ENTER:
    case '\r':
    case '\n':
    case KEY_RIGHT:
      return Key::kEnter;
    case kEscape:
    case KEY_BACKSPACE:
    case KEY_LEFT:
    case '\b':
    case 127:
      return Key::kBack;
    case 'p':
    case ' ':
      return Key::kPause;
    case 'q':
    case 'Q':
      return Key::kQuit;
    default:
      return Key::kNone;
  }
}

}  // namespace cairn::spy
