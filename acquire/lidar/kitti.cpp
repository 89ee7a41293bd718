#include "acquire/lidar/kitti.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "acquire/lidar/lidar_return.h"
#include "acquire/parse/kitti_poses.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"
#include "core/files/byte_reader.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSweeps = "velodyne";
constexpr const char* kCalibration = "calib.txt";
constexpr const char* kTimes = "times.txt";
constexpr std::size_t kPointBytes = 16;
constexpr std::uintmax_t kMostSweepBytes = 256U << 20;  // 16 million points; the largest scanners have a million

/// Where the poses of a sequence lie: beside the sweeps, or where the benchmark's own archive unpacks them.
std::vector<fs::path> pose_places(const fs::path& folder) {
  std::error_code code;
  const fs::path whole = fs::absolute(folder, code).lexically_normal();
  const fs::path sequence = whole.has_filename() ? whole : whole.parent_path();
  const std::string name = sequence.filename().string() + ".txt";
  return {sequence / "poses.txt", sequence / name, sequence.parent_path().parent_path() / "poses" / name,
          sequence.parent_path() / "poses" / name};
}

class KittiSweeps final : public SweepSource {
 public:
  KittiSweeps(const Folder& folder, const Limits& limits) : folder_(folder), limits_(limits) {}

  [[nodiscard]] Result<void> open() {
    info_.format = "kitti";
    info_.folder = folder_.path;
    info_.expected_poses =
        "poses.txt beside velodyne/, or poses/NN.txt as the KITTI odometry benchmark has it: for each sweep a line "
        "with the 12 numbers of the left camera's 3x4 pose; and calib.txt with the line Tr";
    if (auto listed = list_sweeps(); !listed) return listed;
    if (auto read = read_poses(); !read) return read;
    return read_times();
  }

  [[nodiscard]] const SweepInfo& info() const override { return info_; }

  [[nodiscard]] std::variant<Sweep, FrameDropped> read(std::size_t index) override {
    const fs::path file = folder_.path / kSweeps / files_.at(index);
    const auto dropped = [&](DropReason reason, const Error& error) {
      return FrameDropped{index, reason, located(error, file)};
    };
    if (index >= poses_.size()) {
      return dropped(DropReason::kNoPose, {ErrorCode::kInput, "no pose; expected " + info_.expected_poses});
    }
    if (!poses_[index]) return FrameDropped{index, DropReason::kBadPose, poses_[index].error()};
    const auto bytes = read_file(file, kMostSweepBytes);
    if (!bytes) return dropped(DropReason::kUnreadable, bytes.error());
    auto points = parse_kitti_points(*bytes);
    if (!points) return dropped(DropReason::kUnreadable, points.error());
    if (points->empty()) return dropped(DropReason::kNoDepth, {ErrorCode::kInput, "no point"});
    Sweep sweep{.sequence = index, .points_m = *std::move(points), .T_world_sensor = *poses_[index]};
    if (index < times_ns_.size()) sweep.timestamp_ns = times_ns_[index];
    return sweep;
  }

 private:
  [[nodiscard]] Result<void> list_sweeps() {
    const auto listed = list_folder(folder_.path / kSweeps, limits_);
    if (!listed) return listed.error();
    for (const std::string& name : listed->files) {
      if (name.ends_with(".bin")) files_.push_back(name);
    }
    info_.sweeps = files_.size();
    if (files_.empty()) {
      return Error{ErrorCode::kInput, "no sweep: expected 000000.bin, 000001.bin ...", listed->path.string()};
    }
    return {};
  }

  /// Line n of the poses is of the file whose number is n.
  [[nodiscard]] Result<void> read_poses() {
    std::error_code code;
    const auto places = pose_places(folder_.path);
    const auto place =
        std::find_if(places.begin(), places.end(), [&](const fs::path& p) { return fs::exists(p, code); });
    if (place == places.end()) return {};
    const auto text = read_text_file(*place, limits_.max_text_bytes);
    if (!text) return text.error();
    const fs::path calibration = folder_.path / kCalibration;
    const auto calibration_text = read_text_file(calibration, limits_.max_text_bytes);
    if (!calibration_text) return calibration_text.error();
    const auto T_camera_sensor = parse_kitti_calibration(*calibration_text);
    if (!T_camera_sensor) return located(T_camera_sensor.error(), calibration);
    const auto cameras = parse_kitti_poses(*text);
    for (std::size_t i = 0; i < files_.size(); ++i) {
      const std::size_t line = line_of(files_[i]).value_or(i);
      if (line >= cameras.size()) {
        poses_.emplace_back(Error{ErrorCode::kInput,
                                  fmt::format("no pose for {}: the file has {}", files_[i], cameras.size()),
                                  place->string()});
        continue;
      }
      poses_.push_back(cameras[line] ? Result<Pose>(*cameras[line] * *T_camera_sensor)
                                     : Result<Pose>(located(cameras[line].error(), *place)));
      if (cameras[line]) ++info_.sweeps_with_pose;
    }
    return {};
  }

