// Bags of ROS: depth, colour and poses of topics of standard messages (common_interfaces), in whatever file they are.
#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <utility>

#include "acquire/raw/raw_recording.h"
#include "acquire/replay/undistort.h"
#include "acquire/ros2/frame_poses.h"
#include "acquire/ros2/ros2_cloud.h"
#include "acquire/ros2/ros2_entries.h"
#include "acquire/ros2/ros2_survey.h"
#include "core/files/located.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// The camera of a topic's pictures, and how they are bent.
struct TopicLens {
  CameraIntrinsics camera;
  RationalDistortion distortion{};
  std::optional<FisheyeDistortion> fisheye = {};

  [[nodiscard]] bool bends() const { return fisheye || distortion != RationalDistortion{}; }
  template <typename Picture>
  [[nodiscard]] Picture straighten(const Picture& picture) const {
    return fisheye ? undistort(picture, camera, *fisheye) : undistort(picture, camera, distortion);
  }
};

/// By convention (image_proc) the pictures of a topic with "rect" in its name are straight, and P is their camera.
/// So are the pictures of which clouds are made.
TopicLens lens_of(const PictureTopic& topic, std::size_t picture) {
  const auto later = std::upper_bound(topic.cameras.begin(), topic.cameras.end(), topic.times_ns[picture],
                                      [](std::int64_t time_ns, const TimedCamera& at) { return time_ns < at.time_ns; });
  const Ros2Camera& camera = later == topic.cameras.begin() ? topic.cameras.front().camera : std::prev(later)->camera;
  const bool is_straight = topic.is_cloud() || topic.name.find("rect") != std::string::npos;
  return is_straight ? TopicLens{camera.rectified} : TopicLens{camera.raw, camera.distortion, camera.fisheye};
}

/// All that is needed to read a frame.
struct Ros2Recording {
  std::unique_ptr<BagMessages> messages;
  PictureTopic depth = {};
  std::optional<PictureTopic> colour = {};
  bool has_depth_lens = false;  ///< no: the configuration states the camera, or the points of a cloud tell it
  bool has_colour_lens = false;
  Pose T_colour_depth = Pose::Identity();

  [[nodiscard]] Result<RosMessage> read(std::size_t message) {
    const auto bytes = messages->read(message);
    return bytes ? Result<RosMessage>(RosMessage(*bytes, messages->encoding())) : bytes.error();
  }
};

std::optional<Drop> decode_colour(Ros2Recording& bag, const FrameEntry& entry, const Limits& limits,
                                  DecodedFrame& frame) {
  const auto message = bag.read(bag.colour->messages[entry.colour_index]);
  auto colour = message ? decode_ros2_colour(*message, bag.colour->is_compressed(), limits) : message.error();
  if (!colour) return make_drop(DropReason::kUnreadable, colour.error().message, entry.colour);
  frame.colour = std::move(colour->image);
  frame.encoded_colour = std::move(colour->encoded);
  frame.T_colour_depth = bag.T_colour_depth;
  if (!bag.has_colour_lens) return std::nullopt;
  const TopicLens lens = lens_of(*bag.colour, entry.colour_index);
  frame.colour_camera = lens.camera;
  const bool is_of_camera = frame.colour.width() == lens.camera.width && frame.colour.height() == lens.camera.height;
  if (!is_of_camera || !lens.bends()) return std::nullopt;
  frame.colour = lens.straighten(frame.colour);
  frame.encoded_colour = nullptr;
  return std::nullopt;
}

/// Depth; of a cloud also its colours and the camera that its points tell of.
Result<DecodedFrame> decode_depth_of(const PictureTopic& topic, const RosMessage& message,
                                     const DecodeSettings& settings) {
  DecodedFrame frame;
  if (topic.is_cloud()) {
    auto cloud = decode_ros2_cloud(message, settings.limits);
    if (!cloud) return cloud.error();
    frame.depth_m = std::move(cloud->depth_m);
    frame.colour = std::move(cloud->colour);
    frame.camera = cloud->camera;
    return frame;
  }
  auto depth_m = decode_ros2_depth(message, topic.is_compressed(), settings.depth_scale, settings.limits);
  if (!depth_m) return depth_m.error();
  frame.depth_m = *std::move(depth_m);
  return frame;
}

OrDrop<DecodedFrame> decode(Ros2Recording& bag, const FrameEntry& entry, const DecodeSettings& settings) {
  const auto message = bag.read(bag.depth.messages[entry.depth_index]);
  auto decoded = message ? decode_depth_of(bag.depth, *message, settings) : message.error();
  if (!decoded) return make_drop(DropReason::kUnreadable, decoded.error().message, entry.depth);
  DecodedFrame frame = *std::move(decoded);
  if (bag.has_depth_lens) {
    const TopicLens lens = lens_of(bag.depth, entry.depth_index);
    frame.camera = lens.camera;
    const bool is_of_camera =
        frame.depth_m.width() == lens.camera.width && frame.depth_m.height() == lens.camera.height;
    if (is_of_camera && lens.bends()) frame.depth_m = lens.straighten(frame.depth_m);
  }
  if (entry.colour.empty()) return frame;
  if (auto drop = decode_colour(bag, entry, settings.limits, frame)) return *std::move(drop);
  return frame;
}

std::string list_of(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 10;
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), kShown); ++i) list += (i > 0 ? ", " : "") + names[i];
  return names.size() > kShown ? list + " ..." : list;
}

