#include "acquire/ros2/ros2_survey.h"

#include <algorithm>
#include <set>
#include <tuple>
#include <utility>

namespace scanknit {
namespace {

constexpr std::string_view kCompressed = "sensor_msgs/CompressedImage";

constexpr std::size_t kTries = 3;  // pictures of a topic that are read to know its encoding: some may be damaged

enum class Role { kNone, kPicture, kCamera, kTransforms, kOdometry, kPose };

Role role_of(const std::string& type) {
  if (type == "sensor_msgs/Image" || type == kCompressed) return Role::kPicture;
  if (type == "sensor_msgs/CameraInfo") return Role::kCamera;
  if (type == "tf2_msgs/TFMessage") return Role::kTransforms;
  if (type == "nav_msgs/Odometry") return Role::kOdometry;
  const bool is_pose = type == "geometry_msgs/PoseStamped" || type == "geometry_msgs/PoseWithCovarianceStamped";
  return is_pose ? Role::kPose : Role::kNone;
}

/// "sensor_msgs/msg/Image" is also written "sensor_msgs/Image".
std::string type_of(const McapReader& reader, const McapChannel& channel) {
  if (channel.message_encoding != "cdr") return {};
  for (const McapSchema& schema : reader.schemas()) {
    if (schema.id != channel.schema_id) continue;
    std::string type = schema.name;
    if (const auto middle = type.find("/msg/"); middle != std::string::npos) type.erase(middle, 4);
    return type;
  }
  return {};
}

/// Goes over the messages of a bag once.
class Surveyor {
 public:
  explicit Surveyor(McapReader& reader) : reader_(reader) {
    for (const McapChannel& channel : reader.channels()) {
      const std::string type = type_of(reader, channel);
      const Role role = role_of(type);
      roles_[channel.id] = {role, channel.topic};
      if (role == Role::kNone) survey_.other_topics.push_back(channel.topic + " (" + type + ")");
      if (role == Role::kPicture) pictures_[channel.topic].is_compressed = type == kCompressed;
    }
  }

  [[nodiscard]] Ros2Survey survey() {
    for (const McapMessagePlace& place : reader_.messages()) {
      const auto channel = roles_.find(place.channel);
      if (channel != roles_.end()) note(channel->second.first, channel->second.second, place);
    }
    add_odometry();
    survey_.tree.sort();
    for (auto& [topic, poses] : survey_.tracked) sort_by_time(poses);
    for (auto& [name, picture] : pictures_) {
      picture.name = name;
      const auto camera = cameras_.find(picture.camera_topic());
      if (camera != cameras_.end()) picture.camera = camera->second;
      survey_.pictures.push_back(std::move(picture));
    }
    return std::move(survey_);
  }

 private:
  void note(Role role, const std::string& topic, const McapMessagePlace& place) {
    if (role == Role::kNone || (role == Role::kCamera && cameras_.contains(topic))) return;
    if (role == Role::kPicture) {
      PictureTopic& picture = pictures_[topic];
      picture.messages.push_back(place);
      if (picture.content != Ros2Content::kNone || picture.messages.size() > kTries) return;
    }
    const auto message = reader_.read(place);
    if (!message) return;
    if (role == Role::kPicture) note_content(pictures_[topic], *message);
    if (role == Role::kTransforms) note_transforms(topic, *message);
    if (role == Role::kCamera) {
      if (const auto camera = parse_camera_info(*message)) cameras_.emplace(topic, *camera);
    }
    if (role == Role::kOdometry) {
      if (auto odometry = parse_odometry(*message)) odometry_.push_back(*std::move(odometry));
    }
    if (role == Role::kPose) {
      if (auto pose = parse_pose_stamped(*message)) {
        survey_.tracked[topic].push_back({pose->stamp_ns, std::move(pose->T_parent_child)});
      }
    }
  }

  static void note_content(PictureTopic& picture, std::span<const std::byte> message) {
    if (picture.is_compressed) {
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

  void note_transforms(const std::string& topic, std::span<const std::byte> message) {
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

  McapReader& reader_;
  Ros2Survey survey_;
  std::map<std::uint16_t, std::pair<Role, std::string>> roles_;  ///< with the topic, by channel
  std::map<std::string, PictureTopic> pictures_;
  std::map<std::string, Ros2Camera> cameras_;
  std::vector<Ros2Transform> odometry_;
};

bool is_infrared(const PictureTopic& topic) {
  return topic.name.find("infra") != std::string::npos || topic.name.find("/ir/") != std::string::npos;
}

std::optional<Pose> way_between(const Ros2Survey& survey, const PictureTopic& colour, const PictureTopic& depth) {
  return colour.frame == depth.frame ? Pose::Identity() : survey.tree.between(colour.frame, depth.frame);
}

std::ptrdiff_t common_beginning(const std::string& a, const std::string& b) {
  return std::mismatch(a.begin(), a.end(), b.begin(), b.end()).first - a.begin();
}

ChosenTopics with_colour(const Ros2Survey& survey, const PictureTopic& depth) {
  ChosenTopics best{&depth, nullptr, std::nullopt};
  const auto merits = [&](const PictureTopic& colour, bool is_way_known) {
    return std::tuple(is_way_known, colour.content == Ros2Content::kColour, colour.camera.has_value(),
                      common_beginning(colour.name, depth.name), !colour.is_compressed);
  };
  for (const PictureTopic& colour : survey.pictures) {
    if (!colour.is_colour() || is_infrared(colour)) continue;
    const auto way = way_between(survey, colour, depth);
    const bool is_better = best.colour == nullptr ||
                           merits(colour, way.has_value()) > merits(*best.colour, best.T_colour_depth.has_value());
    if (is_better) best = {&depth, &colour, way};
  }
  return best;
}

}  // namespace

std::string PictureTopic::camera_topic() const {
  std::string topic = name;
  for (int last = is_compressed ? 2 : 1; last > 0; --last) topic.erase(std::min(topic.rfind('/'), topic.size()));
  return topic + "/camera_info";
}

Ros2Survey survey_ros2(McapReader& reader) {
  return Surveyor(reader).survey();
}

ChosenTopics choose_topics(const Ros2Survey& survey) {
  ChosenTopics best;
  const auto merits = [](const ChosenTopics& chosen) {
    return std::tuple(chosen.depth->camera.has_value(), chosen.T_colour_depth.has_value(),
                      chosen.depth->messages.size());
  };
  for (const PictureTopic& depth : survey.pictures) {
    if (!depth.is_depth() || is_infrared(depth)) continue;
    const ChosenTopics chosen = with_colour(survey, depth);
    if (best.depth == nullptr || merits(chosen) > merits(best)) best = chosen;
  }
  return best;
}

}  // namespace scanknit
