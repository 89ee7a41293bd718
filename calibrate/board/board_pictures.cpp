#include "calibrate/board/board_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "acquire/frame_source.h"
#include "acquire/replay/folder.h"
#include "core/files/ascii_numbers.h"
#include "core/files/read_file.h"
#include "core/picture/decode_picture.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// The files of the folder that are pictures by their names; empty if it is no folder.
std::vector<fs::path> pictures_in(const fs::path& path, const Limits& limits) {
  std::vector<fs::path> pictures;
  const auto folder = list_folder(path, limits);
  if (!folder) return pictures;
  for (const std::string& name : folder->files) {
    const std::string extension = lower_case(fs::path(name).extension().string());
    if (extension == ".png" || extension == ".jpg" || extension == ".jpeg") pictures.push_back(path / name);
  }
  return pictures;
}

Result<BoardPictures> read_folder(const std::vector<fs::path>& files, const Limits& limits,
                                  const TakeBoardPicture& take, const std::stop_token& stop) {
  BoardPictures result;
  for (const fs::path& file : files) {
    if (stop.stop_requested()) {
      result.was_stopped = true;
      break;
    }
    const auto bytes = read_file(file, limits.max_image_bytes);
    if (!bytes) return bytes.error();
    const auto picture = decode_picture(*bytes, limits);
    if (!picture) return Error{picture.error().code, picture.error().message, file.string()};
    if (auto taken = take({*picture, file.filename().string(), files.size(), std::nullopt}); !taken)
      return taken.error();
    ++result.read;
  }
  return result;
}

/// The depth camera, if colour has its view: what the recording itself says of its cameras.
std::optional<CameraIntrinsics> registered_depth(const fs::path& path, const AcquireConfig& acquire,
                                                 const Frame& as_taken) {
  CameraIntrinsics depth = as_taken.intrinsics;  // its size is right
  if (!as_taken.colour->T_colour_depth.isApprox(Pose::Identity())) return std::nullopt;
  const auto source = open_recording(path, acquire);
  if (!source) return depth;  // it says nothing of its cameras: such recordings are registered
  const FrameEvent event = (*source)->next({});
  const auto* frame = std::get_if<Frame>(&event);
  if (frame == nullptr || !frame->colour) return depth;
  const CameraIntrinsics& colour = frame->colour->intrinsics;
  const CameraIntrinsics same = frame->intrinsics.resized(colour.width, colour.height);
  constexpr double kSame_px = 0.01;
  const bool is_same = std::abs(colour.fx - same.fx) < kSame_px && std::abs(colour.fy - same.fy) < kSame_px &&
                       std::abs(colour.cx - same.cx) < kSame_px && std::abs(colour.cy - same.cy) < kSame_px;
  return is_same ? std::optional(depth) : std::nullopt;
}

/// `acquire`, but every picture as it is: a camera of any size, without a lens.
AcquireConfig as_taken(AcquireConfig acquire) {
  acquire.intrinsics = CameraModel{{0, 0, 1, 1, 0, 0}, {}};
  return acquire;
}

}  // namespace

std::string board_frame_name(const Frame& frame) {
  return fmt::format("frame {}", frame.sequence);
}

Result<BoardPictures> read_board_pictures(const fs::path& path, AcquireConfig acquire, const TakeBoardPicture& take,
                                          const std::stop_token& stop, std::size_t most) {
  acquire.poses = PoseMode::kTrack;  // keeps frames without a pose
  acquire.intrinsics.reset();
  acquire.camera = nullptr;
  auto source = open_recording(path, as_taken(acquire));
  if (!source) {
    const auto pictures = pictures_in(path, acquire.limits);
    return pictures.empty() ? source.error() : read_folder(pictures, acquire.limits, take, stop);
  }
  const std::size_t frames = (*source)->info().frames;
  acquire.every = std::max<std::size_t>(1, (frames + most - 1) / most);
  if (acquire.every > 1) source = open_recording(path, as_taken(acquire));
  if (!source) return source.error();
  BoardPictures result{.is_recording = true, .every = acquire.every};
  for (;;) {
    FrameEvent event = (*source)->next(stop);
    if (std::holds_alternative<EndOfStream>(event)) break;
    if (const auto* error = std::get_if<Error>(&event)) return *error;
    const auto* frame = std::get_if<Frame>(&event);
    if (frame == nullptr || !frame->colour) {
      ++result.dropped;
      continue;
    }
    if (result.read++ == 0) {
      result.registered_depth = registered_depth(path, acquire, *frame);
      result.T_colour_depth = frame->colour->T_colour_depth;
    }
    const auto time = frame->has_clock ? std::optional(frame->timestamp_ns) : std::nullopt;
    auto taken = take({frame->colour->image, board_frame_name(*frame), frames / acquire.every, time, frame->sequence});
    if (!taken) return taken.error();
  }
  result.was_stopped = stop.stop_requested();
  if (result.read == 0 && !result.was_stopped) {
    return Error{ErrorCode::kInput, fmt::format("none of its {} frames has a colour picture", frames), path.string()};
  }
  return result;
}

}  // namespace scanknit
