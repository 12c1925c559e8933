// SPDX-License-Identifier: Apache-2.0
#include "bus/recording_bus.hpp"

#include <optional>
#include <set>

#include "bus/recording.hpp"

namespace cairn::bus {
namespace {

class RecordingBus : public Bus {
 public:
  RecordingBus(RecordingReader reader, std::optional<RecordingWriter> writer)
      : reader_{std::move(reader)}, writer_{std::move(writer)} {}

  Result<void> publish(std::string_view channel, std::span<const std::uint8_t> bytes) override {
    return writer_ ? writer_->write(now_us_, channel, bytes) : Result<void>{};
  }
  Result<void> subscribe(std::string_view channel) override {
    wanted_.emplace(channel);
    return {};
  }
  void receive(std::int64_t, std::vector<RawMessage>& into) override {
    while (!ended_) {
      auto event = reader_.next();
      ended_ = !event;
      if (ended_) return;
      now_us_ = event->recorded_us;
      if (!wanted_.contains(event->message.channel) && !wanted_.contains(kAllChannels)) continue;
      into.push_back(std::move(event->message));
      return;
    }
  }
  [[nodiscard]] bool ended() const override { return ended_; }

 private:
  RecordingReader reader_;
  std::optional<RecordingWriter> writer_;
  std::set<std::string, std::less<>> wanted_;
  std::int64_t now_us_ = 0;
  bool ended_ = false;
};

}  // namespace

Result<std::unique_ptr<Bus>> open_recording_bus(const std::filesystem::path& in,
                                                const std::filesystem::path& out) {
  auto reader = RecordingReader::open(in);
  if (!reader) return tl::make_unexpected(reader.error());
  std::optional<RecordingWriter> writer;
  if (!out.empty()) {
    auto created = RecordingWriter::create(out);
    if (!created) return tl::make_unexpected(created.error());
    writer = std::move(*created);
  }
  return std::make_unique<RecordingBus>(std::move(*reader), std::move(writer));
}

}  // namespace cairn::bus
