#include "acquire/lidar/bag_sweeps.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "acquire/lidar/cloud_sweep.h"
#include "acquire/lidar/undo_motion.h"
#include "acquire/raw/raw_recording.h"
#include "acquire/replay/folder.h"
#include "acquire/ros2/frame_poses.h"
#include "acquire/ros2/ros2_survey.h"
#include "core/files/located.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCloudType = "sensor_msgs/PointCloud2";

/// The files of a bag, opened. `path`: as find_bag() gave it.
Result<OpenBag> open_bag(const fs::path& path, const Limits& limits) {
  std::error_code code;
  if (fs::is_directory(path, code)) {
    const auto folder = list_folder(path, limits);
    return folder ? open_split_bag(*folder, limits) : folder.error();
  }
  auto file = open_random_access(path);
  if (!file) return file.error();
  if (is_ros_bag(**file)) {
    auto bag = RosBag::open(*std::move(file), limits);
    if (!bag) return located(bag.error(), path);
    return OpenBag{messages_of_ros1(*std::move(bag))};
  }
  auto messages = open_bag_file(*std::move(file), path, limits);
  if (!messages) return located(messages.error(), path);
  return OpenBag{*std::move(messages)};
}

/// The topics whose clouds are the bag's sweeps: the wanted one, or all where there are no depth pictures.
std::vector<const PictureTopic*> sweep_topics(const Ros2Survey& survey, const BagTopics& wanted) {
  std::vector<const PictureTopic*> topics;
  for (const PictureTopic& topic : survey.pictures) {
    if (!wanted.depth && topic.is_depth() && !is_infrared(topic)) return {};
    if (topic.has_sweeps && (!wanted.depth || topic.name == *wanted.depth)) topics.push_back(&topic);
  }
  return topics;
}

/// In this order: the scanner moves in tf; more clouds; the first name. Clouds that a program has put together from
/// sweeps are most often in a frame that does not move.
const PictureTopic& choose_topic(const Ros2Survey& survey, const std::vector<const PictureTopic*>& topics) {
  const auto merits = [&](const PictureTopic* topic) {
    return std::tuple(survey.tree.is_moving(topic->frame), topic->messages.size());
  };
  return **std::max_element(topics.begin(), topics.end(),
                            [&](const PictureTopic* a, const PictureTopic* b) { return merits(a) < merits(b); });
}

/// First and last offset of a sweep's points.
struct SweepSpan {
  std::int64_t first_ns = 0, last_ns = 0;
};

class BagSweeps final : public SweepSource {
 public:
  BagSweeps(std::unique_ptr<BagMessages> messages, Ros2Survey survey, const PictureTopic& topic,
            const AcquireConfig& config)
      : messages_(std::move(messages)),
        limits_(config.limits),
        topic_(topic),
        survey_(std::move(survey)),
        poses_(survey_, topic_.frame, config.topics) {}

  void describe(const fs::path& path, std::vector<std::string> warnings) {
    info_.warnings = std::move(warnings);
    info_.format = messages_->encoding() == RosEncoding::kRos1 ? "ros1" : "ros2";
    info_.folder = path;
    info_.world_up = kRosUp;
    info_.sweeps = topic_.messages.size();
    info_.expected_poses =
        "tf (or nav_msgs/Odometry) from a world to the frame '" + topic_.frame + "' of " + topic_.name +
        ", which moves; or a topic of geometry_msgs/PoseStamped with the scanner's poses (acquire.topics.poses)";
    for (const std::int64_t time_ns : topic_.times_ns) {
      poses_of_sweeps_.push_back(poses_.at(time_ns));
      if (const auto& pose = poses_of_sweeps_.back(); pose && *pose) ++info_.sweeps_with_pose;
    }
    const auto [first, last] = std::minmax_element(topic_.times_ns.begin(), topic_.times_ns.end());
    info_.duration_s = (static_cast<double>(*last) - static_cast<double>(*first)) * 1e-9;
    for (std::string& fault : messages_->faults()) info_.warnings.push_back(std::move(fault));
    tell_topics();
    if (survey_.sampled_ns) {
      info_.warnings.emplace_back(kSampleWarning);
    } else {
      tell_motion();
    }
  }

