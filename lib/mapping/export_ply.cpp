// SPDX-License-Identifier: Apache-2.0
#include "mapping/export_ply.hpp"

#include <string>

#include "core/atomic_file.hpp"
#include "mapping/byte_stream.hpp"
#include "mapping/height_colours.hpp"
#include "mapping/height_range.hpp"

namespace cairn::mapping {
namespace {

std::string ply_header(std::size_t points) {
  return "ply\nformat binary_little_endian 1.0\ncomment occupied voxels of a cairn map, "
         "metres\nelement vertex " +
         std::to_string(points) +
         "\nproperty float x\nproperty float y\nproperty float z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n";
}

}  // namespace

std::vector<std::uint8_t> encode_ply(const VoxelMap& map) {
  const HeightRange heights = occupied_heights(map);
  ByteWriter out;
  for (const char c : ply_header(map.occupied_voxels())) out.put(static_cast<std::uint8_t>(c));
  map.grid().for_each([&](BrickIndex index, const EvidenceBrick& brick) {
    for_each_voxel(brick.occupied, [&](int i) {
      const VoxelIndex voxel = voxel_in(index, i);
      const Eigen::Vector3f centre = map.centre_of(voxel).cast<float>();
      const cv::Vec3b bgr = height_colour(heights.share(voxel.z));
      for (const float coordinate_m : centre) out.put(coordinate_m);
      for (const int channel : {2, 1, 0}) out.put(bgr[channel]);
    });
  });
  return out.take();
}

Result<void> export_ply(const std::filesystem::path& path, const VoxelMap& map) {
  return write_file_atomically(path, encode_ply(map));
}

}  // namespace cairn::mapping
