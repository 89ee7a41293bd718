// Recordings that are folders: their text files are fuzzed, and what is read of them keeps its promises. The first byte
// chooses the layout; the rest is its text files, one after the other, each after the first one begun by a byte 0x1e
// (ASCII's "record separator"). Files for which nothing is left are not there.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <system_error>

#include "acquire/frame_source.h"
#include "acquire/lidar/sweep_source.h"
#include "acquire/pictures/picture_set.h"
#include "acquire/stereo/stereo_pairs.h"
#include "folder/folder_layouts.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr char kNextFile = '\x1e';
constexpr int kMostRead = 4;  // frames, pictures or sweeps of a recording

void check_error(const Error& error) {
  require(error.code == ErrorCode::kInput, "what a recording says wrong is an error of the input");
  require(!error.message.empty(), "an error says what is wrong");
}

void check_pose(const Pose& pose) {
  require(is_rigid(pose), "poses are rigid and finite");
}

template <typename Pixel>
void check_camera(const CameraIntrinsics& camera, const Image<Pixel>& image) {
  require(camera.is_valid(), "cameras are valid");
  require(camera.width == image.width() && camera.height == image.height(), "pictures have their cameras' sizes");
}

void check_frame(const Frame& frame) {
  check_camera(frame.intrinsics, frame.depth_m);
  const auto depth = frame.depth_m.pixels();
  require(std::all_of(depth.begin(), depth.end(), [](float z) { return std::isfinite(z) && z >= 0; }),
          "depth is finite, and not negative");
  if (frame.T_world_camera) check_pose(*frame.T_world_camera);
  if (!frame.colour) return;
  check_camera(frame.colour->intrinsics, frame.colour->image);
  check_pose(frame.colour->T_colour_depth);
}

AcquireConfig small_config() {
  AcquireConfig config;
  config.limits.max_image_bytes = 1u << 20;
  config.limits.max_image_pixels = 1 << 16;
  config.limits.max_text_bytes = 1u << 20;
  config.limits.max_frames = 1000;
  return config;
}

void read_frames(const fs::path& folder) {
  AcquireConfig config = small_config();
  std::error_code code;
  if (fs::is_directory(folder / "masks", code)) config.masks = "masks";
  const auto source = open_recording(folder, config);
  if (!source) return check_error(source.error());
  std::int64_t last_ns = 0;
  bool is_first = true;
  for (int i = 0; i < kMostRead; ++i) {
    const FrameEvent event = (*source)->next({});
    if (std::holds_alternative<EndOfStream>(event)) return;
    if (const auto* error = std::get_if<Error>(&event)) return check_error(*error);
    if (const auto* dropped = std::get_if<FrameDropped>(&event)) {
      check_error(dropped->error);
      continue;
    }
    const Frame& frame = std::get<Frame>(event);
    check_frame(frame);
    require(is_first || frame.timestamp_ns > last_ns, "times ascend");
    last_ns = frame.timestamp_ns;
    is_first = false;
  }
}

void read_pictures(const fs::path& folder) {
  AcquireConfig config = small_config();
  config.geometry = Geometry::kSilhouettes;
  const auto set = open_pictures(folder, config);
  if (!set) return check_error(set.error());
  require(!set->pictures.empty(), "a set of pictures has some");
  for (std::size_t i = 0; i < std::min<std::size_t>(set->pictures.size(), kMostRead); ++i) {
    check_pose(set->pictures[i].T_world_camera);
    const auto picture = read_masked_picture(set->pictures[i], {}, config, 1000);
    if (!picture) {
      check_error(picture.error());
      continue;
    }
    check_camera(picture->camera, picture->colour);
    check_camera(picture->camera, picture->mask);
  }
}

void read_sweeps(const fs::path& folder) {
  const AcquireConfig config = small_config();
  const auto source = open_sweeps(folder, config);
  if (!source) return check_error(source.error());
  for (std::size_t i = 0; i < std::min<std::size_t>((*source)->info().sweeps, kMostRead); ++i) {
    const auto read = (*source)->read(i);
    if (const auto* dropped = std::get_if<FrameDropped>(&read)) {
      check_error(dropped->error);
    } else {
      check_pose(std::get<Sweep>(read).T_world_sensor);
    }
  }
}

/// Without OpenCV, which matches the pairs.
void read_stereo(const fs::path& folder) {
  const Limits limits = small_config().limits;
  const auto folders = find_stereo_folders(folder, limits);
  require(folders.has_value(), "folders of pairs are found by their names");
  if (const auto rig = read_stereo_rig(*folders, limits)) {
    check_pose(rig->T_right_left);
    require(rig->T_right_left.translation().x() < 0, "the right camera is to the right");
    for (CameraIntrinsics camera : {rig->left.intrinsics, rig->right.intrinsics}) {
      if (camera.width == 0 && camera.height == 0) camera.width = camera.height = 1;
      require(camera.is_valid(), "cameras of a rig are valid");
    }
  } else {
    check_error(rig.error());
  }
  const auto entries = list_stereo_pairs(*folders, limits);
  if (!entries) return check_error(entries.error());
  for (const FrameEntry& entry : *entries) {
    if (entry.T_world_camera && *entry.T_world_camera) check_pose(**entry.T_world_camera);
  }
}

/// Fills the layout's text files with parts of `rest`.
void write_texts(const FuzzedLayout& layout, const fs::path& folder, std::string_view rest) {
  bool is_left = true;
  for (const char* name : layout.texts) {
    if (!is_left) {
      std::error_code code;
      fs::remove(folder / name, code);
      continue;
    }
    const std::size_t end = rest.find(kNextFile);
    const std::string_view text = rest.substr(0, end);
    write_whole(folder / name, std::string_view(layout.name) == "record3d" ? record3d_zip(std::string(text)) : text);
    is_left = end != std::string_view::npos;
    rest.remove_prefix(is_left ? end + 1 : rest.size());
  }
}

void read_folder(const FuzzedLayout& layout, const fs::path& folder) {
  switch (layout.reader) {
    case FolderReader::kFrames: return read_frames(folder);
    case FolderReader::kPictures: return read_pictures(folder);
    case FolderReader::kSweeps: return read_sweeps(folder);
    case FolderReader::kStereo: return read_stereo(folder);
  }
}

void fuzz_folder(std::uint8_t which, std::string_view texts) {
  static const ScratchFolder scratch;
  static const std::vector<FuzzedLayout> layouts = [] {
    std::vector<FuzzedLayout> made = fuzzed_layouts();
    for (const FuzzedLayout& layout : made) {
      for (const auto& [name, content] : layout.kept) write_whole(scratch.path() / layout.name / "in" / name, content);
    }
    return made;
  }();
  const FuzzedLayout& layout = layouts[which % layouts.size()];
  // "in": what lies beside a recording is read, too, and is nothing here.
  const fs::path folder = scratch.path() / layout.name / "in";
  write_texts(layout, folder, texts);
  read_folder(layout, folder);
}

}  // namespace
}  // namespace scanknit

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  scanknit::fuzz_folder(bytes[0], {reinterpret_cast<const char*>(bytes) + 1, size - 1});
  return 0;
}
