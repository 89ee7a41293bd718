#include "acquire/ros2/ros2_entries.h"

#include <algorithm>
#include <string>
#include <utility>

#include "acquire/replay/frame_pairing.h"
#include "acquire/ros2/frame_poses.h"

namespace scanknit {
namespace {

/// Half of the usual time from one picture to the next.
std::int64_t reach_ns(std::vector<std::int64_t> times_ns) {
  std::sort(times_ns.begin(), times_ns.end());
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < times_ns.size(); ++i) {
    steps_s.push_back((static_cast<double>(times_ns[i]) - static_cast<double>(times_ns[i - 1])) * 1e-9);
  }
  StreamProfile profile;
  if (!steps_s.empty()) {
    const auto middle = steps_s.begin() + static_cast<std::ptrdiff_t>(steps_s.size() / 2);
    std::nth_element(steps_s.begin(), middle, steps_s.end());
    if (*middle > 0) profile.frames_per_second = 1 / *middle;
  }
  return pairing_reach_ns(profile);
}

/// Says whence the entries' poses are.
void tell_poses(const FramePoses& poses, const TransformTree& tree, Recording& recording) {
  if (!poses.are_known()) {
    if (const auto elsewhere = tree.moves_elsewhere(poses.frame())) {
      recording.warnings.push_back("tf moves (" + *elsewhere + "), but does not lead from there to depth's frame '" +
                                   poses.frame() +
                                   "': no poses are known. Record /tf_static, too, or name a topic of "
                                   "the camera's poses (acquire.topics.poses)");
    }
    return;
  }
  const auto& entries = recording.entries;
  if (std::none_of(entries.begin(), entries.end(), [](const FrameEntry& e) { return e.T_world_camera.has_value(); })) {
    recording.warnings.push_back("the bag has poses (" + poses.source() +
                                 "), but none at the time of a depth picture, so that none is known. Do their stamps "
                                 "come from the same clock, ten times a second?");
    return;
  }
  recording.topics["poses"] = poses.source();
  recording.world_up = kRosUp;
  if (poses.is_of_another_frame()) {
    recording.warnings.push_back("tf does not lead from '" + poses.frame() + "' to a world: the poses of " +
                                 poses.source() + " are taken for the depth camera's");
  }
}

}  // namespace

void add_ros2_entries(const Ros2Survey& survey, const PictureTopic& depth, const PictureTopic* colour,
                      const BagTopics& wanted, Recording& recording) {
  const FramePoses poses(survey, depth.frame, wanted);
  const auto& depth_ns = depth.times_ns;
  const auto colour_ns = colour != nullptr ? colour->times_ns : std::vector<std::int64_t>();
  const auto partners = pair_by_time(depth_ns, colour_ns, reach_ns(colour_ns));
  const SharedPath bag = recording.folder;
  const Rare<Result<Pose>> some_pose = Result<Pose>(Pose::Identity());
  recording.entries.reserve(depth_ns.size());
  for (std::size_t i = 0; i < depth_ns.size(); ++i) {
    FrameEntry entry{.sequence = i, .timestamp_ns = depth_ns[i]};
    entry.depth = bag;
    entry.depth_index = i;
    if (partners[i]) {
      entry.colour = bag;
      entry.colour_index = *partners[i];
    }
    auto pose = poses.at(depth_ns[i]);
    // Of a sample it is only known whether there is one: all frames share it.
    entry.T_world_camera = survey.sampled_ns && pose ? some_pose : Rare<Result<Pose>>(std::move(pose));
    recording.entries.push_back(std::move(entry));
  }
  tell_poses(poses, survey.tree, recording);
}

}  // namespace scanknit
