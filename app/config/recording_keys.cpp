#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "acquire/recording_format.h"
#include "app/config/config_keys.h"

namespace scanknit {
namespace {

using namespace config_keys;

/// Null is `auto`.
ConfigKey camera_key() {
  using Camera = std::shared_ptr<const ScannerCamera>;
  ConfigKey key = describe(ConfigType::kCamera,
                           {"acquire.camera", "",
                            "The calibration of the scanner, which `calibrate camera` wrote: lenses, the pose and the "
                            "time between both cameras, the systematic error of depth. auto: as the recording says."});
  key.allows_auto = true;
  key.get = [](const ScanConfig& config) {
    return config.acquire.camera ? ConfigValue(config.acquire.camera) : ConfigValue();
  };
  key.set = [](ScanConfig& config, const ConfigValue& value) {
    const auto* camera = std::get_if<Camera>(&value);
    config.acquire.camera = camera != nullptr ? *camera : nullptr;
  };
  return key;
}

/// What a recording's pictures mean.
std::vector<ConfigKey> picture_keys() {
  ConfigKey depth_scale = describe(ConfigType::kNumber,
                                   {"acquire.depth_scale", "1/m",
                                    "Raw units of the depth pictures per metre: 1000 for millimetres, 5000 for TUM "
                                    "recordings. auto: what the recording says, else what its layout usually has."},
                                   {1e-3, 1e7});
  bind_optional<double>(
      depth_scale, [](auto& c) -> auto& { return c.acquire.depth_scale; });

  ConfigKey intrinsics = describe(ConfigType::kIntrinsics,
                                  {"acquire.intrinsics", "pixels",
                                   "The depth camera: [fx, fy, cx, cy], or a map of width, height, fx, fy, cx, cy and "
                                   "distortion: [k1, k2, p1, p2, k3], or the name of a file that holds a 3x3 matrix, "
                                   "an Open3D camera_intrinsic.json or such a map. auto: as the recording says."});
  bind_optional<CameraModel>(
      intrinsics, [](auto& c) -> auto& { return c.acquire.intrinsics; });

  return {
      choice<RecordingFormat>(
          {"acquire.format", "", "Layout of the recording. auto: recognised by its content."},
          {{"auto", RecordingFormat::kAuto},
           {"7-scenes", RecordingFormat::kSevenScenes},
           {"tum", RecordingFormat::kTum},
           {"open3d", RecordingFormat::kOpen3d},
           {"nerfstudio", RecordingFormat::kNerfstudio},
           {"phone-lidar", RecordingFormat::kPhoneLidar},
           {"stray-scanner", RecordingFormat::kStrayScanner},
           {"arkitscenes", RecordingFormat::kArkitscenes},
           {"polycam", RecordingFormat::kPolycam},
           {"record3d", RecordingFormat::kRecord3d},
           {"replica", RecordingFormat::kReplica},
           {"bop", RecordingFormat::kBop},
           {"pcd", RecordingFormat::kPcd},
           {"pclzf", RecordingFormat::kPclzf},
           {"fakenect", RecordingFormat::kFakenect},
           {"mcap", RecordingFormat::kMcap},
           {"ros2", RecordingFormat::kRos2},
           {"ros1", RecordingFormat::kRos1},
           {"realsense-bag", RecordingFormat::kRealsenseBag},
           {"oni", RecordingFormat::kOni},
           {"sens", RecordingFormat::kSens},
           {"azure-mkv", RecordingFormat::kAzureMkv}},
          [](auto& c) -> auto& { return c.acquire.format; }),
      std::move(depth_scale),
      std::move(intrinsics),
      camera_key(),
  };
}

/// Pictures without depth, and masks.
std::vector<ConfigKey> mask_keys() {
  ConfigKey masks = describe(
      ConfigType::kPath,
      {"acquire.masks", "",
       "The folder of masks, as seen from the recording's: pictures with the names of depth or colour, white where the "
       "thing is; or alpha: the colour pictures' own; or chroma: what is not of the green or blue screen behind the "
       "thing; or grabcut: what stands out from the picture's rim. Only depth within them is fused. auto: all depth, "
       "or what acquire.background says; of silhouettes what "
       "the layout names, else masks, mask or silhouettes, else the "
       "pictures' own alpha."});
  bind_optional<std::string>(
      masks, [](auto& c) -> auto& { return c.acquire.masks; });
  ConfigKey mask_class = describe(
      ConfigType::kInteger,
      {"acquire.mask_class", "", "The value of the masks' pixels that are the thing. auto: the brighter half."},
      {0, 255});
  bind_optional<std::int64_t>(
      mask_class, [](auto& c) -> auto& { return c.acquire.mask_class; });
  ConfigKey background = describe(
      ConfigType::kPath, {"acquire.background", "",
                          "A colour picture of the same camera and place without the thing, for pictures without "
                          "masks; its path begins where the program runs. What differs from it is the thing."});
  bind_optional<std::string>(
      background, [](auto& c) -> auto& { return c.acquire.background; });
  return {
      choice<Geometry>(
          {"acquire.geometry", "",
           "What becomes the volume. depth: depth pictures are fused; silhouettes: pictures without depth, from known "
           "places, carve a visual hull out of their masks; stereo: pairs of pictures of one rig become depth, also "
           "the infrared pairs of a RealSense that is plugged in."},
          {{"depth", Geometry::kDepth}, {"silhouettes", Geometry::kSilhouettes}, {"stereo", Geometry::kStereo}},
          [](auto& c) -> auto& { return c.acquire.geometry; }),
      std::move(masks),
      std::move(mask_class),
      choice<MaskMeans>(
          {"acquire.mask_means", "",
           "What depth outside of a mask says. unknown: nothing; free: the space before it is free, so that what masks "
           "took in by mistake there is carved away. Nothing outside becomes a surface."},
          {{"unknown", MaskMeans::kUnknown}, {"free", MaskMeans::kFree}},
          [](auto& c) -> auto& { return c.acquire.mask_means; }),
      std::move(background),
  };
}

/// The topics of a bag of ROS.
std::vector<ConfigKey> topic_keys() {
  const auto topic = [](const Key& description, std::optional<std::string> BagTopics::*member) {
    ConfigKey key = describe(ConfigType::kTopic, description);
    bind_optional<std::string>(
        key, [member](auto& c) -> auto& { return c.acquire.topics.*member; });
    return key;
  };
  return {
      topic(
          {"acquire.topics.depth", "",
           "ROS: the topic of depth pictures, or of organised point clouds. auto: chosen by what the bag says; `info` "
           "lists what else there is."},
          &BagTopics::depth),
      topic({"acquire.topics.colour", "", "ROS: the topic of colour pictures; none: colour is not read."},
            &BagTopics::colour),
      topic({"acquire.topics.depth_camera", "",
             "ROS: the topic of the depth camera's CameraInfo. auto: camera_info beside the pictures."},
            &BagTopics::depth_camera),
      topic({"acquire.topics.colour_camera", "", "ROS: the topic of the colour camera's CameraInfo."},
            &BagTopics::colour_camera),
      topic(
          {"acquire.topics.poses", "",
           "ROS: a topic of PoseStamped or PoseWithCovarianceStamped that are the depth camera's poses. auto: tf, else "
           "the topic with the most of them."},
          &BagTopics::poses),
  };
}

}  // namespace

std::vector<ConfigKey> recording_keys() {
  std::vector<ConfigKey> keys;
  for (auto section : {picture_keys(), topic_keys(), mask_keys()}) {
    std::move(section.begin(), section.end(), std::back_inserter(keys));
  }
  return keys;
}

}  // namespace scanknit
