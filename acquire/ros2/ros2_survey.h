// What a bag of ROS 2 holds: its picture topics with their cameras, and where its frames of reference are.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquire/layouts/timed_poses.h"
#include "acquire/mcap/mcap_reader.h"
#include "acquire/ros2/ros2_messages.h"
#include "acquire/ros2/ros2_pictures.h"
#include "acquire/ros2/transform_tree.h"

namespace scanknit {

/// A topic of sensor_msgs/Image or sensor_msgs/CompressedImage.
struct PictureTopic {
  std::string name;
  bool is_compressed = false;
  Ros2Content content = Ros2Content::kNone;  ///< of its first message that can be read
  std::string frame;                         ///< of reference, from that message
  std::optional<Ros2Camera> camera = {};     ///< of camera_info beside it
  std::vector<McapMessagePlace> messages = {};

  [[nodiscard]] bool is_depth() const {
    return content == Ros2Content::kRawDepth || content == Ros2Content::kMetricDepth;
  }
  [[nodiscard]] bool is_colour() const { return content == Ros2Content::kColour || content == Ros2Content::kGrey; }
  /// The topic of its camera: that of the picture with "camera_info" for its last word.
  [[nodiscard]] std::string camera_topic() const;
};

struct Ros2Survey {
  std::vector<PictureTopic> pictures;                     ///< in the order of their names
  TransformTree tree;                                     ///< of tf, tf_static and Odometry
  std::map<std::string, std::vector<TimedPose>> tracked;  ///< of topics of PoseStamped, sorted by time
  std::vector<std::string> other_topics;                  ///< "NAME (TYPE)"
};

/// Reads all messages but the pictures, of which it reads the first. Those that are damaged are passed over.
[[nodiscard]] Ros2Survey survey_ros2(McapReader& reader);

/// The depth topic that is read, and its colour.
struct ChosenTopics {
  const PictureTopic* depth = nullptr;   ///< null: there is none
  const PictureTopic* colour = nullptr;  ///< null: there is none
  std::optional<Pose> T_colour_depth;    ///< nothing: the bag does not say it
};

/// In this order: depth with a camera; depth whose place beside its colour is known; more pictures; the first name. Of
/// colour: its place beside depth is known; no grey; with a camera; the longest common beginning of the names; not
/// compressed; the first name. Infrared pictures are neither.
[[nodiscard]] ChosenTopics choose_topics(const Ros2Survey& survey);

}  // namespace scanknit
