// COLMAP's text model (colmap.github.io, "Output Format"): images/ and sparse/0/ with cameras, poses and points.
#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/convert/recording_target.h"
#include "acquire/convert/sampled_points.h"
#include "core/files/atomic_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

class ColmapTarget final : public RecordingTarget {
 public:
  explicit ColmapTarget(fs::path folder) : folder_(std::move(folder)) {}

  [[nodiscard]] std::optional<Error> refuses(const Frame& frame) const override {
    if (frame.T_world_camera && frame.colour) return {};
    return Error{ErrorCode::kInput,
                 fmt::format("frame {} has no {}, and COLMAP's model holds pictures with their poses", frame.sequence,
                             frame.colour ? "pose" : "colour"),
                 folder_.string()};
  }

  [[nodiscard]] Result<void> write(const ConvertedFrame& converted) override {
    const Frame& frame = converted.frame;
    const auto name =
        write_own_colour_file(*frame.colour, folder_ / "images", fmt::format("frame_{:06}", converted.number));
    if (!name) return name.error();
    const Pose T_colour_world = frame.colour->T_colour_depth * frame.T_world_camera->inverse();
    const Eigen::Quaterniond q(T_colour_world.linear());
    const Eigen::Vector3d t = T_colour_world.translation();
    // An empty line stands for the picture's features.
    images_ += fmt::format("{} {} {} {} {} {} {} {} {} {}\n\n", converted.number + 1, q.w(), q.x(), q.y(), q.z(), t.x(),
                           t.y(), t.z(), camera_number(frame.colour->intrinsics), *name);
    points_.add(frame);
    return {};
  }

  [[nodiscard]] Result<void> finish() override {
    const fs::path model = folder_ / "sparse/0";
    std::string points = "# POINT3D_ID X Y Z R G B ERROR TRACK[]\n";
    std::size_t number = 0;
    for (const auto& [p, colour] : points_.points()) {
      points += fmt::format("{} {} {} {} {} {} {} 0\n", ++number, p.x(), p.y(), p.z(), colour.r, colour.g, colour.b);
    }
    for (const auto& [name, text] : {std::pair<const char*, const std::string&>{"cameras.txt", cameras_},
                                     {"images.txt", images_},
                                     {"points3D.txt", points}}) {
      if (auto done = write_file_atomically(model / name, text); !done) return done;
    }
    return {};
  }

 private:
  /// Pixels are counted from the corner of the first one, half a pixel before its centre.
  std::size_t camera_number(const CameraIntrinsics& camera) {
    for (std::size_t i = 0; i < known_cameras_.size(); ++i) {
      if (known_cameras_[i] == camera) return i + 1;
    }
    known_cameras_.push_back(camera);
    cameras_ += fmt::format("{} PINHOLE {} {} {} {} {} {}\n", known_cameras_.size(), camera.width, camera.height,
                            camera.fx, camera.fy, camera.cx + 0.5, camera.cy + 0.5);
    return known_cameras_.size();
  }

  fs::path folder_;
  std::vector<CameraIntrinsics> known_cameras_;
  std::string cameras_ = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  std::string images_ = "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME, then POINTS2D[]\n";
  SampledPoints points_;
};

}  // namespace

OpenedTarget open_colmap_target(const fs::path& folder) {
  return std::unique_ptr<RecordingTarget>(std::make_unique<ColmapTarget>(folder));
}

}  // namespace scanknit
