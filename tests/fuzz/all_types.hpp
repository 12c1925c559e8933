// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/camera_model_t.hpp>
#include <cairn/channel_status_t.hpp>
#include <cairn/clearance_t.hpp>
#include <cairn/clock_t.hpp>
#include <cairn/counter_t.hpp>
#include <cairn/disparity_request_t.hpp>
#include <cairn/disparity_t.hpp>
#include <cairn/drive_command_t.hpp>
#include <cairn/goal_t.hpp>
#include <cairn/group_command_t.hpp>
#include <cairn/group_state_t.hpp>
#include <cairn/header_t.hpp>
#include <cairn/isometry_t.hpp>
#include <cairn/keyframe_poses_t.hpp>
#include <cairn/keyframe_t.hpp>
#include <cairn/localizer_command_t.hpp>
#include <cairn/log_line_t.hpp>
#include <cairn/map_command_t.hpp>
#include <cairn/map_delta_t.hpp>
#include <cairn/map_digest_t.hpp>
#include <cairn/map_request_t.hpp>
#include <cairn/odometry_t.hpp>
#include <cairn/particles_t.hpp>
#include <cairn/path_t.hpp>
#include <cairn/plan_state_t.hpp>
#include <cairn/pose_t.hpp>
#include <cairn/process_state_t.hpp>
#include <cairn/process_status_t.hpp>
#include <cairn/range_t.hpp>
#include <cairn/record_command_t.hpp>
#include <cairn/record_state_t.hpp>
#include <cairn/rectified_camera_t.hpp>
#include <cairn/rig_calibration_t.hpp>
#include <cairn/sim_state_t.hpp>
#include <cairn/stereo_frame_t.hpp>
#include <cairn/stop_t.hpp>
#include <cairn/twist_t.hpp>
#include <cairn/wheel_state_t.hpp>

namespace cairn::testing {

/// List<all message types>; a test compares it with the folder of the .lcm files.
template <template <class...> class List>
using AllTypes =
    List<cairn::camera_model_t, cairn::channel_status_t, cairn::clearance_t, cairn::clock_t,
         cairn::counter_t, cairn::disparity_request_t, cairn::disparity_t, cairn::drive_command_t,
         cairn::goal_t, cairn::group_command_t, cairn::group_state_t, cairn::header_t,
         cairn::isometry_t, cairn::keyframe_poses_t, cairn::keyframe_t, cairn::localizer_command_t,
         cairn::log_line_t, cairn::map_command_t, cairn::map_delta_t, cairn::map_digest_t,
         cairn::map_request_t, cairn::odometry_t, cairn::particles_t, cairn::path_t,
         cairn::plan_state_t, cairn::pose_t, cairn::process_state_t, cairn::process_status_t,
         cairn::range_t, cairn::record_command_t, cairn::record_state_t, cairn::rectified_camera_t,
         cairn::rig_calibration_t, cairn::sim_state_t, cairn::stereo_frame_t, cairn::stop_t,
         cairn::twist_t, cairn::wheel_state_t>;

}  // namespace cairn::testing
