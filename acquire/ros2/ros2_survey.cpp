#include "acquire/ros2/ros2_survey.h"

#include <algorithm>
#include <array>
#include <set>
#include <tuple>
#include <utility>

#include "acquire/ros2/cdr_reader.h"
#include "acquire/ros2/ros2_cloud.h"

namespace scanknit {
namespace {

constexpr const char* kWithoutColour = "none";

constexpr std::size_t kTries = 3;  // pictures of a topic that are read to know its encoding: some may be damaged

enum class Role { kNone, kPicture, kCamera, kTransforms, kOdometry, kPose };

std::optional<PictureKind> kind_of(const std::string& type) {
  if (type == "sensor_msgs/Image") return PictureKind::kImage;
  if (type == "sensor_msgs/CompressedImage") return PictureKind::kCompressed;
  if (type == "sensor_msgs/PointCloud2") return PictureKind::kCloud;
  return std::nullopt;
}

Role role_of(const std::string& type) {
  if (kind_of(type)) return Role::kPicture;
  if (type == "sensor_msgs/CameraInfo") return Role::kCamera;
  if (type == "tf2_msgs/TFMessage") return Role::kTransforms;
  if (type == "nav_msgs/Odometry") return Role::kOdometry;
  const bool is_pose = type == "geometry_msgs/PoseStamped" || type == "geometry_msgs/PoseWithCovarianceStamped";
  return is_pose ? Role::kPose : Role::kNone;
}

/// The time in its header; the time of recording where that is 0 or cannot be read.
std::int64_t time_of(BagMessages& bag, std::size_t message) {
  std::array<std::byte, 12> front{};  // CDR's head or ROS 1's number, seconds, nanoseconds
  const std::int64_t recorded_ns = bag.entry(message).log_ns;
  if (!bag.peek(message, front)) return recorded_ns;
  auto cdr = CdrReader::open({front, bag.encoding()});
  if (cdr && cdr->is_ros1()) (void)cdr->number<std::uint32_t>();
  const auto seconds = cdr ? cdr->number<std::int32_t>() : std::nullopt;
  const auto nanoseconds = cdr ? cdr->number<std::uint32_t>() : std::nullopt;
  if (!seconds || !nanoseconds || (*seconds == 0 && *nanoseconds == 0)) return recorded_ns;
  return std::int64_t{*seconds} * 1'000'000'000 + *nanoseconds;
}

/// Goes over the messages of a bag once.
class Surveyor {
 public:
  Surveyor(BagMessages& bag, SurveyKind kind)
      : bag_(bag), is_sample_(kind == SurveyKind::kSample), is_of_pictures_(kind == SurveyKind::kPictures) {
    for (const BagTopic& topic : bag.topics()) {
      const Role role = role_of(topic.type);
      roles_.push_back(role);
      if (role == Role::kNone) survey_.other_topics.push_back(topic.name + " (" + topic.type + ")");
      if (role == Role::kPicture) pictures_[topic.name].kind = *kind_of(topic.type);
    }
  }

  [[nodiscard]] Ros2Survey survey() {
    if (is_sample_) begin_sample();
    for (std::size_t i = 0; i < bag_.size(); ++i) {
      const std::size_t topic = bag_.entry(i).topic;
      note(roles_[topic], bag_.topics()[topic].name, i);
    }
    add_odometry();
    survey_.tree.sort();
    if (survey_.sampled_ns) std::sort(survey_.sampled_ns->begin(), survey_.sampled_ns->end());
    std::sort(survey_.other_topics.begin(), survey_.other_topics.end());
    for (auto& [topic, poses] : survey_.tracked) sort_by_time(poses);
    for (auto& [topic, cameras] : survey_.cameras) {
      std::stable_sort(cameras.begin(), cameras.end(),
                       [](const TimedCamera& a, const TimedCamera& b) { return a.time_ns < b.time_ns; });
    }
    for (auto& [name, picture] : pictures_) {
      picture.name = name;
      const auto camera = survey_.cameras.find(picture.camera_topic());
      if (camera != survey_.cameras.end()) picture.cameras = camera->second;
      survey_.pictures.push_back(std::move(picture));
    }
    return std::move(survey_);
  }

