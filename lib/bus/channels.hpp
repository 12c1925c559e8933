// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cairn/clearance_t.hpp>
#include <cairn/clock_t.hpp>
#include <cairn/disparity_request_t.hpp>
#include <cairn/disparity_t.hpp>
#include <cairn/drive_command_t.hpp>
#include <cairn/goal_t.hpp>
#include <cairn/group_command_t.hpp>
#include <cairn/group_state_t.hpp>
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
#include <cairn/process_status_t.hpp>
#include <cairn/range_t.hpp>
#include <cairn/record_command_t.hpp>
#include <cairn/record_state_t.hpp>
#include <cairn/rig_calibration_t.hpp>
#include <cairn/sim_state_t.hpp>
#include <cairn/stereo_frame_t.hpp>
#include <cairn/stop_t.hpp>
#include <cairn/wheel_state_t.hpp>
#include <cstdint>

namespace cairn::bus {

/// How many messages of a channel may wait in a process before the oldest is skipped (and counted)
/// for the newest.
enum class Backlog : int {
  kNewest = 1,   ///< only the newest matters
  kFew = 3,      ///< a short stall is made up for, a long one skipped over
  kEvery = 1024  ///< each one matters
};

/// Roughly where a channel belongs when something is recorded or replayed.
enum class Role {
  kInput,    ///< what the robot senses: replaying these is the same run again
  kResult,   ///< what the robot makes of it
  kCommand,  ///< what it is told; never replayed into a bus that has a motor
  kService,  ///< how the processes are
  kTruth     ///< what only a simulator knows
};

// The catalogue. A channel's name, type, waiting room and meaning are said here and nowhere else:
// nodes, spy, the table of ARCHITECTURE.md and the tests take them from here.
namespace channels {
#define CAIRN_CHANNEL(TAG, NAME, TYPE, BACKLOG, ROLE, FLOW, RATE) \
  struct TAG {                                                    \
    using type = cairn::TYPE;                                     \
    static constexpr const char* name = NAME;                     \
    static constexpr const char* type_name = #TYPE;               \
    static constexpr Backlog backlog = Backlog::BACKLOG;          \
    static constexpr Role role = Role::ROLE;                      \
    static constexpr const char* flow = FLOW;                     \
    static constexpr const char* rate = RATE;                     \
  };
#define CAIRN_CHANNELS(X)                                                                          \
  X(StereoFrame, "STEREO_FRAME", stereo_frame_t, kFew, kInput,                                     \
    "camera, simulator -> stereo, odometry", "15-30 Hz")                                           \
  X(Calibration, "CALIBRATION", rig_calibration_t, kEvery, kInput,                                 \
    "camera, simulator -> stereo, odometry", "at start and 1 Hz")                                  \
  X(WheelState, "WHEEL_STATE", wheel_state_t, kEvery, kInput, "motor -> odometry, guard", "50 Hz") \
  X(Range, "RANGE", range_t, kEvery, kInput, "sensor drivers -> guard, mapper", "10-40 Hz")        \
  X(Clock, "CLOCK", clock_t, kEvery, kInput, "camera, simulator, replay -> all",                   \
    "per frame, at least 20 Hz")                                                                   \
  X(Disparity, "DISPARITY", disparity_t, kFew, kResult,                                            \
    "stereo (camera, for a depth recording; simulator, fast) -> mapper, localizer, guard",         \
    "10-30 Hz")                                                                                    \
  X(DisparityRequest, "DISPARITY_REQUEST", disparity_request_t, kFew, kCommand,                    \
    "dashboard -> stereo", "on demand")                                                            \
  X(DisparityBand, "DISPARITY_BAND", disparity_t, kEvery, kResult, "stereo -> dashboard",          \
    "on demand")                                                                                   \
  X(Odometry, "ODOMETRY", odometry_t, kEvery, kResult,                                             \
    "odometry (simulator, fast) -> localizer, planner, mapper", "per frame")                       \
  X(Keyframe, "KEYFRAME", keyframe_t, kEvery, kResult, "odometry -> localizer", "about 1 Hz")      \
  X(Pose, "POSE", pose_t, kEvery, kResult, "localizer -> mapper, planner", "per frame")            \
  X(Particles, "PARTICLES", particles_t, kNewest, kResult, "localizer -> dashboard", "2-5 Hz")     \
  X(KeyframePoses, "KEYFRAME_POSES", keyframe_poses_t, kEvery, kResult, "localizer -> mapper",     \
    "on change")                                                                                   \
  X(MapDelta, "MAP_DELTA", map_delta_t, kEvery, kResult, "mapper -> localizer, planner",           \
    "2-10 Hz")                                                                                     \
  X(MapRequest, "MAP_REQUEST", map_request_t, kEvery, kService, "localizer, planner -> mapper",    \
    "on demand")                                                                                   \
  X(MapDigest, "MAP_DIGEST", map_digest_t, kEvery, kService, "mapper -> localizer, planner",       \
    "1 Hz")                                                                                        \
  X(Goal, "GOAL", goal_t, kEvery, kCommand, "people -> planner", "on change")                      \
  X(Path, "PATH", path_t, kNewest, kResult, "planner -> people", "on change")                      \
  X(PlanState, "PLAN_STATE", plan_state_t, kEvery, kResult, "planner -> people",                   \
    "on change and 1 Hz")                                                                          \
  X(DriveCommand, "DRIVE_COMMAND", drive_command_t, kEvery, kCommand, "planner, people -> motor",  \
    "10 Hz or more")                                                                               \
  X(Clearance, "CLEARANCE", clearance_t, kEvery, kCommand, "guard -> motor", "20 Hz")              \
  X(Stop, "STOP", stop_t, kEvery, kCommand, "anybody -> motor", "20 Hz until latched")             \
  X(MapCommand, "MAP_COMMAND", map_command_t, kEvery, kCommand, "people -> mapper", "on demand")   \
  X(LocalizerCommand, "LOCALIZER_COMMAND", localizer_command_t, kEvery, kCommand,                  \
    "people -> localizer", "on demand")                                                            \
  X(RecordCommand, "RECORD_COMMAND", record_command_t, kEvery, kCommand, "people -> recorder",     \
    "on demand")                                                                                   \
  X(RecordState, "RECORD_STATE", record_state_t, kEvery, kService, "recorder -> people", "1 Hz")   \
  X(ProcessStatus, "PROCESS_STATUS", process_status_t, kEvery, kService,                           \
    "every process -> people", "1 Hz")                                                             \
  X(GroupState, "GROUP_STATE", group_state_t, kEvery, kService, "supervisor -> people", "1 Hz")    \
  X(GroupCommand, "GROUP_COMMAND", group_command_t, kEvery, kCommand, "people -> supervisor",      \
    "on demand")                                                                                   \
  X(LogLine, "LOG_LINE", log_line_t, kEvery, kService, "every process -> people", "on demand")     \
  X(Truth, "TRUTH", pose_t, kEvery, kTruth, "simulator -> evaluation only", "per frame")           \
  X(SimState, "SIM_STATE", sim_state_t, kEvery, kTruth, "simulator -> evaluation only", "per frame")

CAIRN_CHANNELS(CAIRN_CHANNEL)
#undef CAIRN_CHANNEL
}  // namespace channels

/// Calls `visit(channels::X{})` for each channel of the catalogue, in its order.
template <class Visit>
constexpr void for_each_channel(Visit&& visit) {
#define CAIRN_VISIT(TAG, ...) visit(channels::TAG{});
  CAIRN_CHANNELS(CAIRN_VISIT)
#undef CAIRN_VISIT
}
#undef CAIRN_CHANNELS

/// One number for all message types that this program was built with: programs whose numbers differ
/// do not mix.
[[nodiscard]] inline std::int64_t types_hash() {
  std::uint64_t hash = 0;
  for_each_channel([&](auto channel) {
    hash = hash * 0x100000001b3ULL + static_cast<std::uint64_t>(decltype(channel)::type::getHash());
  });
  return static_cast<std::int64_t>(hash);
}

}  // namespace cairn::bus
