// SPDX-License-Identifier: Apache-2.0
#include "simulation/renderer.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "simulation/eye.hpp"
#include "simulation/face_texture.hpp"
#include "simulation/person_look.hpp"
#include "simulation/random_hash.hpp"
#include "simulation/ray_scene.hpp"
#include "simulation/sight.hpp"
#include "simulation/visibility.hpp"

namespace cairn::simulation {
namespace {

/// One camera of the rig.
struct Camera {
  std::shared_ptr<const Eye> eye;
  Visibility visibility;
};

Result<Camera> make_camera(const camera::CameraModel& model, const camera::RigCalibration& rig,
                           const Isometry& T_body_eye) {
  auto eye = make_eye(model, rig.width_px, rig.height_px, T_body_eye);
  if (!eye) return tl::make_unexpected(eye.error());
  const auto shared = std::make_shared<const Eye>(std::move(*eye));
  return Camera{shared, Visibility(shared)};
}

std::vector<FaceTexture> pictures_of(const World& world, const std::vector<Face>& faces) {
  std::vector<FaceTexture> pictures;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const Box& box = world.boxes[i / kFacesPerBox];
    const Material& material = world.materials[box.material];
    const std::size_t picture = box.pictures * kFacesPerBox + i % kFacesPerBox;
    pictures.push_back(bake_texture(world, faces[i], material,
                                    hash64(static_cast<std::uint64_t>(material.seed), picture)));
  }
  return pictures;
}

/// People walk about, so the light on them is the same everywhere.
std::vector<FaceTexture> pictures_of_person(const Person& person, std::size_t index) {
  World light;
  light.ambient = 1;
  light.materials = person_materials(index);
  light.boxes = person_boxes(person, {});
  for (std::size_t i = 0; i < light.boxes.size(); ++i) light.boxes[i].pictures = i;
  std::vector<Face> faces;
  for (const Box& box : light.boxes) {
    for (const Face& face : faces_of(box)) faces.push_back(face);
  }
  return pictures_of(light, faces);
}

}  // namespace

struct Renderer::State {
  RayScene scene;
  Camera left;
  Camera right;
  Sensor sensor;
  std::vector<Person> people;
  std::vector<FaceTexture> pictures;                      ///< of the scene's faces
  std::vector<std::vector<FaceTexture>> people_pictures;  ///< of each one's faces

  /// What moves in a frame, in the order of the poses.
  struct Moving {
    std::optional<RayScene> scene;
    std::vector<const FaceTexture*> pictures;  ///< of what stands still, then of what moves

    [[nodiscard]] const RayScene* get() const { return scene ? &*scene : nullptr; }
  };
  [[nodiscard]] Moving put_people(std::span<const PersonPose> poses) const;
};

Renderer::State::Moving Renderer::State::put_people(std::span<const PersonPose> poses) const {
  Moving moving;
  for (const FaceTexture& picture : pictures) moving.pictures.push_back(&picture);
  const std::vector<Box> boxes = people_boxes(people, poses);
  for (const PersonPose& pose : poses) {
    if (pose.person >= people.size()) continue;
    for (const FaceTexture& picture : people_pictures[pose.person]) {
      moving.pictures.push_back(&picture);
    }
  }
  if (boxes.empty()) return moving;
  auto made = scene.beside(boxes);
  if (made) moving.scene = std::move(*made);
  return moving;
}

Renderer::Renderer(std::unique_ptr<State> state) : state_{std::move(state)} {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

Result<Renderer> Renderer::create(const World& world, const camera::RigCalibration& rig,
                                  const SensorConfig& sensor, std::uint64_t seed) {
  if (const auto ok = camera::check(rig); !ok) return tl::make_unexpected(ok.error());
  auto left = make_camera(rig.left, rig, rig.T_body_left);
  if (!left) return fail("left " + left.error().message);
  auto right = make_camera(rig.right, rig, rig.T_body_left * rig.T_right_left.inverse());
  if (!right) return fail("right " + right.error().message);
  auto scene = RayScene::create(world.boxes);
  if (!scene) return tl::make_unexpected(scene.error());
  auto pictures = pictures_of(world, scene->faces());
  std::vector<std::vector<FaceTexture>> people_pictures;
  for (std::size_t i = 0; i < world.people.size(); ++i) {
    people_pictures.push_back(pictures_of_person(world.people[i], i));
  }
  return Renderer{std::unique_ptr<State>(
      new State{std::move(*scene), std::move(*left), std::move(*right), Sensor(sensor, seed),
                world.people, std::move(pictures), std::move(people_pictures)})};
}

RenderedPair Renderer::render(const Isometry& T_world_body, std::int64_t frame,
                              std::span<const PersonPose> people) const {
  RenderedPair pair;
  const State::Moving moving = state_->put_people(people);
  const auto take = [&](const Camera& camera, int side, cv::Mat_<std::uint8_t>& image,
                        cv::Mat_<float>* depth_m) {
    const Sight sight(state_->scene, moving.get(), *camera.eye, T_world_body);
    const auto visible = sight.visible_faces(camera.visibility);
    if (depth_m != nullptr) *depth_m = sight.depth_m(visible);
    state_->sensor.take(sight.light(visible, moving.pictures), frame, side, image);
  };
  take(state_->left, 0, pair.left, &pair.left_depth_m);
  take(state_->right, 1, pair.right, nullptr);
  return pair;
}

cv::Mat_<float> Renderer::left_depth_m(const Isometry& T_world_body, int step,
                                       std::span<const PersonPose> people) const {
  const State::Moving moving = state_->put_people(people);
  return Sight(state_->scene, moving.get(), *state_->left.eye, T_world_body).depth_m(step);
}

cv::Mat_<float> Renderer::right_depth_m(const Isometry& T_world_body, int step,
                                        std::span<const PersonPose> people) const {
  const State::Moving moving = state_->put_people(people);
  return Sight(state_->scene, moving.get(), *state_->right.eye, T_world_body).depth_m(step);
}

double Renderer::exposure(std::int64_t frame) const { return state_->sensor.exposure(frame); }

}  // namespace cairn::simulation
