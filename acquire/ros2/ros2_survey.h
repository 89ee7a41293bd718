// What a bag of ROS holds: its picture topics with their cameras, and where its frames of reference are.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "acquire/bag/bag_messages.h"
#include "acquire/parse/timed_poses.h"
#include "acquire/ros2/ros2_messages.h"
#include "acquire/ros2/ros2_pictures.h"
#include "acquire/ros2/transform_tree.h"

namespace scanknit {

enum class PictureKind { kImage, kCompressed, kCloud };

/// From `time_ns` on, by the message's header.
struct TimedCamera {
  std::int64_t time_ns = 0;
  Ros2Camera camera;
};

/// A topic of sensor_msgs/Image, sensor_msgs/CompressedImage or sensor_msgs/PointCloud2.
struct PictureTopic {
  std::string name;
  PictureKind kind = PictureKind::kImage;
  bool has_colours = false;                  ///< a cloud's points have colours
  bool has_sweeps = false;                   ///< clouds that are no pictures: those of a LiDAR
  Ros2Content content = Ros2Content::kNone;  ///< of its first message that can be read
  std::string frame;                         ///< of reference, from that message
  std::vector<TimedCamera> cameras = {};     ///< of camera_info beside it, as in Ros2Survey
  std::vector<std::size_t> messages = {};
  std::vector<std::int64_t> times_ns = {};  ///< of the messages

  [[nodiscard]] bool is_cloud() const { return kind == PictureKind::kCloud; }
  [[nodiscard]] bool is_compressed() const { return kind == PictureKind::kCompressed; }
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
  /// Of topics of CameraInfo: the first camera, and each that differs from the one before, as of phones that focus. Of
  /// a sample only the first.
  std::map<std::string, std::vector<TimedCamera>> cameras;
  std::vector<std::string> other_topics;                ///< "NAME (TYPE)", in the order of their names
  std::optional<std::vector<std::int64_t>> sampled_ns;  ///< when a pose was recorded, of a sample; sorted

  [[nodiscard]] const PictureTopic* find_picture(const std::string& name) const;
};

enum class SurveyKind {
  kWhole,
  kPictures,  ///< what the pictures are, by their first messages; the times are those of recording; no poses, no
              ///< cameras
  kSample  ///< enough to describe a bag: of poses a sample, and the times when messages were recorded for the pictures'
};

/// Reads all messages but the pictures, of which it reads the first, and the time in the header of the others. Those
/// that are damaged are passed over.
[[nodiscard]] Ros2Survey survey_ros2(BagMessages& bag, SurveyKind kind = SurveyKind::kWhole);

/// A sample for the description of a large bag; else the whole.
[[nodiscard]] SurveyKind survey_kind(const BagMessages& bag, const AcquireConfig& config);

/// survey_ros2() of a bag that may have an index. Where that turns out to be wrong, once more without it. Errors
/// (kInput, without `where`): those of opening.
[[nodiscard]] Result<Ros2Survey> survey_by_index(BagMessages& bag, SurveyKind kind);

/// An infrared picture is no depth, whatever its encoding.
[[nodiscard]] bool is_infrared(const PictureTopic& topic);

/// The depth topic that is read, and its colour.
struct ChosenTopics {
  const PictureTopic* depth = nullptr;   ///< null: there is none
  const PictureTopic* colour = nullptr;  ///< null: there is none
  std::optional<Pose> T_colour_depth;    ///< nothing: the bag does not say it
};

/// Those that `wanted` names. Else in this order: depth in pictures, not in clouds; depth with a camera; depth whose
/// place beside its colour is known; more pictures; the first name. Of colour: its place beside depth is known; no
/// grey; with a camera; the longest common beginning of the names; not compressed; the first name. Infrared pictures
/// are neither. A cloud whose points have colours needs no other. Errors (kInput, without `where`): there is no such
/// topic, or it is of another kind.
[[nodiscard]] Result<ChosenTopics> choose_topics(const Ros2Survey& survey, const BagTopics& wanted);

}  // namespace scanknit
