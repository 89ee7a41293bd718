// transforms.json of nerfstudio (docs.nerf.studio, "Data conventions"), with images/, depth/ and points.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/convert/picture_files.h"
#include "acquire/convert/recording_target.h"
#include "acquire/convert/sampled_points.h"
#include "acquire/parse/opengl_pose.h"
#include "core/files/atomic_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kPointsName = "sparse_pc.ply";  // as nerfstudio's own tools name it
constexpr double kUsualUnits = 1000;                  // nerfstudio takes 16-bit depth for millimetres

/// A turn that makes `world_up` the z axis, which points up in nerfstudio. It only permutes axes and changes their
/// signs, so that nothing is rounded.
Eigen::Matrix3d turn_to_z_up(UpAxis world_up) {
  int up = 0;
  double sign = 1;
  switch (world_up) {
    case UpAxis::kX: break;
    case UpAxis::kY: up = 1; break;
    case UpAxis::kZ: up = 2; break;
    case UpAxis::kMinusX: sign = -1; break;
    case UpAxis::kMinusY: up = 1, sign = -1; break;
    case UpAxis::kMinusZ: up = 2, sign = -1; break;
  }
  Eigen::Matrix3d turn = Eigen::Matrix3d::Zero();
  turn(0, (up + 1) % 3) = 1;
  turn(1, (up + 2) % 3) = sign;
  turn(2, up) = sign;
  return turn;
}

Json rows_of(const Eigen::Matrix4d& matrix, int count) {
  Json rows = Json::array();
  for (int row = 0; row < count; ++row) {
    rows.push_back({matrix(row, 0), matrix(row, 1), matrix(row, 2), matrix(row, 3)});
  }
  return rows;
}

/// The file counts pixels from the corner of the first one, half a pixel before its centre.
void add_camera(Json& json, const CameraIntrinsics& camera) {
  json["w"] = camera.width;
  json["h"] = camera.height;
  json["fl_x"] = camera.fx;
  json["fl_y"] = camera.fy;
  json["cx"] = camera.cx + 0.5;
  json["cy"] = camera.cy + 0.5;
  for (const char* coefficient : {"k1", "k2", "p1", "p2"}) json[coefficient] = 0.0;
}

class NerfstudioTarget final : public RecordingTarget {
 public:
  NerfstudioTarget(fs::path folder, UpAxis world_up) : folder_(std::move(folder)) {
    T_file_world_.linear() = turn_to_z_up(world_up);
  }

  [[nodiscard]] std::optional<Error> refuses(const Frame& frame) const override {
    if (frame.T_world_camera) return {};
    return Error{ErrorCode::kInput,
                 fmt::format("frame {} has no pose, and transforms.json has no frames without one; convert a recording "
                             "that has poses",
                             frame.sequence),
                 folder_.string()};
  }

  [[nodiscard]] Result<void> write(const ConvertedFrame& converted) override {
    const Frame& frame = converted.frame;
    const std::string number = fmt::format("frame_{:06}", converted.number);
    Json json;
    if (frame.colour) {
      const auto name = write_colour_file(frame, folder_, "images/" + number);
      if (!name) return name.error();
      json["file_path"] = *name;
      points_.add(frame);
    } else {
      warn("frames without colour have no file_path: nerfstudio trains on none of them");
    }
    const std::string depth = "depth/" + number + ".png";
    if (auto done = write_depth_png(converted.raw_depth, folder_ / depth); !done) return done;
    json["depth_file_path"] = depth;
    json["transform_matrix"] = rows_of(opengl_matrix(T_file_world_ * *frame.T_world_camera), 4);
    if (frame.has_clock) json["timestamp_ns"] = frame.timestamp_ns;
    frames_.push_back(std::move(json));
    cameras_.push_back(camera_of(frame));
    note_units(converted.units_per_metre);
    return {};
  }

  [[nodiscard]] Result<void> finish() override {
    Json json = {{"camera_model", "OPENCV"}};
    const bool is_one = std::adjacent_find(cameras_.begin(), cameras_.end(), std::not_equal_to<>()) == cameras_.end();
    if (is_one) add_camera(json, cameras_.front());
    for (std::size_t i = 0; i < frames_.size() && !is_one; ++i) add_camera(frames_[i], cameras_[i]);
    json["depth_unit_scale_factor"] = 1 / units_per_metre_;
    if (T_file_world_.linear() != Eigen::Matrix3d::Identity()) {
      json["applied_transform"] = rows_of(T_file_world_.matrix(), 3);
    }
    if (!points_.points().empty()) {
      if (auto done = write_points(); !done) return done;
      json["ply_file_path"] = kPointsName;
    }
    json["frames"] = std::move(frames_);
    return write_file_atomically(folder_ / "transforms.json", json.dump(2) + "\n");
  }

 private:
  /// In the file's world, as the poses are.
  [[nodiscard]] Result<void> write_points() const {
    std::string text = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
        points_.points().size());
    for (const auto& [p_world, colour] : points_.points()) {
      const Eigen::Vector3f p = T_file_world_.linear().cast<float>() * p_world;
      text += fmt::format("{} {} {} {} {} {}\n", p.x(), p.y(), p.z(), colour.r, colour.g, colour.b);
    }
    return write_file_atomically(folder_ / kPointsName, text);
  }

  /// Of the colour picture as it was written; where there is none, of depth.
  [[nodiscard]] static CameraIntrinsics camera_of(const Frame& frame) {
    return frame.colour && is_registered(frame) ? frame.colour->intrinsics : frame.intrinsics;
  }

  void note_units(double units_per_metre) {
    units_per_metre_ = units_per_metre;
    if (units_per_metre == kUsualUnits) return;
    warn(
        fmt::format("depth keeps its {0} units a metre, where nerfstudio expects 1000 unless it is told "
                    "--depth-unit-scale-factor {1}; transforms.json says so",
                    units_per_metre, 1 / units_per_metre));
  }

  fs::path folder_;
  Pose T_file_world_ = Pose::Identity();
  std::vector<Json> frames_;
  std::vector<CameraIntrinsics> cameras_;
  SampledPoints points_;
  double units_per_metre_ = kUsualUnits;
};

}  // namespace

OpenedTarget open_nerfstudio_target(const fs::path& folder, UpAxis world_up) {
  return std::unique_ptr<RecordingTarget>(std::make_unique<NerfstudioTarget>(folder, world_up));
}

}  // namespace scanknit
