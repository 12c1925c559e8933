// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <random>
#include <span>

#include "fuzz/lcm_schema.hpp"
#include "fuzz/mutants.hpp"
#include "messages/calibration_messages.hpp"
#include "messages/check.hpp"
#include "messages/disparity_messages.hpp"
#include "messages/image_messages.hpp"
#include "messages/map_messages.hpp"
#include "messages/streams.hpp"

namespace cairn::messages {
namespace {

using testing::kSeed;
using testing::mutant;
using testing::mutant_count;
using testing::Sample;

cv::Mat pattern(int rows, int columns, int phase) {
  cv::Mat image(rows, columns, CV_8UC1);
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      image.at<std::uint8_t>(row, column) =
          static_cast<std::uint8_t>((row * 7 + (column + phase) * 5 + row * column / 9) & 255);
    }
  }
  return image;
}

stereo_frame_t frame(ImageEncoding encoding) {
  camera::Frame frame;
  frame.left = pattern(24, 40, 0);
  frame.right = pattern(24, 40, 3);
  return FrameEncoder(encoding).encode(frame, 7).value();
}

disparity_t disparity() {
  stereo::DisparityImage image;
  image.step_px = 2;
  image.camera.f_px = 500;
  image.camera.baseline_m = 0.25;
  image.camera.width_px = 66;
  image.camera.height_px = 40;
  image.disparity_16ths.create(20, 33);
  image.code.create(20, 33);
  for (int row = 0; row < 20; ++row) {
    for (int column = 0; column < 33; ++column) {
      image.disparity_16ths(row, column) =
          static_cast<std::uint16_t>((row + column) % 5 == 0 ? 0 : 300 + row * 3 + column * column);
      image.code(row, column) = static_cast<std::uint8_t>((row + column / 3) % 4);
    }
  }
  return to_message(image, 7).value();
}

map_delta_t delta() {
  mapping::MapDelta delta{9, 1000, 0.01, {}};
  for (int i = 0; i < 40; ++i) {
    mapping::BrickClasses brick;
    brick.brick = {i % 5 - 2, i / 5, -i};
    brick.classes.fill(i % 2 == 0 ? 0x55 : 0xaa);
    if (i % 3 == 0) brick.classes[static_cast<std::size_t>(i)] = 0;
    delta.bricks.push_back(brick);
  }
  return to_messages(delta, DeltaKind::kChanges).value().front();
}

rig_calibration_t calibration() {
  return to_message(camera::rectified_rig(500, 500, 320, 240, 0.25, 640, 480, Isometry::Identity()),
                    5);
}

/// Damages `bytes` of the message, which `decode` then must take or refuse; both must happen.
template <class Message, class Decode>
void survives(const Message& sound, std::vector<std::uint8_t> Message::*bytes,
              std::int32_t Message::*size, Decode decode) {
  std::printf("seed %llu, %d mutants\n", kSeed, mutant_count());
  ASSERT_TRUE(decode(sound));
  std::mt19937_64 rng(kSeed);
  const Sample sample{sound.*bytes, {}};
  int refused = 0;
  for (int i = 0; i < mutant_count(); ++i) {
    Message message = sound;
    message.*bytes = mutant(sample, sample, rng);
    message.*size = static_cast<std::int32_t>((message.*bytes).size());
    bool accepted = false;
    ASSERT_NO_THROW(accepted = decode(message)) << "mutant " << i;
    refused += accepted ? 0 : 1;
  }
  EXPECT_GT(refused, mutant_count() / 4);
}

/// Damages the whole message, as it is on the wire.
template <class Message, class Decode>
void survives_on_the_wire(const Message& sound, Decode decode) {
  std::mt19937_64 rng(kSeed);
  Sample sample{std::vector<std::uint8_t>(static_cast<std::size_t>(sound.getEncodedSize())), {}};
  sound.encode(sample.bytes.data(), 0, sound.getEncodedSize());
  for (int i = 0; i < mutant_count(); ++i) {
    const auto bytes = mutant(sample, sample, rng);
    Message message{};
    const int size = static_cast<int>(bytes.size());
    if (message.decode(bytes.data(), 0, size) != size) continue;
    ASSERT_NO_THROW((void)decode(message)) << "mutant " << i;
  }
}

