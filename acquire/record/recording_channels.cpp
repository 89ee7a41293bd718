#include "acquire/record/recording_channels.h"

#include <array>
#include <nlohmann/json.hpp>
#include <string_view>

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view kPictureSchema = R"json({
"title": "scanknit.picture",
"description": "Binary, little endian: uint8 version (1); uint8 kind (0 depth, 1 colour); uint8 pixel format (0 Z16, 1 YUYV, 2 UYVY, 3 MJPEG, 4 RGB8, 5 BGR8, 6 Y8I: left and right grey of a pair, by pixels); uint8 packing (0 none, 1 zstd, 2 dz1); uint32 width; uint32 height; uint32 bytes of the picture when unpacked; uint64 sequence; float64 frames per second (0 unknown); then the packed picture up to the message's end. Z16 is depth in units of the calibration's depth_unit_m, 0 is no return. dz1: one zstd frame of 2 * width * height bytes: all low bytes, then all high bytes, of z[i] = (d[i] << 1) ^ (d[i] >> 15), d[i] = v[i] - v[i - 1] in 16 bits, v[-1] = 0, v row by row. log_time: the computer's steady clock at the last byte's arrival. publish_time: the camera's clock.",
"type": "object"
})json";

constexpr std::string_view kCalibrationSchema = R"json({
"title": "scanknit.calibration",
"description": "Cameras of both streams: pinhole in pixels (pixel centres are integers), Brown-Conrady distortion in OpenCV's order. width 0: no such camera.",
"type": "object",
"properties": {
"depth": {"type": "object", "description": "width, height, fx, fy, cx, cy, distortion [k1, k2, p1, p2, k3]"},
"colour": {"type": "object", "description": "as depth"},
"T_colour_depth": {"type": "array", "description": "p_colour = T p_depth, 4x4 row by row, metres", "items": {"type": "number"}},
"depth_unit_m": {"type": "number", "description": "metres of one unit of Z16"},
"baseline_m": {"type": "number", "description": "of Y8I: metres from the left camera, which is depth, to the right one; absent: unknown"},
"source": {"type": "string"}, "device": {"type": "string"}, "serial": {"type": "string"}
}})json";

constexpr std::string_view kLossesSchema = R"json({
"title": "scanknit.losses",
"description": "Frames lost since the recording began, by where.",
"type": "object",
"properties": {
"device": {"type": "integer", "description": "the camera's own counter jumped"},
"transport": {"type": "integer", "description": "incomplete or marked as bad"},
"overflow": {"type": "integer", "description": "more bytes than a picture has"},
"queue": {"type": "integer", "description": "the scan was too slow"},
"writer": {"type": "integer", "description": "the recorder was too slow, or its disk full"}
}})json";

constexpr std::string_view kPoseSchema = R"json({
"title": "scanknit.pose",
"description": "Where the depth camera was when it took the depth picture with this sequence number.",
"type": "object",
"properties": {
"sequence": {"type": "integer"},
"T_world_camera": {"type": "array", "description": "p_world = T p_camera, 4x4 row by row, metres; camera x right, y down, z forward", "items": {"type": "number"}}
}})json";

enum SchemaId : std::uint16_t { kPictureId = 1, kCalibrationId, kLossesId, kPoseId };

constexpr std::uint16_t id_of(RecordingChannel channel) {
  return static_cast<std::uint16_t>(channel);
}

Json camera_json(const CameraModel& camera) {
  const CameraIntrinsics& k = camera.intrinsics;
  return {{"width", k.width},
          {"height", k.height},
          {"fx", k.fx},
          {"fy", k.fy},
          {"cx", k.cx},
          {"cy", k.cy},
          {"distortion", camera.distortion}};
}

Json pose_json(const Pose& pose) {
  Json rows = Json::array();
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) rows.push_back(pose.matrix()(row, column));
  }
  return rows;
}

double number_in(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_number() ? json[key].get<double>() : 0.0;
}

std::string text_in(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
}

std::uint64_t count_in(const Json& json, const char* key) {
  return json.contains(key) && json[key].is_number_unsigned() ? json[key].get<std::uint64_t>() : 0;
}