 private:
  [[nodiscard]] bool has_log_times() const { return is_sample_ || is_of_pictures_; }

  static bool is_of_poses(Role role) {
    return role == Role::kTransforms || role == Role::kOdometry || role == Role::kPose;
  }

  /// Counts the messages of each topic of poses.
  void begin_sample() {
    survey_.sampled_ns.emplace();
    counts_.resize(roles_.size());
    seen_.resize(roles_.size());
    for (std::size_t i = 0; i < bag_.size(); ++i) ++counts_[bag_.entry(i).topic];
  }

  /// About fifty of a topic's messages, evenly, as many chunks are unpacked; of tf_static, to which each node adds its
  /// own, also the first ones.
  [[nodiscard]] bool is_in_sample(const std::string& topic, std::size_t number) {
    constexpr std::size_t kSampled = 50;
    constexpr std::size_t kFirst = 1000;
    const BagEntry entry = bag_.entry(number);
    survey_.sampled_ns->push_back(entry.log_ns);
    const std::size_t step = counts_[entry.topic] / kSampled + 1;
    const std::size_t seen = seen_[entry.topic]++;
    return seen % step == 0 || (topic.ends_with("tf_static") && seen < kFirst);
  }

  void note(Role role, const std::string& topic, std::size_t number) {
    if (role == Role::kNone || (role == Role::kCamera && is_sample_ && survey_.cameras.contains(topic))) return;
    if (is_of_pictures_ && role != Role::kPicture) return;
    if (role == Role::kPicture) {
      PictureTopic& picture = pictures_[topic];
      picture.messages.push_back(number);
      picture.times_ns.push_back(has_log_times() ? bag_.entry(number).log_ns : time_of(bag_, number));
      if (picture.content != Ros2Content::kNone || picture.messages.size() > kTries) return;
    }
    if (is_sample_ && is_of_poses(role) && !is_in_sample(topic, number)) return;
    const auto bytes = role == Role::kPicture ? bag_.read(number) : bag_.read_alone(number);
    if (!bytes) return;
    const RosMessage message(*bytes, bag_.encoding());
    if (role == Role::kPicture) note_content(pictures_[topic], message);
    if (role == Role::kTransforms) note_transforms(topic, message);
    if (role == Role::kCamera) {
      if (const auto camera = parse_camera_info(message)) note_camera(survey_.cameras[topic], number, *camera);
    }
    if (role == Role::kOdometry) {
      if (auto odometry = parse_odometry(message)) odometry_.push_back(*std::move(odometry));
    }
    if (role == Role::kPose) {
      if (auto pose = parse_pose_stamped(message)) {
        survey_.tracked[topic].push_back({pose->stamp_ns, std::move(pose->T_parent_child)});
      }
    }
  }

  static void note_content(PictureTopic& picture, const RosMessage& message) {
    if (picture.is_cloud()) {
      const auto cloud = parse_cloud_head(message);
      if (!cloud) return;
      picture.content = cloud->is_picture ? Ros2Content::kMetricDepth : Ros2Content::kNone;
      // Frames whose z is forward are named "..._optical_frame" (REP 103): a list of a depth camera's points.
      picture.has_sweeps = !cloud->is_picture && cloud->header.frame.find("optical") == std::string::npos;
      picture.has_colours = cloud->has_colour;
      picture.frame = cloud->header.frame;
    } else if (picture.is_compressed()) {
      const auto image = parse_compressed_image(message);
      if (!image) return;
      picture.content = content_of_format(image->format);
      picture.frame = image->header.frame;
    } else {
      const auto image = parse_image(message);
      if (!image) return;
      picture.content = content_of_encoding(image->encoding);
      picture.frame = image->header.frame;
    }
  }