/// Where LiDAR sweeps are read.
std::string sweeps_of(const Ros2Survey& survey) {
  for (const PictureTopic& topic : survey.pictures) {
    if (!topic.has_sweeps) continue;
    return " (the clouds of " + topic.name +
           " are LiDAR sweeps, which have no pictures: `scanknit run` and `info` read them, given the bag itself)";
  }
  return {};
}

Error without_depth(const Ros2Survey& survey, const fs::path& path) {
  std::vector<std::string> names;
  for (const PictureTopic& topic : survey.pictures) names.push_back(topic.name);
  names.insert(names.end(), survey.other_topics.begin(), survey.other_topics.end());
  return {ErrorCode::kInput,
          "a bag without depth pictures: expected sensor_msgs/Image of 16UC1, mono16 or 32FC1, "
          "sensor_msgs/CompressedImage of compressedDepth, or organised sensor_msgs/PointCloud2" +
              sweeps_of(survey) + "; its topics: " + (names.empty() ? "none" : list_of(names)),
          path.string()};
}

/// The topics that are read, and the other pictures.
void tell_topics(const Ros2Survey& survey, const ChosenTopics& chosen, Recording& recording) {
  recording.topics["depth"] = chosen.depth->name;
  if (chosen.colour != nullptr) recording.topics["colour"] = chosen.colour->name;
  std::vector<std::string> others;
  for (const PictureTopic& topic : survey.pictures) {
    if (&topic != chosen.depth && &topic != chosen.colour) others.push_back(topic.name);
  }
  if (!others.empty()) recording.topics["not_read"] = list_of(others);
}

void set_camera(const Ros2Survey& survey, const std::optional<std::string>& wanted, PictureTopic& topic) {
  if (wanted) topic.cameras = survey.cameras.at(*wanted);
}

void tell_faults(const Ros2Recording& bag, const ChosenTopics& chosen, Recording& recording) {
  for (std::string& fault : bag.messages->faults()) recording.warnings.push_back(std::move(fault));
  if (chosen.colour != nullptr && !chosen.T_colour_depth) {
    recording.warnings.push_back("tf does not say where '" + chosen.colour->frame + "' is beside '" +
                                 chosen.depth->frame + "': colour is taken to be where depth is");
  }
  for (const PictureTopic* topic : {chosen.depth, chosen.colour}) {
    const bool has_other_lens = topic != nullptr && !topic->cameras.empty() &&
                                topic->cameras.front().camera.has_other_lens &&
                                topic->name.find("rect") == std::string::npos;
    if (has_other_lens) {
      recording.warnings.push_back("the lens of " + topic->name +
                                   " is neither plumb_bob, rational_polynomial nor equidistant, and is "
                                   "not straightened");
    }
  }
}

}  // namespace

bool fits_ros2(const RandomAccess& file) {
  return is_bag_file(file);
}

Result<Recording> index_ros2(std::unique_ptr<RandomAccess> file, const fs::path& path, const AcquireConfig& config) {
  auto messages = open_bag_file(std::move(file), path, config.limits);
  if (!messages) return located(messages.error(), path);
  return index_bag(*std::move(messages), path, config);
}

Result<Recording> index_bag(std::unique_ptr<BagMessages> messages, const fs::path& path, const AcquireConfig& config) {
  const auto bag = std::make_shared<Ros2Recording>(Ros2Recording{std::move(messages)});
  const auto surveyed = survey_by_index(*bag->messages, survey_kind(*bag->messages, config));
  if (!surveyed) return located(surveyed.error(), path);
  const Ros2Survey& survey = *surveyed;
  const auto found = choose_topics(survey, config.topics);
  if (!found) return located(found.error(), path);
  const ChosenTopics& chosen = *found;
  if (chosen.depth == nullptr || chosen.depth->has_sweeps) return without_depth(survey, path);
  bag->depth = *chosen.depth;
  set_camera(survey, config.topics.depth_camera, bag->depth);
  if (!config.intrinsics) {
    bag->has_depth_lens = !bag->depth.cameras.empty();
    if (!bag->has_depth_lens && !bag->depth.is_cloud()) {
      return Error{ErrorCode::kInput,
                   "the camera of " + bag->depth.name + " is not known: there is no usable sensor_msgs/CameraInfo on " +
                       bag->depth.camera_topic() +
                       "; give it as acquire.intrinsics=[525,525,319.5,239.5] (fx, fy, cx, cy in pixels)",
                   path.string()};
    }
  }
  if (chosen.colour != nullptr) {
    bag->colour = *chosen.colour;
    set_camera(survey, config.topics.colour_camera, *bag->colour);
    if (!config.camera || !config.camera->colour) bag->has_colour_lens = !bag->colour->cameras.empty();
    bag->T_colour_depth = chosen.T_colour_depth.value_or(Pose::Identity());
  }
  Recording recording{.format = bag->messages->encoding() == RosEncoding::kRos1 ? "ros1" : "ros2", .folder = path};
  recording.has_metric_depth = bag->depth.content == Ros2Content::kMetricDepth;
  recording.frames_bring_camera = bag->has_depth_lens || (bag->depth.is_cloud() && !config.intrinsics);
  tell_topics(survey, chosen, recording);
  if (survey.sampled_ns) recording.warnings.emplace_back(kSampleWarning);
  tell_faults(*bag, chosen, recording);
  add_ros2_entries(survey, bag->depth, bag->colour ? &*bag->colour : nullptr, config.topics, recording);
  recording.decode = [bag](const FrameEntry& entry, const DecodeSettings& settings) {
    return decode(*bag, entry, settings);
  };
  return recording;
}

}  // namespace scanknit
