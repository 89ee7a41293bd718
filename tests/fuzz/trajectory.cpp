// Trajectories: the first byte chooses the reader; and what we write of poses is read back as the same poses.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "acquire/lidar/kitti.h"
#include "acquire/parse/kitti_poses.h"
#include "acquire/parse/pose_list.h"
#include "acquire/parse/timed_poses.h"
#include "export/trajectory.h"
#include "folder/scratch_folder.h"

namespace scanknit {
namespace {

void check_pose(const Result<Pose>& pose) {
  require(pose ? is_rigid(*pose) : !pose.error().message.empty(), "a pose is rigid and finite, or says what is wrong");
}

void check_same(const Pose& a, const Pose& b) {
  const double far_m = 1 + a.translation().cwiseAbs().maxCoeff();
  require((a.linear() - b.linear()).cwiseAbs().maxCoeff() < 1e-8, "a turn is read as it was written");
  require((a.translation() - b.translation()).cwiseAbs().maxCoeff() < 1e-8 * far_m,
          "a place is read as it was written");
}

/// The good ones of `poses`, with stamps of whole seconds.
std::vector<StampedPose> stamped(const std::vector<Result<Pose>>& poses) {
  std::vector<StampedPose> good;
  for (const auto& pose : poses) {
    if (pose) good.push_back({static_cast<double>(good.size()), *pose});
  }
  return good;
}

void check_read_back(const std::vector<Result<Pose>>& poses, const std::filesystem::path& path, const Limits& limits) {
  for (const auto& pose : poses) check_pose(pose);
  const std::vector<StampedPose> written = stamped(poses);
  write_whole(path, to_tum_trajectory(written));
  const auto tum = read_tum_poses(path, limits);
  require(tum && tum->size() == written.size(), "as many poses are read as were written");
  const auto kitti = parse_kitti_poses(to_kitti_trajectory(written));
  require(kitti.size() == written.size(), "as many poses are read as were written");
  for (std::size_t i = 0; i < written.size(); ++i) {
    require((*tum)[i].time_ns == static_cast<std::int64_t>(i) * 1'000'000'000, "a stamp is read as it was written");
    require((*tum)[i].pose.has_value() && kitti[i].has_value(), "a pose that is written can be read");
    check_same(written[i].T_world_camera, *(*tum)[i].pose);
    check_same(written[i].T_world_camera, *kitti[i]);
  }
}

void read_tum(const std::filesystem::path& folder, std::string_view text, const Limits& limits) {
  const auto path = folder / "trajectory.txt";
  write_whole(path, text);
  const auto read = read_tum_poses(path, limits);
  if (!read) return require(read.error().code == ErrorCode::kInput, "a bad file is an error of the input");
  std::vector<Result<Pose>> poses;
  for (const TimedPose& pose : *read) {
    poses.push_back(pose.pose);
    for (const std::int64_t off_ns : {-30'000'000, -1, 0, 1, 30'000'000}) {
      std::int64_t time_ns = 0;
      if (__builtin_add_overflow(pose.time_ns, off_ns, &time_ns)) continue;
      if (const auto there = pose_at(*read, time_ns)) check_pose(*there);
    }
  }
  check_read_back(poses, path, limits);
}

/// Of Open3D's two files, the one of this name.
void read_list(const std::filesystem::path& folder, const char* name, std::string_view text, const Limits& limits) {
  write_whole(folder / name, text);
  const auto poses = read_pose_list({folder, {name}, {}}, limits);
  if (!poses) return require(poses.error().code == ErrorCode::kInput, "a bad file is an error of the input");
  check_read_back(*poses, folder / "trajectory.txt", limits);
}

}  // namespace
}  // namespace scanknit

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace scanknit;
  static const ScratchFolder folder;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(bytes) + 1, size - 1);
  Limits limits;
  limits.max_text_bytes = 1u << 20;
  switch (bytes[0] % 4) {
    case 0: read_tum(folder.path(), text, limits); break;
    case 1: read_list(folder.path(), "trajectory.log", text, limits); break;
    case 2: read_list(folder.path(), "trajectory.json", text, limits); break;
    default: check_read_back(parse_kitti_poses(text), folder.path() / "trajectory.txt", limits); break;
  }
  return 0;
}