  void note_camera(std::vector<TimedCamera>& cameras, std::size_t number, const Ros2Camera& camera) {
    if (cameras.empty() || cameras.back().camera != camera) cameras.push_back({time_of(bag_, number), camera});
  }

  void note_transforms(const std::string& topic, const RosMessage& message) {
    auto transforms = parse_transforms(message);
    if (!transforms) return;
    const bool is_static = topic.ends_with("tf_static");
    for (Ros2Transform& transform : *transforms) survey_.tree.add(std::move(transform), is_static);
  }

  /// Of children of which tf says nothing: it often repeats what tf says.
  void add_odometry() {
    std::set<std::string> added;
    for (Ros2Transform& transform : odometry_) {
      if (survey_.tree.has_parent(transform.child) && !added.contains(transform.child)) continue;
      added.insert(transform.child);
      survey_.tree.add(std::move(transform), false);
    }
  }

  BagMessages& bag_;
  bool is_sample_, is_of_pictures_;
  Ros2Survey survey_;
  std::vector<Role> roles_;                 ///< by topic
  std::vector<std::size_t> counts_, seen_;  ///< of messages, by topic; only for a sample
  std::map<std::string, PictureTopic> pictures_;
  std::vector<Ros2Transform> odometry_;
};

std::optional<Pose> way_between(const Ros2Survey& survey, const PictureTopic& colour, const PictureTopic& depth) {
  return colour.frame == depth.frame ? Pose::Identity() : survey.tree.between(colour.frame, depth.frame);
}

std::ptrdiff_t common_beginning(const std::string& a, const std::string& b) {
  return std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin();
}

ChosenTopics with_colour(const Ros2Survey& survey, const PictureTopic& depth, const BagTopics& wanted) {
  ChosenTopics best{&depth, nullptr, std::nullopt};
  const bool has_its_own = depth.is_cloud() && depth.has_colours;
  if (wanted.colour == kWithoutColour || (has_its_own && !wanted.colour)) return best;
  const auto merits = [&](const PictureTopic& colour, bool is_way_known) {
    return std::tuple(is_way_known, colour.content == Ros2Content::kColour, !colour.cameras.empty(),
                      common_beginning(colour.name, depth.name), !colour.is_compressed());
  };
  for (const PictureTopic& colour : survey.pictures) {
    const bool is_candidate =
        wanted.colour ? colour.name == *wanted.colour : colour.is_colour() && !is_infrared(colour);
    if (!is_candidate) continue;
    const auto way = way_between(survey, colour, depth);
    const bool is_better = best.colour == nullptr ||
                           merits(colour, way.has_value()) > merits(*best.colour, best.T_colour_depth.has_value());
    if (is_better) best = {&depth, &colour, way};
  }
  return best;
}

template <typename Names>
Error no_such_topic(const char* key, const std::string& name, const char* what, const Names& there) {
  std::string list;
  for (const std::string& other : there) list += (list.empty() ? "" : ", ") + other;
  return {ErrorCode::kInput, std::string("acquire.topics.") + key + ": the bag has no topic '" + name + "' of " + what +
                                 "; it has " + (list.empty() ? "none" : list)};
}

std::vector<std::string> names_of(const std::vector<PictureTopic>& topics, bool (PictureTopic::*is_of_kind)() const) {
  std::vector<std::string> names;
  for (const PictureTopic& topic : topics) {
    if ((topic.*is_of_kind)()) names.push_back(topic.name);
  }
  return names;
}

template <typename Map>
std::vector<std::string> keys_of(const Map& map) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : map) keys.push_back(key);
  return keys;
}

