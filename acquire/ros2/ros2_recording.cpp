// Bags of ROS 2 in MCAP files (rosbag2_storage_mcap): topics of standard messages, in CDR.
#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>

#include "acquire/replay/frame_pairing.h"
#include "acquire/replay/raw_recording.h"
#include "acquire/replay/undistort.h"
#include "acquire/ros2/cdr_reader.h"
#include "acquire/ros2/ros2_survey.h"
#include "core/files/located.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// The camera of a topic's pictures, and how they are bent.
struct TopicLens {
  CameraIntrinsics camera;
  RationalDistortion distortion{};

  [[nodiscard]] bool bends() const { return distortion != RationalDistortion{}; }
};

/// By convention (image_proc) the pictures of a topic with "rect" in its name are straight, and P is their camera.
std::optional<TopicLens> lens_of(const PictureTopic& topic) {
  if (!topic.camera) return std::nullopt;
  const bool is_straight = topic.name.find("rect") != std::string::npos;
  return is_straight ? TopicLens{topic.camera->rectified} : TopicLens{topic.camera->raw, topic.camera->distortion};
}

/// All that is needed to read a frame.
struct Ros2Recording {
  McapReader reader;
  PictureTopic depth = {};
  std::optional<PictureTopic> colour = {};
  std::optional<TopicLens> depth_lens = {};  ///< nothing: the configuration states the camera
  std::optional<TopicLens> colour_lens = {};
  Pose T_colour_depth = Pose::Identity();
};

std::optional<Drop> decode_colour(Ros2Recording& bag, const FrameEntry& entry, const Limits& limits,
                                  DecodedFrame& frame) {
  const auto message = bag.reader.read(bag.colour->messages[entry.colour_index]);
  auto colour = message ? decode_ros2_colour(*message, bag.colour->is_compressed, limits) : message.error();
  if (!colour) return make_drop(DropReason::kUnreadable, colour.error().message, entry.colour);
  frame.colour = std::move(colour->image);
  frame.encoded_colour = std::move(colour->encoded);
  frame.T_colour_depth = bag.T_colour_depth;
  if (!bag.colour_lens) return std::nullopt;
  frame.colour_camera = bag.colour_lens->camera;
  const bool is_of_camera =
      frame.colour.width() == bag.colour_lens->camera.width && frame.colour.height() == bag.colour_lens->camera.height;
  if (!is_of_camera || !bag.colour_lens->bends()) return std::nullopt;
  frame.colour = undistort(frame.colour, bag.colour_lens->camera, bag.colour_lens->distortion);
  frame.encoded_colour = nullptr;
  return std::nullopt;
}

OrDrop<DecodedFrame> decode(Ros2Recording& bag, const FrameEntry& entry, const DecodeSettings& settings) {
  const auto message = bag.reader.read(bag.depth.messages[entry.depth_index]);
  auto depth_m = message ? decode_ros2_depth(*message, bag.depth.is_compressed, settings.depth_scale, settings.limits)
                         : message.error();
  if (!depth_m) return make_drop(DropReason::kUnreadable, depth_m.error().message, entry.depth);
  DecodedFrame frame;
  frame.depth_m = *std::move(depth_m);
  if (bag.depth_lens) {
    frame.camera = bag.depth_lens->camera;
    const bool is_of_camera =
        frame.depth_m.width() == frame.camera->width && frame.depth_m.height() == frame.camera->height;
    if (is_of_camera && bag.depth_lens->bends()) {
      frame.depth_m = undistort(frame.depth_m, *frame.camera, bag.depth_lens->distortion);
    }
  }
  if (entry.colour.empty()) return frame;
  if (auto drop = decode_colour(bag, entry, settings.limits, frame)) return *std::move(drop);
  return frame;
}

/// The time in its header; the time of recording where that is 0 or cannot be read.
std::int64_t time_of(McapReader& reader, const McapMessagePlace& place) {
  std::array<std::byte, 12> front{};  // CDR's head, seconds, nanoseconds
  const auto recorded_ns = static_cast<std::int64_t>(place.log_ns);
  if (!reader.peek(place, front)) return recorded_ns;
  auto cdr = CdrReader::open(front);
  const auto seconds = cdr ? cdr->number<std::int32_t>() : std::nullopt;
  const auto nanoseconds = cdr ? cdr->number<std::uint32_t>() : std::nullopt;
  if (!seconds || !nanoseconds || (*seconds == 0 && *nanoseconds == 0)) return recorded_ns;
  return std::int64_t{*seconds} * 1'000'000'000 + *nanoseconds;
}

std::vector<std::int64_t> times_of(McapReader& reader, const PictureTopic& topic) {
  std::vector<std::int64_t> times_ns;
  for (const McapMessagePlace& place : topic.messages) times_ns.push_back(time_of(reader, place));
  return times_ns;
}

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