Json parse_object(std::span<const std::byte> bytes) {
  std::string text(bytes.size(), '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) text[i] = static_cast<char>(bytes[i]);
  return Json::parse(text, nullptr, false);
}

std::optional<CameraModel> camera_in(const Json& json, const char* key) {
  constexpr double kMaxSide = 1 << 20;
  if (!json.contains(key) || !json[key].is_object()) return std::nullopt;
  const Json& camera = json[key];
  const double width = number_in(camera, "width");
  const double height = number_in(camera, "height");
  if (!(width >= 0 && width <= kMaxSide && height >= 0 && height <= kMaxSide)) return std::nullopt;
  CameraModel model;
  model.intrinsics = {static_cast<int>(width), static_cast<int>(height), number_in(camera, "fx"),
                      number_in(camera, "fy"), number_in(camera, "cx"),  number_in(camera, "cy")};
  if (model.intrinsics.width > 0 && !model.intrinsics.is_valid()) return std::nullopt;
  if (!camera.contains("distortion")) return model;
  const Json& distortion = camera["distortion"];
  if (!distortion.is_array() || distortion.size() != model.distortion.size()) return std::nullopt;
  for (std::size_t i = 0; i < model.distortion.size(); ++i) {
    if (!distortion[i].is_number()) return std::nullopt;
    model.distortion[i] = distortion[i].get<double>();
  }
  return model;
}

Result<Pose> pose_in(const Json& json, const char* key) {
  const Error malformed{ErrorCode::kInput, "expected a motion of sixteen numbers"};
  if (!json.contains(key) || !json[key].is_array() || json[key].size() != 16) return malformed;
  Eigen::Matrix4d matrix;
  for (int i = 0; i < 16; ++i) {
    const Json& value = json[key][static_cast<std::size_t>(i)];
    if (!value.is_number()) return malformed;
    matrix(i / 4, i % 4) = value.get<double>();
  }
  auto pose = pose_from_matrix(matrix);
  // What we wrote is a rotation to the last bit; making it the nearest one again would change its bits.
  Pose exact;
  exact.matrix() = matrix;
  return pose && is_rigid(exact) ? Result<Pose>(exact) : pose;
}

}  // namespace

std::vector<McapSchema> recording_schemas() {
  return {{kPictureId, "scanknit.picture", "jsonschema", std::string(kPictureSchema)},
          {kCalibrationId, "scanknit.calibration", "jsonschema", std::string(kCalibrationSchema)},
          {kLossesId, "scanknit.losses", "jsonschema", std::string(kLossesSchema)},
          {kPoseId, "scanknit.pose", "jsonschema", std::string(kPoseSchema)}};
}

std::vector<McapChannel> recording_channels() {
  constexpr const char* kPicture = "x-scanknit-picture";
  return {{id_of(RecordingChannel::kDepth), kPictureId, kDepthTopic, kPicture},
          {id_of(RecordingChannel::kColour), kPictureId, kColourTopic, kPicture},
          {id_of(RecordingChannel::kCalibration), kCalibrationId, kCalibrationTopic, "json"},
          {id_of(RecordingChannel::kLosses), kLossesId, kLossesTopic, "json"},
          {id_of(RecordingChannel::kPose), kPoseId, kPoseTopic, "json"}};
}

std::string calibration_text(const RawCalibration& calibration) {
  Json json = {{"depth", camera_json(calibration.depth)},
               {"colour", camera_json(calibration.colour)},
               {"T_colour_depth", pose_json(calibration.T_colour_depth)},
               {"depth_unit_m", calibration.depth_unit_m},
               {"source", calibration.source},
               {"device", calibration.device},
               {"serial", calibration.serial}};
  if (calibration.baseline_m > 0) json["baseline_m"] = calibration.baseline_m;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string losses_text(const LossCounters& losses) {
  const Json json = {{"device", losses.device},
                     {"transport", losses.transport},
                     {"overflow", losses.overflow},
                     {"queue", losses.queue},
                     {"writer", losses.writer}};
  return json.dump();
}

std::string pose_text(std::uint64_t sequence, const Pose& T_world_camera) {
  return Json{{"sequence", sequence}, {"T_world_camera", pose_json(T_world_camera)}}.dump();
}

Result<RawCalibration> parse_calibration(std::span<const std::byte> bytes) {
  const auto malformed = [](const char* what) {
    return Error{ErrorCode::kInput, std::string("the calibration is malformed: ") + what};
  };
  const Json json = parse_object(bytes);
  if (!json.is_object()) return malformed("not a JSON object");
  const auto depth = camera_in(json, "depth");
  const auto colour = camera_in(json, "colour");
  if (!depth || !colour) return malformed("a camera");
  const auto T_colour_depth = pose_in(json, "T_colour_depth");
  if (!T_colour_depth) return malformed("T_colour_depth");
  const double unit_m = number_in(json, "depth_unit_m");
  if (!(unit_m >= 1e-7 && unit_m <= 1)) return malformed("depth_unit_m, expected 1e-7 to 1");
  RawCalibration calibration{*depth,
                             *colour,
                             *T_colour_depth,
                             unit_m,
                             text_in(json, "source"),
                             text_in(json, "device"),
                             text_in(json, "serial")};
  calibration.baseline_m = number_in(json, "baseline_m");
  return calibration;
}

Result<LossCounters> parse_losses(std::span<const std::byte> bytes) {
  const Json json = parse_object(bytes);
  if (!json.is_object()) return Error{ErrorCode::kInput, "the loss counters are no JSON object"};
  return LossCounters{count_in(json, "device"), count_in(json, "transport"), count_in(json, "overflow"),
                      count_in(json, "queue"), count_in(json, "writer")};
}

std::optional<RecordedPose> parse_pose(std::span<const std::byte> bytes) {
  const Json json = parse_object(bytes);
  if (!json.is_object() || !json.contains("sequence") || !json["sequence"].is_number_unsigned()) return std::nullopt;
  return RecordedPose{json["sequence"].get<std::uint64_t>(), pose_in(json, "T_world_camera")};
}

}  // namespace scanknit
