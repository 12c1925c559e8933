// SPDX-License-Identifier: Apache-2.0
#include "evaluation/trajectory.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>

#include "core/atomic_file.hpp"
#include "evaluation/number_table.hpp"

namespace cairn::evaluation {
namespace {

constexpr double kMaxPosition_m = 1e9;
constexpr double kMaxTime_s = 1e10;
constexpr double kRotationTolerance = 0.02;

template <std::size_t N>
Result<std::array<double, N>> numbers_at(const TableLine& line, std::size_t first) {
  std::array<double, N> values{};
  for (std::size_t i = 0; i < N; ++i) {
    const auto value = number_at(line, first + i);
    if (!value) return tl::make_unexpected(value.error());
    values[i] = *value;
  }
  return values;
}

Result<void> check_field_count(const TableLine& line, std::size_t min, std::size_t max,
                               const char* form) {
  if (line.fields.size() >= min && line.fields.size() <= max) return {};
  return fail(line.place + std::to_string(line.fields.size()) + " fields where '" + form +
              "' is expected");
}

Result<Isometry> make_pose(const TableLine& line, const Eigen::Vector3d& position_m,
                           const Eigen::Quaterniond& rotation) {
  if (position_m.cwiseAbs().maxCoeff() > kMaxPosition_m) {
    return fail(line.place + "the position is over 1e9 m away");
  }
  if (std::abs(rotation.norm() - 1.0) > kRotationTolerance) {
    return fail(line.place + "the quaternion's length is not 1");
  }
  Isometry T = Isometry::Identity();
  T.linear() = rotation.normalized().toRotationMatrix();
  T.translation() = position_m;
  return T;
}

Result<Isometry> kitti_pose(const TableLine& line) {
  const auto v = numbers_at<12>(line, 0);
  if (!v) return tl::make_unexpected(v.error());
  const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> M(v->data());
  const Eigen::Matrix3d R = M.leftCols<3>();
  const bool bounded = R.cwiseAbs().maxCoeff() < 2.0;
  if (!bounded || R.determinant() < 0 ||
      (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() >
          kRotationTolerance) {
    return fail(line.place + "the left 3x3 is not a rotation");
  }
  return make_pose(line, M.col(3), Eigen::Quaterniond(nearest_rotation(R)));
}

Result<StampedPose> tum_pose(const TableLine& line) {
  if (const auto ok = check_field_count(line, 8, 8, "t x y z qx qy qz qw"); !ok) {
    return tl::make_unexpected(ok.error());
  }
  const auto v = numbers_at<8>(line, 0);
  if (!v) return tl::make_unexpected(v.error());
  const auto& [t_s, x, y, z, qx, qy, qz, qw] = *v;
  if (std::abs(t_s) > kMaxTime_s) return fail(line.place + "the time is not in seconds");
  const auto T = make_pose(line, {x, y, z}, {qw, qx, qy, qz});
  if (!T) return tl::make_unexpected(T.error());
  return StampedPose{std::llround(t_s * 1e6), *T};
}

Result<StampedPose> euroc_pose(const TableLine& line) {
  if (const auto ok = check_field_count(line, 8, 32, "t_ns,x,y,z,qw,qx,qy,qz"); !ok) {
    return tl::make_unexpected(ok.error());
  }
  const auto t_ns = integer_at(line, 0);
  if (!t_ns) return tl::make_unexpected(t_ns.error());
  const auto v = numbers_at<7>(line, 1);
  if (!v) return tl::make_unexpected(v.error());
  const auto& [x, y, z, qw, qx, qy, qz] = *v;
  const auto T = make_pose(line, {x, y, z}, {qw, qx, qy, qz});
  if (!T) return tl::make_unexpected(T.error());
  return StampedPose{*t_ns / 1000 + (*t_ns % 1000 >= 500 ? 1 : 0), *T};
}

template <class ParsePose>
Result<Trajectory> read_lines(const std::filesystem::path& file, const ParsePose& parse_pose) {
  const auto table = NumberTable::read(file);
  if (!table) return tl::make_unexpected(table.error());
  Trajectory poses;
  for (const TableLine& line : table->lines()) {
    const Result<StampedPose> pose = parse_pose(line, poses.size());
    if (!pose) return tl::make_unexpected(pose.error());
    if (!poses.empty() && pose->utime <= poses.back().utime) {
      return fail(line.place + "the time does not rise");
    }
    poses.push_back(*pose);
  }
  if (poses.empty()) return fail(file.string() + ": holds no pose");
  return poses;
}

/// utime / 1e6 with six decimals, exactly.
void append_seconds(std::string& text, Utime utime) {
  std::string digits = std::to_string(utime);
  const std::string sign = utime < 0 ? "-" : "";
  digits.erase(0, sign.size());
  if (digits.size() < 7) digits.insert(0, 7 - digits.size(), '0');
  text += sign + digits.insert(digits.size() - 6, 1, '.');
}

void append_fixed(std::string& text, double value, int decimals) {
  std::array<char, 400> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                 std::chars_format::fixed, decimals);
  text += ' ';
  text.append(digits.data(), end.ptr);
}

}  // namespace

Result<Trajectory> read_tum(const std::filesystem::path& file) {
  return read_lines(file, [](const TableLine& line, std::size_t) { return tum_pose(line); });
}

Result<Trajectory> read_euroc(const std::filesystem::path& file) {
  return read_lines(file, [](const TableLine& line, std::size_t) { return euroc_pose(line); });
}

Result<Trajectory> read_kitti(const std::filesystem::path& file, std::span<const Utime> times) {
  return read_lines(file, [&](const TableLine& line, std::size_t i) -> Result<StampedPose> {
    if (const auto ok = check_field_count(line, 12, 12, "3x4 matrix, row by row"); !ok) {
      return tl::make_unexpected(ok.error());
    }
    if (i >= times.size()) {
      return fail(line.place + "pose " + std::to_string(i + 1) + ", but there are only " +
                  std::to_string(times.size()) + " frames");
    }
    const auto T = kitti_pose(line);
    if (!T) return tl::make_unexpected(T.error());
    return StampedPose{times[i], *T};
  });
}

Result<Trajectory> read_trajectory(const std::filesystem::path& file, std::string_view format,
                                   std::span<const Utime> frame_times) {
  if (format == "tum") return read_tum(file);
  if (format == "euroc") return read_euroc(file);
  if (format == "kitti") return read_kitti(file, frame_times);
  return fail(file.string() + ": trajectory format '" + std::string(format) +
              "' is not known (tum, kitti, euroc)");
}

std::string tum_text(std::span<const StampedPose> poses) {
  std::string text;
  for (const StampedPose& pose : poses) {
    const Eigen::Vector3d p = pose.T.translation();
    Eigen::Quaterniond q(pose.T.linear());
    q.normalize();
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    append_seconds(text, pose.utime);
    for (const double metres : {p.x(), p.y(), p.z()}) append_fixed(text, metres, 9);
    for (const double part : {q.x(), q.y(), q.z(), q.w()}) append_fixed(text, part, 12);
    text += '\n';
  }
  return text;
}

Result<void> write_tum(const std::filesystem::path& file, std::span<const StampedPose> poses) {
  const std::string text = tum_text(poses);
  return write_file_atomically(file,
                               {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

Trajectory body_from_left_camera(std::span<const StampedPose> T_world_left,
                                 const Isometry& T_body_left) {
  Trajectory body;
  body.reserve(T_world_left.size());
  for (const StampedPose& pose : T_world_left) {
    const Isometry T_c0_ci = T_world_left.front().T.inverse() * pose.T;
    body.push_back({pose.utime, T_body_left * T_c0_ci * T_body_left.inverse()});
  }
  return body;
}

double path_length_m(std::span<const StampedPose> poses) {
  double length_m = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    length_m += (poses[i].T.translation() - poses[i - 1].T.translation()).norm();
  }
  return length_m;
}

}  // namespace cairn::evaluation