  [[nodiscard]] const SweepInfo& info() const override { return info_; }

  [[nodiscard]] std::variant<Sweep, FrameDropped> read(std::size_t index) override {
    const auto dropped = [&](DropReason reason, Error error) {
      error.where = fmt::format("{}: {}, message {}", info_.folder.string(), topic_.name, index);
      return FrameDropped{index, reason, std::move(error)};
    };
    const auto& pose = poses_of_sweeps_.at(index);
    if (!pose) return dropped(DropReason::kNoPose, {ErrorCode::kInput, "no pose; expected " + info_.expected_poses});
    if (!*pose) return dropped(DropReason::kBadPose, pose->error());
    auto sweep = decode(index);
    if (!sweep) return dropped(DropReason::kUnreadable, sweep.error());
    if (sweep->points_m.empty()) return dropped(DropReason::kNoDepth, {ErrorCode::kInput, "no point"});
    sweep->sequence = index;
    sweep->T_world_sensor = **pose;
    // Where the path does not reach over the sweep, the points stay as they are: tell_motion() has said so.
    (void)undo_motion([this](std::int64_t time_ns) { return pose_then(time_ns); }, *sweep);
    return *std::move(sweep);
  }

 private:
  [[nodiscard]] Result<Sweep> decode(std::size_t index) {
    const auto bytes = messages_->read(topic_.messages.at(index));
    if (!bytes) return bytes.error();
    return decode_cloud_sweep({*bytes, messages_->encoding()}, topic_.times_ns.at(index), limits_);
  }

  [[nodiscard]] std::optional<Pose> pose_then(std::int64_t time_ns) const {
    const auto pose = poses_.at(time_ns);
    return pose && *pose ? std::optional(**pose) : std::nullopt;
  }

  void tell_topics() {
    info_.topics["depth"] = topic_.name;
    if (poses_.are_known()) info_.topics["poses"] = poses_.source();
    if (poses_.is_of_another_frame()) {
      info_.warnings.push_back(
          fmt::format("tf does not lead from '{}' to a world: the poses of {} are taken for the scanner's",
                      topic_.frame, poses_.source()));
    }
    std::string others;
    for (const PictureTopic& topic : survey_.pictures) {
      if (topic.has_sweeps && topic.name != topic_.name) others += (others.empty() ? "" : ", ") + topic.name;
    }
    if (others.empty()) return;
    info_.topics["not_read"] = others;
    info_.warnings.push_back(
        fmt::format("the sweeps of {} are read, not those of {}: acquire.topics.depth chooses", topic_.name, others));
  }

  /// Says once what is not undone of the motion within the sweeps. The first sweep that can be read tells how long
  /// they last.
  void tell_motion() {
    const auto span = span_of_sweep();
    if (!span) {
      if (info_.sweeps_with_pose > 0 && moves()) {
        info_.warnings.push_back(fmt::format(
            "the scanner moves, and the points of {} have no times that fit those of its messages: the motion within "
            "a sweep is not undone, which is right only where the driver has done so",
            topic_.name));
      }
      return;
    }
    std::size_t beyond = 0;
    for (std::size_t i = 0; i < topic_.times_ns.size(); ++i) {
      const bool is_read = poses_of_sweeps_[i] && *poses_of_sweeps_[i];
      if (is_read && !reaches_over(topic_.times_ns[i], *span)) ++beyond;
    }
    if (beyond == 0) return;
    info_.warnings.push_back(fmt::format(
        "the poses do not reach over the whole of {} of {} sweeps, where the motion within the sweep is not undone",
        beyond, info_.sweeps_with_pose));
  }

