// The layouts of pictures and text files: TUM, Open3D, 7-Scenes.
#include <fmt/format.h>

#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "acquire/convert/picture_files.h"
#include "acquire/convert/recording_target.h"
#include "core/files/atomic_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

// What the three share: pictures, and the camera that explains them.
class FolderTarget : public RecordingTarget {
 public:
  FolderTarget(fs::path folder, double usual_units) : folder_(std::move(folder)), usual_units_(usual_units) {}

 protected:
  [[nodiscard]] Result<void> write_depth(const ConvertedFrame& converted, const std::string& name) {
    const Frame& frame = converted.frame;
    if (!camera_) {
      camera_ = frame.intrinsics;
      const fs::path path = folder_ / "camera_intrinsic.json";
      if (auto done = write_camera_json(*camera_, converted.units_per_metre, path); !done) return done;
    }
    if (frame.intrinsics != *camera_) {
      warn("the camera's intrinsics change on the way; those of the first frame are kept");
    }
    if (converted.units_per_metre != usual_units_) {
      warn(
          fmt::format("depth keeps its {} units a metre, where other readers of this layout expect {}; "
                      "camera_intrinsic.json says so",
                      converted.units_per_metre, usual_units_));
    }
    return write_depth_png(converted.raw_depth, folder_ / name);
  }

  [[nodiscard]] Result<std::string> write_colour(const ConvertedFrame& converted, const std::string& stem) {
    return write_colour_file(converted.frame, folder_, stem);
  }

  [[nodiscard]] Result<void> write_text(const char* name, const std::string& text) const {
    return write_file_atomically(folder_ / name, text);
  }

 private:
  fs::path folder_;
  double usual_units_;
  std::optional<CameraIntrinsics> camera_;
};

// Seconds with all nine digits, so that nothing is rounded.
std::string seconds_text(std::int64_t time_ns) {
  const std::uint64_t magnitude =
      time_ns < 0 ? 0 - static_cast<std::uint64_t>(time_ns) : static_cast<std::uint64_t>(time_ns);
  return fmt::format("{}{}.{:09}", time_ns < 0 ? "-" : "", magnitude / 1'000'000'000, magnitude % 1'000'000'000);
}

class TumTarget final : public FolderTarget {
 public:
  explicit TumTarget(fs::path folder) : FolderTarget(std::move(folder), 5000) {}

  [[nodiscard]] Result<void> write(const ConvertedFrame& converted) override {
    const std::string time = seconds_text(converted.time_ns);
    const std::string depth = "depth/" + time + ".png";
    if (auto done = write_depth(converted, depth); !done) return done;
    depth_ += time + " " + depth + "\n";
    if (converted.frame.colour) {
      const auto name = write_colour(converted, "rgb/" + time);
      if (!name) return name.error();
      colour_ += time + " " + *name + "\n";
    }
    if (!converted.frame.T_world_camera) return {};
    const Eigen::Vector3d t = converted.frame.T_world_camera->translation();
    const Eigen::Quaterniond q(converted.frame.T_world_camera->linear());
    poses_ += fmt::format("{} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\n", time, t.x(), t.y(), t.z(),
                          q.x(), q.y(), q.z(), q.w());
    return {};
  }

  [[nodiscard]] Result<void> finish() override {
    if (!colour_.empty()) {
      if (auto done = write_text("rgb.txt", "# timestamp filename\n" + colour_); !done) return done;
    }
    if (!poses_.empty()) {
      if (auto done = write_text("groundtruth.txt", "# timestamp tx ty tz qx qy qz qw\n" + poses_); !done) return done;
    }
    return write_text("depth.txt", "# timestamp filename\n" + depth_);
  }

 private:
  std::string depth_, colour_, poses_;
};

class Open3dTarget final : public FolderTarget {
 public:
  explicit Open3dTarget(fs::path folder) : FolderTarget(std::move(folder), 1000) {}

  [[nodiscard]] Result<void> write(const ConvertedFrame& converted) override {
    const Frame& frame = converted.frame;
    const std::string number = fmt::format("{:06}", converted.number);
    if (auto done = write_depth(converted, "depth/" + number + ".png"); !done) return done;
    if (frame.colour) {
      if (const auto name = write_colour(converted, "color/" + number); !name) return name.error();
    }
    has_pose_ |= frame.T_world_camera.has_value();
    // The log goes by order: a frame without a pose needs its five lines too.
    const Eigen::Matrix4d none = Eigen::Matrix4d::Constant(std::numeric_limits<double>::quiet_NaN());
    append_log_pose(log_, converted.number, frame.T_world_camera ? frame.T_world_camera->matrix() : none);
    has_clock_ |= frame.has_clock;
    times_ += seconds_text(converted.time_ns) + "\n";
    return {};
  }

  [[nodiscard]] Result<void> finish() override {
    if (has_pose_) {
      if (auto done = write_text("trajectory.log", log_); !done) return done;
    }
    return has_clock_ ? write_text("timestamps.txt", times_) : Result<void>{};
  }

 private:
  std::string log_, times_;
  bool has_pose_ = false;
  bool has_clock_ = false;
};

class SevenScenesTarget final : public FolderTarget {
 public:
  explicit SevenScenesTarget(fs::path folder) : FolderTarget(std::move(folder), 1000) {}

  [[nodiscard]] Result<void> write(const ConvertedFrame& converted) override {
    if (converted.frame.has_clock) warn("the layout has no clock: the frames' times are left out");
    const std::string stem = fmt::format("frame-{:06}", converted.number);
    if (auto done = write_depth(converted, stem + ".depth.png"); !done) return done;
    if (converted.frame.colour) {
      if (const auto name = write_colour(converted, stem + ".color"); !name) return name.error();
    }
    if (!converted.frame.T_world_camera) return {};
    std::string pose;
    append_matrix(pose, converted.frame.T_world_camera->matrix());
    return write_text((stem + ".pose.txt").c_str(), pose);
  }

  [[nodiscard]] Result<void> finish() override { return {}; }
};

}  // namespace

OpenedTarget open_tum_target(const fs::path& folder) {
  return std::unique_ptr<RecordingTarget>(std::make_unique<TumTarget>(folder));
}

OpenedTarget open_open3d_target(const fs::path& folder) {
  return std::unique_ptr<RecordingTarget>(std::make_unique<Open3dTarget>(folder));
}

OpenedTarget open_seven_scenes_target(const fs::path& folder) {
  return std::unique_ptr<RecordingTarget>(std::make_unique<SevenScenesTarget>(folder));
}

}  // namespace scanknit