/// Where the depth camera was; sets whence that is known.
class DepthPoses {
 public:
  DepthPoses(const Ros2Survey& survey, const std::string& depth_frame, Recording& recording)
      : survey_(survey), frame_(depth_frame), is_in_tree_(survey.tree.is_moving(depth_frame)) {
    if (is_in_tree_) {
      recording.topics["poses"] = "tf: " + survey.tree.root_of(frame_) + " from " + frame_;
    } else if (!survey.tracked.empty()) {
      const auto most =
          std::max_element(survey.tracked.begin(), survey.tracked.end(),
                           [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); });
      tracked_ = &most->second;
      recording.topics["poses"] = most->first;
      recording.warnings.push_back("tf does not lead from '" + frame_ + "' to a world: the poses of " + most->first +
                                   " are taken for the depth camera's");
    }
    // ROS has z up in all worlds (REP 103).
    if (is_in_tree_ || tracked_ != nullptr) recording.world_up = UpAxis::kZ;
  }

  [[nodiscard]] std::optional<Result<Pose>> at(std::int64_t time_ns) const {
    if (is_in_tree_) return survey_.tree.pose_in_root(frame_, time_ns);
    return tracked_ != nullptr ? pose_at(*tracked_, time_ns) : std::nullopt;
  }

 private:
  const Ros2Survey& survey_;
  std::string frame_;
  bool is_in_tree_;
  const std::vector<TimedPose>* tracked_ = nullptr;
};

std::string list_of(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 10;
  std::string list;
  for (std::size_t i = 0; i < std::min(names.size(), kShown); ++i) list += (i > 0 ? ", " : "") + names[i];
  return names.size() > kShown ? list + " ..." : list;
}

Error without_depth(const Ros2Survey& survey, const fs::path& path) {
  std::vector<std::string> names;
  for (const PictureTopic& topic : survey.pictures) names.push_back(topic.name);
  names.insert(names.end(), survey.other_topics.begin(), survey.other_topics.end());
  return {ErrorCode::kInput,
          "a bag without depth pictures: expected sensor_msgs/Image of 16UC1, mono16 or 32FC1, or "
          "sensor_msgs/CompressedImage of compressedDepth; its topics: " +
              (names.empty() ? "none" : list_of(names)),
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

void tell_faults(const Ros2Recording& bag, const ChosenTopics& chosen, Recording& recording) {
  if (const auto& fault = bag.reader.fault()) {
    recording.warnings.push_back("the bag is torn: " + *fault + ". What is whole in it is read");
  }
  if (chosen.colour != nullptr && !chosen.T_colour_depth) {
    recording.warnings.push_back("tf does not say where '" + chosen.colour->frame + "' is beside '" +
                                 chosen.depth->frame + "': colour is taken to be where depth is");
  }
  for (const PictureTopic* topic : {chosen.depth, chosen.colour}) {
    const bool has_other_lens = topic != nullptr && topic->camera && topic->camera->has_other_lens &&
                                topic->name.find("rect") == std::string::npos;
    if (has_other_lens) {
      recording.warnings.push_back("the lens of " + topic->name +
                                   " is neither plumb_bob nor rational_polynomial, and is "
                                   "not straightened");
    }
  }
}

void add_entries(Ros2Recording& bag, const DepthPoses& poses, Recording& recording) {
  const auto depth_ns = times_of(bag.reader, bag.depth);
  const auto colour_ns = bag.colour ? times_of(bag.reader, *bag.colour) : std::vector<std::int64_t>();
  const auto partners = pair_by_time(depth_ns, colour_ns, reach_ns(colour_ns));
  for (std::size_t i = 0; i < depth_ns.size(); ++i) {
    FrameEntry entry{.sequence = i, .timestamp_ns = depth_ns[i]};
    entry.depth = recording.folder;
    entry.depth_index = i;
    if (partners[i]) {
      entry.colour = recording.folder;
      entry.colour_index = *partners[i];
    }
    entry.T_world_camera = poses.at(depth_ns[i]);
    recording.entries.push_back(std::move(entry));
  }
}

}  // namespace

bool fits_ros2(const RandomAccess& file) {
  return mcap_profile(file) == "ros2";
}

Result<Recording> index_ros2(std::unique_ptr<RandomAccess> access, const fs::path& path, const AcquireConfig& config) {
  auto reader = McapReader::open(std::move(access), config.limits);
  if (!reader) return located(reader.error(), path);
  return index_ros2(*std::move(reader), path, config);
}

Result<Recording> index_ros2(McapReader reader, const fs::path& path, const AcquireConfig& config) {
  const auto bag = std::make_shared<Ros2Recording>(Ros2Recording{std::move(reader)});
  const Ros2Survey survey = survey_ros2(bag->reader);
  const ChosenTopics chosen = choose_topics(survey);
  if (chosen.depth == nullptr) return without_depth(survey, path);
  bag->depth = *chosen.depth;
  if (!config.intrinsics) {
    bag->depth_lens = lens_of(bag->depth);
    if (!bag->depth_lens) {
      return Error{ErrorCode::kInput,
                   "the camera of " + bag->depth.name + " is not known: there is no usable sensor_msgs/CameraInfo on " +
                       bag->depth.camera_topic() +
                       "; give it as acquire.intrinsics=[525,525,319.5,239.5] (fx, fy, cx, cy in pixels)",
                   path.string()};
    }
  }
  if (chosen.colour != nullptr) {
    bag->colour = *chosen.colour;
    bag->colour_lens = lens_of(*bag->colour);
    bag->T_colour_depth = chosen.T_colour_depth.value_or(Pose::Identity());
  }
  Recording recording{.format = "ros2", .folder = path};
  recording.has_metric_depth = bag->depth.content == Ros2Content::kMetricDepth;
  recording.frames_bring_camera = bag->depth_lens.has_value();
  tell_topics(survey, chosen, recording);
  tell_faults(*bag, chosen, recording);
  const DepthPoses poses(survey, bag->depth.frame, recording);
  add_entries(*bag, poses, recording);
  recording.decode = [bag](const FrameEntry& entry, const DecodeSettings& settings) {
    return decode(*bag, entry, settings);
  };
  return recording;
}

}  // namespace scanknit