  /// Nothing: points have no times.
  [[nodiscard]] std::optional<SweepSpan> span_of_sweep() {
    constexpr std::size_t kTries = 3;  // some may be damaged
    for (std::size_t i = 0; i < std::min(kTries, topic_.messages.size()); ++i) {
      const auto sweep = decode(i);
      if (!sweep || sweep->points_m.empty()) continue;
      if (sweep->offsets_ns.empty()) return std::nullopt;
      const auto [first, last] = std::minmax_element(sweep->offsets_ns.begin(), sweep->offsets_ns.end());
      return SweepSpan{*first, *last};
    }
    return std::nullopt;
  }

  [[nodiscard]] bool reaches_over(std::int64_t time_ns, const SweepSpan& span) const {
    std::int64_t first_ns = 0, last_ns = 0;
    if (__builtin_add_overflow(time_ns, span.first_ns, &first_ns)) return false;
    if (__builtin_add_overflow(time_ns, span.last_ns, &last_ns)) return false;
    return pose_then(first_ns).has_value() && pose_then(last_ns).has_value();
  }

  /// True if the scanner is in places that are apart by more than a LiDAR's noise.
  [[nodiscard]] bool moves() const {
    constexpr double kNoise_m = 0.02, kNoise_rad = 0.005;
    std::optional<Pose> first;
    return std::any_of(poses_of_sweeps_.begin(), poses_of_sweeps_.end(), [&](const auto& pose) {
      if (!pose || !*pose) return false;
      if (!first) first = **pose;
      const Pose change = first->inverse() * **pose;
      return change.translation().norm() > kNoise_m || Eigen::AngleAxisd(change.rotation()).angle() > kNoise_rad;
    });
  }

  std::unique_ptr<BagMessages> messages_;
  Limits limits_;
  PictureTopic topic_;
  Ros2Survey survey_;
  FramePoses poses_;  ///< of survey_
  SweepInfo info_;
  std::vector<std::optional<Result<Pose>>> poses_of_sweeps_;
};

}  // namespace

bool fits_bag_sweeps(const fs::path& path, const AcquireConfig& config) {
  const auto place = find_bag(path, config);
  if (!place || !may_have_type(*place, kCloudType, config.limits)) return false;
  const auto bag = open_bag(*place, config.limits);
  if (!bag) return false;
  const auto& topics = bag->messages->topics();
  const bool has_clouds =
      std::any_of(topics.begin(), topics.end(), [](const BagTopic& topic) { return topic.type == kCloudType; });
  if (!has_clouds) return false;
  const auto survey = survey_by_index(*bag->messages, SurveyKind::kPictures);
  return survey && !sweep_topics(*survey, config.topics).empty();
}

Result<std::unique_ptr<SweepSource>> open_bag_sweeps(const fs::path& path, const AcquireConfig& config) {
  const auto place = find_bag(path, config);
  if (!place) return Error{ErrorCode::kInput, "no bag of ROS", path.string()};
  auto bag = open_bag(*place, config.limits);
  if (!bag) return bag.error();
  return index_bag_sweeps(*std::move(bag), *place, config);
}

Result<std::unique_ptr<SweepSource>> index_bag_sweeps(OpenBag bag, const fs::path& path, const AcquireConfig& config) {
  auto survey = survey_by_index(*bag.messages, survey_kind(*bag.messages, config));
  if (!survey) return located(survey.error(), path);
  if (const auto checked = choose_topics(*survey, config.topics); !checked) return located(checked.error(), path);
  const auto topics = sweep_topics(*survey, config.topics);
  if (topics.empty()) {
    return Error{ErrorCode::kInput,
                 "a bag without LiDAR sweeps: expected sensor_msgs/PointCloud2 of height 1, or with a field 'ring'",
                 path.string()};
  }
  const PictureTopic topic = choose_topic(*survey, topics);
  auto sweeps = std::make_unique<BagSweeps>(std::move(bag.messages), *std::move(survey), topic, config);
  sweeps->describe(path, std::move(bag.warnings));
  return std::unique_ptr<SweepSource>(std::move(sweeps));
}

}  // namespace scanknit
