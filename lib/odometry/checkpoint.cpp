// SPDX-License-Identifier: Apache-2.0
#include "odometry/checkpoint.hpp"

#include <bit>
#include <cmath>
#include <string>

#include "core/checksum.hpp"

namespace cairn::odometry {
namespace {

constexpr std::uint32_t kMagic = 0x32564f43;  // "COV2"
constexpr std::size_t kNumbers = 7 + 6;       // translation, quaternion, twist
constexpr std::size_t kReading = 1 + 8 * 6;   // there or not; utime, ticks, scale, speeds
constexpr std::size_t kBytes = 4 + 4 + 8 + 8 * kNumbers + kReading + 8;
constexpr double kUnitTolerance = 1e-6;

void put(std::vector<std::uint8_t>& bytes, std::uint64_t value, int count) {
  for (int i = 0; i < count; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) : bytes_{bytes} {}

  std::uint64_t take(std::size_t count) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < count; ++i) value |= std::uint64_t{bytes_[at_ + i]} << (8 * i);
    at_ += count;
    return value;
  }
  double take_number() { return std::bit_cast<double>(take(8)); }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
};

}  // namespace

std::vector<std::uint8_t> to_bytes(const Checkpoint& checkpoint) {
  const Eigen::Quaterniond q(checkpoint.T_odom_body.linear());
  const Eigen::Vector3d t = checkpoint.T_odom_body.translation();
  std::vector<std::uint8_t> bytes;
  bytes.reserve(kBytes);
  put(bytes, kMagic, 4);
  put(bytes, checkpoint.epoch, 4);
  put(bytes, static_cast<std::uint64_t>(checkpoint.utime), 8);
  for (const double number : {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()}) {
    put(bytes, std::bit_cast<std::uint64_t>(number), 8);
  }
  for (const double number : checkpoint.twist) put(bytes, std::bit_cast<std::uint64_t>(number), 8);
  put(bytes, checkpoint.tracks ? 1 : 0, 1);
  const TrackReading tracks = checkpoint.tracks.value_or(TrackReading{});
  for (const std::int64_t number : {tracks.utime, tracks.left_ticks, tracks.right_ticks}) {
    put(bytes, static_cast<std::uint64_t>(number), 8);
  }
  for (const double number : {tracks.ticks_per_m, tracks.left_mps, tracks.right_mps}) {
    put(bytes, std::bit_cast<std::uint64_t>(number), 8);
  }
  put(bytes, fnv1a_64(bytes), 8);
  return bytes;
}

Result<Checkpoint> checkpoint_from_bytes(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kBytes) {
    return fail("odometry checkpoint: " + std::to_string(bytes.size()) + " bytes, expected " +
                std::to_string(kBytes));
  }
  Reader reader(bytes);
  if (reader.take(4) != kMagic) return fail("odometry checkpoint: wrong magic word");
  if (Reader(bytes.last(8)).take(8) != fnv1a_64(bytes.first(kBytes - 8))) {
    return fail("odometry checkpoint: wrong checksum");
  }
  Checkpoint checkpoint;
  checkpoint.epoch = static_cast<std::uint32_t>(reader.take(4));
  checkpoint.utime = static_cast<Utime>(reader.take(8));
  for (int i = 0; i < 3; ++i) checkpoint.T_odom_body.translation()[i] = reader.take_number();
  double q[4];
  for (double& number : q) number = reader.take_number();
  for (double& number : checkpoint.twist) number = reader.take_number();
  const bool has_tracks = reader.take(1) != 0;
  TrackReading tracks;
  for (std::int64_t* number : {&tracks.utime, &tracks.left_ticks, &tracks.right_ticks}) {
    *number = static_cast<std::int64_t>(reader.take(8));
  }
  for (double* number : {&tracks.ticks_per_m, &tracks.left_mps, &tracks.right_mps}) {
    *number = reader.take_number();
  }
  if (has_tracks) checkpoint.tracks = tracks;

  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  if (!rotation.coeffs().allFinite() || !checkpoint.T_odom_body.translation().allFinite() ||
      !checkpoint.twist.allFinite() || !std::isfinite(tracks.ticks_per_m) ||
      !std::isfinite(tracks.left_mps) || !std::isfinite(tracks.right_mps)) {
    return fail("odometry checkpoint: holds a number that is not finite");
  }
  if (std::abs(rotation.norm() - 1) > kUnitTolerance) {
    return fail("odometry checkpoint: holds no rotation");
  }
  if (!(tracks.ticks_per_m > 0)) return fail("odometry checkpoint: its tracks have no scale");
  checkpoint.T_odom_body.linear() = rotation.normalized().toRotationMatrix();
  return checkpoint;
}

}  // namespace cairn::odometry
