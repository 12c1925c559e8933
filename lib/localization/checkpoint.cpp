// SPDX-License-Identifier: Apache-2.0
#include "localization/checkpoint.hpp"

#include <string>

#include "core/checksum.hpp"
#include "mapping/byte_stream.hpp"

namespace cairn::localization {
namespace {

constexpr std::uint32_t kMagic = 0x314d4f4c;  // "LOM1"
constexpr std::size_t kBytes = 4 + 8 + 4 + 1 + 8 * (2 * 12 + 2 * 36) + 8;
constexpr double kRotationTolerance = 1e-6;

void put(mapping::ByteWriter& to, const Isometry& T) {
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 4; ++col) to.put(T(row, col));
  }
}

void put(mapping::ByteWriter& to, const Matrix6d& covariance) {
  for (const double number : covariance.reshaped()) to.put(number);
}

bool get(mapping::ByteReader& from, Isometry& T) {
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 4; ++col) {
      if (!from.get(T(row, col))) return false;
    }
  }
  return T.matrix().allFinite() &&
         (T.linear() * T.linear().transpose() - Eigen::Matrix3d::Identity()).norm() <
             kRotationTolerance &&
         T.linear().determinant() > 0;
}

bool get(mapping::ByteReader& from, Matrix6d& covariance) {
  for (double& number : covariance.reshaped()) {
    if (!from.get(number)) return false;
  }
  return covariance.allFinite() && (covariance.diagonal().array() >= 0).all();
}

}  // namespace

std::vector<std::uint8_t> to_bytes(const LocalizerMemory& memory) {
  mapping::ByteWriter bytes;
  bytes.put(kMagic);
  bytes.put(memory.frame.utime);
  bytes.put(memory.frame.epoch);
  bytes.put(static_cast<std::uint8_t>(memory.certainty));
  put(bytes, memory.frame.T_odom_body);
  put(bytes, memory.frame.step_covariance);
  put(bytes, memory.T_map_body);
  put(bytes, memory.covariance);
  bytes.put(fnv1a_64(bytes.from(0)));
  return bytes.take();
}

Result<LocalizerMemory> memory_from_bytes(std::span<const std::uint8_t> bytes) {
  if (bytes.size() != kBytes) {
    return fail("localizer checkpoint: " + std::to_string(bytes.size()) + " bytes, expected " +
                std::to_string(kBytes));
  }
  mapping::ByteReader from(bytes);
  mapping::ByteReader end(bytes.last(8));
  std::uint64_t checksum = 0;
  if (!end.get(checksum) || checksum != fnv1a_64(bytes.first(kBytes - 8)))
    return fail("localizer checkpoint: wrong checksum");
  LocalizerMemory memory;
  std::uint32_t magic = 0;
  std::uint8_t certainty = 0;
  const bool whole = from.get(magic) && from.get(memory.frame.utime) &&
                     from.get(memory.frame.epoch) && from.get(certainty);
  if (!whole || magic != kMagic) return fail("localizer checkpoint: wrong magic word");
  if (certainty > static_cast<std::uint8_t>(Certainty::kTracking))
    return fail("localizer checkpoint: a state that there is not");
  memory.certainty = static_cast<Certainty>(certainty);
  if (!get(from, memory.frame.T_odom_body) || !get(from, memory.frame.step_covariance) ||
      !get(from, memory.T_map_body) || !get(from, memory.covariance)) {
    return fail("localizer checkpoint: holds a pose or a covariance that is none");
  }
  return memory;
}

}  // namespace cairn::localization