  /// The number in a name such as 000012.bin.
  [[nodiscard]] static std::optional<std::size_t> line_of(std::string_view name) {
    const std::string_view stem = name.substr(0, name.size() - 4);
    constexpr std::size_t kMostDigits = 9;
    const bool is_number = !stem.empty() && stem.size() <= kMostDigits &&
                           std::all_of(stem.begin(), stem.end(), [](char c) { return c >= '0' && c <= '9'; });
    if (!is_number) return std::nullopt;
    std::size_t number = 0;
    for (const char c : stem) number = number * 10 + static_cast<std::size_t>(c - '0');
    return number;
  }

  [[nodiscard]] Result<void> read_times() {
    if (!folder_.has_file(kTimes)) return {};
    const fs::path path = folder_.path / kTimes;
    const auto text = read_text_file(path, limits_.max_text_bytes);
    if (!text) return text.error();
    std::vector<std::int64_t> times;
    for (const TextLine& line : text_lines(*text)) {
      const auto time = parse_seconds_ns(line.words[0]);
      if (!time) return Error{ErrorCode::kInput, "expected seconds", fmt::format("{}:{}", path.string(), line.number)};
      times.push_back(*time);
    }
    for (std::size_t i = 0; i < files_.size(); ++i) {
      const std::size_t line = line_of(files_[i]).value_or(i);
      if (line >= times.size()) {
        info_.warnings.push_back(fmt::format("{}: no time for {}: the times are not used", path.string(), files_[i]));
        times_ns_.clear();
        return {};
      }
      times_ns_.push_back(times[line]);
    }
    info_.duration_s = (static_cast<double>(times_ns_.back()) - static_cast<double>(times_ns_.front())) * 1e-9;
    return {};
  }

  Folder folder_;
  Limits limits_;
  SweepInfo info_;
  std::vector<std::string> files_;
  std::vector<Result<Pose>> poses_;  ///< T_world_sensor of each file; empty: there is no file of poses
  std::vector<std::int64_t> times_ns_;
};

}  // namespace

Result<std::vector<Eigen::Vector3f>> parse_kitti_points(std::span<const std::byte> bytes) {
  if (bytes.size() % kPointBytes != 0) {
    return Error{ErrorCode::kInput,
                 fmt::format("{} bytes are no whole number of points of 16 bytes; the file is cut off, "
                             "or holds other values than x y z reflectance",
                             bytes.size())};
  }
  std::vector<Eigen::Vector3f> points;
  points.reserve(bytes.size() / kPointBytes);
  ByteReader reader(bytes);
  while (reader.remaining() >= kPointBytes) {
    const float x = *reader.little_endian<float>();
    const float y = *reader.little_endian<float>();
    const float z = *reader.little_endian<float>();
    (void)reader.little_endian<float>();  // reflectance
    const Eigen::Vector3f p(x, y, z);
    if (is_lidar_return(p.cast<double>())) points.push_back(p);
  }
  return points;
}

Result<Pose> parse_kitti_calibration(std::string_view text) {
  for (const TextLine& line : text_lines(text)) {
    if (line.words[0] != "Tr:" && line.words[0] != "Tr_velo_to_cam:") continue;
    return kitti_pose(std::span(line.words).subspan(1));
  }
  return Error{ErrorCode::kInput, "no line \"Tr:\": where the LiDAR is in the camera's frame, 12 numbers"};
}

bool fits_kitti(const Folder& folder, const Limits& limits) {
  if (!folder.has_folder(kSweeps)) return false;
  const auto listed = list_folder(folder.path / kSweeps, limits);
  return listed && std::any_of(listed->files.begin(), listed->files.end(),
                               [](const std::string& name) { return name.ends_with(".bin"); });
}

Result<std::unique_ptr<SweepSource>> open_kitti(const Folder& folder, const Limits& limits) {
  auto sweeps = std::make_unique<KittiSweeps>(folder, limits);
  if (auto opened = sweeps->open(); !opened) return opened.error();
  return std::unique_ptr<SweepSource>(std::move(sweeps));
}

}  // namespace scanknit
