// SPDX-License-Identifier: Apache-2.0
#include "simulation/ray_scene.hpp"

#include <embree3/rtcore.h>

#include <algorithm>
#include <limits>
#include <string>

namespace cairn::simulation {
namespace {

constexpr std::size_t kPacket = 8;
constexpr double kSightMargin_m = 1e-3;

struct ReleaseDevice {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseScene {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};

using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice>;
using Scene = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene>;

/// One quadrangle a face; false if there is no memory for them.
bool attach_faces(RTCDevice device, RTCScene scene, const std::vector<Face>& faces) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
  auto* const vertices = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), 4 * faces.size()));
  auto* const indices = static_cast<std::uint32_t*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4,
                              4 * sizeof(std::uint32_t), faces.size()));
  if (vertices == nullptr || indices == nullptr) {
    rtcReleaseGeometry(geometry);
    return false;
  }
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const Face& face = faces[i];
    const std::array<Eigen::Vector3d, 4> corners{face.at(0, 0), face.at(face.size_s_m, 0),
                                                 face.at(face.size_s_m, face.size_t_m),
                                                 face.at(0, face.size_t_m)};
    for (std::size_t corner = 0; corner < 4; ++corner) {
      const Eigen::Vector3f position_m = corners[corner].cast<float>();
      std::copy_n(position_m.data(), 3, vertices + 3 * (4 * i + corner));
      indices[4 * i + corner] = static_cast<std::uint32_t>(4 * i + corner);
    }
  }
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  return true;
}

}  // namespace

struct RayScene::State {
  std::vector<Face> faces;
  std::vector<Edge> edges;
  std::shared_ptr<Device> device;
  Scene scene;

  static Result<std::unique_ptr<State>> create(std::shared_ptr<Device> device,
                                               std::span<const Box> boxes);
};

RayScene::RayScene(std::unique_ptr<State> state) : state_{std::move(state)} {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

Result<std::unique_ptr<RayScene::State>> RayScene::State::create(std::shared_ptr<Device> device,
                                                                 std::span<const Box> boxes) {
  auto state = std::make_unique<State>();
  for (const Box& box : boxes) {
    for (const Face& face : faces_of(box)) state->faces.push_back(face);
    for (const Edge& edge : edges_of(box)) state->edges.push_back(edge);
  }
  state->device = std::move(device);
  state->scene.reset(rtcNewScene(state->device->get()));
  if (!attach_faces(state->device->get(), state->scene.get(), state->faces)) {
    return fail("ray tracer: no memory for " + std::to_string(state->faces.size()) + " faces");
  }
  rtcSetSceneFlags(state->scene.get(), RTC_SCENE_FLAG_ROBUST);
  rtcCommitScene(state->scene.get());
  return state;
}

Result<RayScene> RayScene::create(std::span<const Box> boxes) {
  auto device = std::make_shared<Device>(rtcNewDevice("threads=1"));
  if (!*device) {
    return fail("ray tracer: Embree does not start, error " +
                std::to_string(rtcGetDeviceError(nullptr)));
  }
  return State::create(std::move(device), boxes).map([](auto state) {
    return RayScene{std::move(state)};
  });
}

Result<RayScene> RayScene::beside(std::span<const Box> boxes) const {
  return State::create(state_->device, boxes).map([](auto state) {
    return RayScene{std::move(state)};
  });
}

const std::vector<Face>& RayScene::faces() const { return state_->faces; }

const std::vector<Edge>& RayScene::edges() const { return state_->edges; }

void RayScene::first_faces(const Eigen::Vector3f& origin_m,
                           std::span<const Eigen::Vector3f> directions,
                           std::span<FaceIndex> result) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(32) RTCRayHit8 rays{};
  std::fill_n(rays.ray.org_x, kPacket, origin_m.x());
  std::fill_n(rays.ray.org_y, kPacket, origin_m.y());
  std::fill_n(rays.ray.org_z, kPacket, origin_m.z());
  std::fill_n(rays.ray.mask, kPacket, 0xffffffffU);
  for (std::size_t begin = 0; begin < directions.size(); begin += kPacket) {
    const std::size_t count = std::min(kPacket, directions.size() - begin);
    alignas(32) std::array<int, kPacket> valid{};
    std::fill_n(valid.begin(), count, -1);
    for (std::size_t i = 0; i < kPacket; ++i) {
      const Eigen::Vector3f& direction = directions[begin + std::min(i, count - 1)];
      rays.ray.dir_x[i] = direction.x();
      rays.ray.dir_y[i] = direction.y();
      rays.ray.dir_z[i] = direction.z();
      rays.ray.tfar[i] = std::numeric_limits<float>::infinity();
      rays.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect8(valid.data(), state_->scene.get(), &context, &rays);
    for (std::size_t i = 0; i < count; ++i) {
      result[begin + i] =
          rays.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? kNothing : rays.hit.primID[i];
    }
  }
}

bool RayScene::sees(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) const {
  const Eigen::Vector3d way = to_m - from_m;
  const double distance_m = way.norm();
  if (distance_m <= kSightMargin_m) return true;
  const Eigen::Vector3f origin_m = from_m.cast<float>();
  const Eigen::Vector3f direction = (way / distance_m).cast<float>();
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray{};
  ray.org_x = origin_m.x();
  ray.org_y = origin_m.y();
  ray.org_z = origin_m.z();
  ray.dir_x = direction.x();
  ray.dir_y = direction.y();
  ray.dir_z = direction.z();
  ray.tfar = static_cast<float>(distance_m - kSightMargin_m);
  ray.mask = 0xffffffffU;
  rtcOccluded1(state_->scene.get(), &context, &ray);
  return ray.tfar >= 0;
}

}  // namespace cairn::simulation