/// Clouds that are sweeps pass: of them a later message tells.
Result<void> check_wanted(const Ros2Survey& survey, const BagTopics& wanted) {
  const auto has = [](const std::vector<std::string>& names, const std::optional<std::string>& name) {
    return !name || std::find(names.begin(), names.end(), *name) != names.end();
  };
  const PictureTopic* depth_topic = wanted.depth ? survey.find_picture(*wanted.depth) : nullptr;
  const auto depth = names_of(survey.pictures, &PictureTopic::is_depth);
  const auto colour = names_of(survey.pictures, &PictureTopic::is_colour);
  const auto cameras = keys_of(survey.cameras);
  const auto poses = keys_of(survey.tracked);
  const bool has_sweeps = depth_topic != nullptr && depth_topic->has_sweeps;
  if (!has(depth, wanted.depth) && !has_sweeps) return no_such_topic("depth", *wanted.depth, "depth", depth);
  if (wanted.colour != kWithoutColour && !has(colour, wanted.colour)) {
    return no_such_topic("colour", *wanted.colour, "colour", colour);
  }
  if (!has(cameras, wanted.depth_camera)) {
    return no_such_topic("depth_camera", *wanted.depth_camera, "a usable sensor_msgs/CameraInfo", cameras);
  }
  if (!has(cameras, wanted.colour_camera)) {
    return no_such_topic("colour_camera", *wanted.colour_camera, "a usable sensor_msgs/CameraInfo", cameras);
  }
  if (!has(poses, wanted.poses)) return no_such_topic("poses", *wanted.poses, "geometry_msgs/PoseStamped", poses);
  return {};
}

}  // namespace

std::string PictureTopic::camera_topic() const {
  std::string topic = name;
  for (int last = is_compressed() ? 2 : 1; last > 0; --last) topic.erase(std::min(topic.rfind('/'), topic.size()));
  return topic + "/camera_info";
}

Ros2Survey survey_ros2(BagMessages& bag, SurveyKind kind) {
  return Surveyor(bag, kind).survey();
}

const PictureTopic* Ros2Survey::find_picture(const std::string& name) const {
  const auto found =
      std::find_if(pictures.begin(), pictures.end(), [&](const PictureTopic& topic) { return topic.name == name; });
  return found == pictures.end() ? nullptr : &*found;
}

bool is_infrared(const PictureTopic& topic) {
  return topic.name.find("infra") != std::string::npos || topic.name.find("/ir/") != std::string::npos;
}

SurveyKind survey_kind(const BagMessages& bag, const AcquireConfig& config) {
  constexpr std::uint64_t kLarge = 256u << 20;   // compressed: more than a second
  constexpr std::size_t kManyMessages = 50'000;  // their poses and cameras would take tens of megabytes
  const bool is_large = bag.indexed_bytes() > kLarge || bag.size() > kManyMessages;
  const bool is_sample = config.only_describes && is_large;
  return is_sample ? SurveyKind::kSample : SurveyKind::kWhole;
}

Result<Ros2Survey> survey_by_index(BagMessages& bag, SurveyKind kind) {
  Ros2Survey survey = survey_ros2(bag, kind);
  const auto dropped = bag.drop_wrong_index();
  if (!dropped) return dropped.error();
  if (!*dropped) return survey;
  return survey_ros2(bag, kind == SurveyKind::kSample ? SurveyKind::kWhole : kind);
}

Result<ChosenTopics> choose_topics(const Ros2Survey& survey, const BagTopics& wanted) {
  if (const auto checked = check_wanted(survey, wanted); !checked) return checked.error();
  ChosenTopics best;
  const auto merits = [](const ChosenTopics& chosen) {
    return std::tuple(!chosen.depth->is_cloud(), !chosen.depth->cameras.empty(), chosen.T_colour_depth.has_value(),
                      chosen.depth->messages.size());
  };
  for (const PictureTopic& depth : survey.pictures) {
    const bool is_candidate = wanted.depth ? depth.name == *wanted.depth : depth.is_depth() && !is_infrared(depth);
    if (!is_candidate) continue;
    const ChosenTopics chosen = with_colour(survey, depth, wanted);
    if (best.depth == nullptr || merits(chosen) > merits(best)) best = chosen;
  }
  return best;
}

}  // namespace scanknit
