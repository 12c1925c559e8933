// SPDX-License-Identifier: Apache-2.0
#include "procs/spy/view.hpp"

#include <gtest/gtest.h>

#include "procs/spy/printable.hpp"
#include "spy/messages.hpp"

namespace cairn::spy {
namespace {

namespace channels = bus::channels;
constexpr ScreenSize kLarge{40, 160};

Snapshot snapshot() {
  Traffic traffic(schema(), PaceWindow::kNewest, Timing::kLive);
  for (int i = 0; i < 5; ++i) {
    traffic.add(message<channels::Pose>(1, i), i * 100'000);
    traffic.add(message<channels::Clock>(1, i), i * 100'000);
    traffic.add(message<channels::Truth>(1, 2 * i), i * 100'000);
  }
  for (int i = 0; i < 30; ++i) traffic.add({"X" + std::to_string(10 + i), {1}}, 400'000);
  process_status_t ill = process_status("mapper", 1);
  ill.health = process_status_t::HEALTH_ILL;
  ill.reason = "disk full";
  traffic.add({channels::ProcessStatus::name, bytes_of(ill)}, 400'000);
  return {traffic.summary(500'000), traffic.newest(), std::nullopt, 0};
}

std::string text_of(const std::vector<StyledLine>& lines) {
  std::string text;
  for (const StyledLine& line : lines) text += line.text + "\n";
  return text;
}

std::string with_style(const std::vector<StyledLine>& lines, Style style) {
  std::string text;
  for (const StyledLine& line : lines) text += line.style == style ? line.text + "\n" : "";
  return text;
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(View, ShowsProcessesAndChannels) {
  View view(schema(), "somewhere", "");
  const auto lines = view.draw(snapshot(), kLarge);
  const std::string text = text_of(lines);
  EXPECT_TRUE(contains(text, "disk full")) << text;
  EXPECT_TRUE(contains(text, "POSE")) << text;
  EXPECT_TRUE(contains(with_style(lines, Style::kAlarm), "mapper"));
  EXPECT_TRUE(contains(with_style(lines, Style::kWarning), "TRUTH"));
  EXPECT_TRUE(contains(with_style(lines, Style::kSelected), "CLOCK"));
}

TEST(View, ArrowsChooseAndScrollAndStayOnTheScreen) {
  View view(schema(), "", "");
  const Snapshot now = snapshot();
  const auto selected = [&] { return with_style(view.draw(now, {16, 80}), Style::kSelected); };
  EXPECT_TRUE(contains(selected(), "CLOCK"));
  view.press(Key::kUp);
  EXPECT_TRUE(contains(selected(), "CLOCK"));
  view.press(Key::kDown);
  EXPECT_TRUE(contains(selected(), "POSE"));
  for (int i = 0; i < 100; ++i) {
    view.press(Key::kDown);
    EXPECT_NE(selected(), "");
  }
  EXPECT_TRUE(contains(selected(), "X39"));
  view.press(Key::kPageUp);
  EXPECT_FALSE(contains(selected(), "X39"));
  view.press(Key::kHome);
  EXPECT_TRUE(contains(selected(), "CLOCK"));
  view.press(Key::kEnd);
  EXPECT_TRUE(contains(selected(), "X39"));
}

TEST(View, TheChoiceStaysWithItsChannelWhenRowsCome) {
  View view(schema(), "", "");
  (void)view.draw(snapshot(), kLarge);
  view.press(Key::kDown);
  Snapshot later = snapshot();
  later.traffic.channels.insert(later.traffic.channels.begin(), ChannelSummary{});
  later.traffic.channels.front().channel = "ABOVE";
  EXPECT_TRUE(contains(with_style(view.draw(later, kLarge), Style::kSelected), "POSE"));
}

TEST(View, EnterShowsTheFieldsAndEscapeGoesBack) {
  View view(schema(), "", "");
  (void)view.draw(snapshot(), kLarge);
  view.press(Key::kDown);
  view.press(Key::kEnter);
  const std::string fields = text_of(view.draw(snapshot(), kLarge));
  EXPECT_TRUE(contains(fields, "T_map_body")) << fields;
  EXPECT_TRUE(contains(fields, "from mapper, session 0000000000000001")) << fields;
  EXPECT_FALSE(contains(fields, "CLOCK"));
  view.press(Key::kBack);
  EXPECT_TRUE(contains(text_of(view.draw(snapshot(), kLarge)), "CLOCK"));
}

TEST(View, FieldsScrollToTheLastAndNoFarther) {
  View view(schema(), "", "POSE");
  const ScreenSize small{12, 80};
  EXPECT_FALSE(contains(text_of(view.draw(snapshot(), small)), "covariance"));
  for (int i = 0; i < 100; ++i) view.press(Key::kDown);
  EXPECT_TRUE(contains(text_of(view.draw(snapshot(), small)), "covariance"));
  view.press(Key::kHome);
  EXPECT_FALSE(contains(text_of(view.draw(snapshot(), small)), "covariance"));
}

TEST(View, AChannelThatIsNotThereYetCanBeOpen) {
  View view(schema(), "", "WHEEL_STATE");
  EXPECT_TRUE(contains(text_of(view.draw(Snapshot{}, kLarge)), "WHEEL_STATE: nothing heard yet"));
}

TEST(View, StopsAndQuits) {
  View view(schema(), "", "");
  view.press(Key::kPause);
  EXPECT_TRUE(view.paused());
  EXPECT_TRUE(contains(text_of(view.draw(snapshot(), kLarge)), "STOPPED"));
  view.press(Key::kPause);
  EXPECT_FALSE(view.paused());
  view.press(Key::kQuit);
  EXPECT_TRUE(view.quit());
}

TEST(View, FitsAnyScreen) {
  const Snapshot now = snapshot();
  for (const char* open : {"", "POSE"}) {
    for (std::size_t rows = 0; rows < 45; ++rows) {
      for (const std::size_t columns : {0, 1, 7, 40, 80, 200}) {
        View view(schema(), "a source", open);
        const auto lines = view.draw(now, {rows, columns});
        ASSERT_LE(lines.size(), rows);
        for (const StyledLine& line : lines) ASSERT_LE(width_of(line.text), columns);
      }
    }
  }
}

}  // namespace
}  // namespace cairn::spy