/// Damages what is inside the packed streams and packs it again, so that zstd hides nothing.
template <class Message, class Decode>
void survives_inside(const Message& sound, std::size_t preamble_bytes, Decode decode) {
  const std::span<const std::uint8_t> packed(sound.packed);
  std::vector<Sample> streams;
  StreamReader reader(packed.subspan(preamble_bytes), 1 << 20);
  while (!reader.at_end()) streams.push_back({reader.next().value(), {}});

  std::mt19937_64 rng(kSeed);
  int refused = 0;
  for (int i = 0; i < mutant_count(); ++i) {
    Message message = sound;
    message.packed.resize(preamble_bytes);
    StreamWriter writer(message.packed, Redundancy::kSkewed);
    const std::size_t damaged = rng() % streams.size();
    const Sample& other = streams[rng() % streams.size()];
    for (std::size_t s = 0; s < streams.size(); ++s) {
      writer.append(s == damaged ? mutant(streams[s], other, rng) : streams[s].bytes);
    }
    message.packed_size = static_cast<std::int32_t>(message.packed.size());
    bool accepted = false;
    ASSERT_NO_THROW(accepted = decode(message)) << "mutant " << i;
    refused += accepted ? 0 : 1;
  }
  EXPECT_GT(refused, mutant_count() / 4);
}

bool decodes_images(const stereo_frame_t& message) {
  const auto images = to_images(message);
  if (!images) {
    EXPECT_FALSE(images.error().message.empty());
    return false;
  }
  EXPECT_EQ(images->left.size(), cv::Size(message.width_px, message.height_px));
  EXPECT_EQ(images->right.size(), images->left.size());
  return true;
}

bool decodes_disparity(const disparity_t& message) {
  const auto image = to_disparity(message);
  if (!image) {
    EXPECT_FALSE(image.error().message.empty());
    return false;
  }
  EXPECT_EQ(image->rows(), message.rows);
  EXPECT_EQ(image->cols(), message.columns);
  double largest = 0;
  cv::minMaxLoc(image->code, nullptr, &largest);
  EXPECT_LE(largest, 3);
  return true;
}

bool decodes_delta(const map_delta_t& message) {
  const auto delta = to_delta(message);
  if (!delta) {
    EXPECT_FALSE(delta.error().message.empty());
    return false;
  }
  EXPECT_EQ(delta->bricks.size(), static_cast<std::size_t>(message.brick_count));
  return true;
}

bool decodes_rig(const rig_calibration_t& message) {
  const auto rig = to_rig(message);
  if (rig) {
    EXPECT_TRUE(camera::check(*rig));
  }
  return rig.has_value();
}

TEST(DecoderMutation, DamagedJpegs) {
  survives(frame(ImageEncoding::kJpeg), &stereo_frame_t::left, &stereo_frame_t::left_size,
           decodes_images);
}

TEST(DecoderMutation, DamagedDisparities) {
  survives(disparity(), &disparity_t::packed, &disparity_t::packed_size, decodes_disparity);
}

TEST(DecoderMutation, DamagedDeltas) {
  survives(delta(), &map_delta_t::packed, &map_delta_t::packed_size, decodes_delta);
}

TEST(DecoderMutation, DamagedStreamsOfDisparities) {
  const disparity_t sound = disparity();
  const std::size_t symbol_bytes = sound.packed[5] + 256U * sound.packed[6];
  survives_inside(sound, 9 + symbol_bytes, decodes_disparity);
}

TEST(DecoderMutation, DamagedStreamsOfDeltas) { survives_inside(delta(), 1, decodes_delta); }

TEST(DecoderMutation, FramesDamagedOnTheWire) {
  survives_on_the_wire(frame(ImageEncoding::kJpeg), decodes_images);
  survives_on_the_wire(frame(ImageEncoding::kRaw), decodes_images);
  survives_on_the_wire(frame(ImageEncoding::kRaw),
                       [](const auto& message) { return check(message).has_value(); });
}

TEST(DecoderMutation, DisparitiesDamagedOnTheWire) {
  survives_on_the_wire(disparity(), decodes_disparity);
}

TEST(DecoderMutation, DeltasDamagedOnTheWire) { survives_on_the_wire(delta(), decodes_delta); }

TEST(DecoderMutation, CalibrationsDamagedOnTheWire) {
  survives_on_the_wire(calibration(), decodes_rig);
}

}  // namespace
}  // namespace cairn::messages
