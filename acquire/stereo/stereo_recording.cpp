// Pairs of pictures of a stereo rig, whose frames get their depth by matching.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "acquire/replay/layouts.h"
#include "acquire/replay/picture_codec.h"
#include "acquire/sensor/scanner_camera.h"
#include "acquire/stereo/pair_depth.h"
#include "acquire/stereo/stereo_pairs.h"
#include "acquire/stereo/stereo_rig.h"
#include "core/picture/decode_picture.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

struct Pair {
  ColourImage left, right;
};

std::string size_of(const ColourImage& picture) {
  return fmt::format("{} x {}", picture.width(), picture.height());
}

OrDrop<ColourImage> read_side(const fs::path& path, const Limits& limits) {
  const auto bytes = read_picture(path, limits);
  if (const auto* drop = std::get_if<Drop>(&bytes)) return *drop;
  return picture_or_drop(decode_picture(std::get<0>(bytes), limits), path);
}

OrDrop<Pair> read_pair(const FrameEntry& entry, const Limits& limits) {
  if (entry.fault) return *entry.fault;
  auto left = read_side(entry.colour, limits);
  if (auto* drop = std::get_if<Drop>(&left)) return std::move(*drop);
  auto right = read_side(entry.depth, limits);
  if (auto* drop = std::get_if<Drop>(&right)) return std::move(*drop);
  Pair pair{std::get<ColourImage>(std::move(left)), std::get<ColourImage>(std::move(right))};
  if (pair.left.width() != pair.right.width() || pair.left.height() != pair.right.height()) {
    return make_drop(DropReason::kSizeMismatch,
                     "the left picture is " + size_of(pair.left) + ", the right one " + size_of(pair.right),
                     entry.depth);
  }
  return pair;
}

/// Decodes the frames of one recording.
class PairDecoder {
 public:
  PairDecoder(StereoRig rig, std::unique_ptr<PairDepth> depth) : rig_(std::move(rig)), depth_(std::move(depth)) {}

  [[nodiscard]] const PairDepth& depth() const { return *depth_; }
  [[nodiscard]] const RectifiedPair& pair() const { return depth_->pair(); }

  [[nodiscard]] OrDrop<Pair> read(const FrameEntry& entry, const Limits& limits) const {
    auto pair = read_pair(entry, limits);
    const auto* read = std::get_if<Pair>(&pair);
    const CameraIntrinsics& camera = rig_.left.intrinsics;
    if (read == nullptr || (read->left.width() == camera.width && read->left.height() == camera.height)) return pair;
    return make_drop(
        DropReason::kSizeMismatch,
        fmt::format("the pictures are {}, the cameras {} x {}", size_of(read->left), camera.width, camera.height),
        entry.colour);
  }

  [[nodiscard]] OrDrop<DecodedFrame> decode(const FrameEntry& entry, const Limits& limits) const {
    const auto read_pair = read(entry, limits);
    if (const auto* drop = std::get_if<Drop>(&read_pair)) return *drop;
    auto found = depth_->find(std::get<Pair>(read_pair).left, std::get<Pair>(read_pair).right);
    if (!found) return make_drop(DropReason::kUnreadable, "OpenCV could not match the pair", entry.colour);
    if (found->share_known < PairDepth::kLeastKnown) {
      return make_drop(DropReason::kNoDepth,
                       fmt::format("only {:.1f} % of the pixels match: too little texture, or the two pictures do not "
                                   "belong together",
                                   100 * found->share_known),
                       entry.colour);
    }
    return DecodedFrame{.depth_m = std::move(found->depth_m),
                        .colour = std::move(found->left),
                        .camera = pair().camera,
                        .colour_camera = pair().camera};
  }

 private:
  StereoRig rig_;
  std::unique_ptr<PairDepth> depth_;
};

/// The first pair that can be read; its size becomes that of cameras that state none.
Result<void> take_size(const std::vector<FrameEntry>& entries, const Limits& limits, StereoRig& rig) {
  constexpr std::size_t kMostTries = 16;
  std::string why = "there is no left picture";
  for (std::size_t i = 0; i < std::min(entries.size(), kMostTries); ++i) {
    const auto pair = read_pair(entries[i], limits);
    if (const auto* drop = std::get_if<Drop>(&pair)) {
      why = drop->error.text();
      continue;
    }
    const ColourImage& picture = std::get<Pair>(pair).left;
    for (StereoCamera* camera : {&rig.left, &rig.right}) {
      if (camera->intrinsics.width == 0 || camera->intrinsics.height == 0) {
        camera->intrinsics.width = picture.width();
        camera->intrinsics.height = picture.height();
      }
    }
    const CameraIntrinsics& left = rig.left.intrinsics;
    const CameraIntrinsics& right = rig.right.intrinsics;
    if (std::abs(left.cx - right.cx) >= left.width) {
      return Error{ErrorCode::kInput, "the cameras' cx differ by more than the width of the pictures",
                   rig.file.string()};
    }
    if (left.width == right.width && left.height == right.height) return {};
    return Error{ErrorCode::kInput,
                 fmt::format("the left camera is {} x {}, the right one {} x {}; expected two of one size", left.width,
                             left.height, right.width, right.height),
                 rig.file.string()};
  }
  return Error{ErrorCode::kInput, "no pair of pictures can be read: " + why};
}

/// Looks at up to three pairs: are the sides exchanged, and do the rows fit? Faults are told, not guessed away.
Result<void> check_pairs(const PairDecoder& decoder, const AcquireConfig& config, Recording& recording) {
  constexpr std::size_t kFewestCorners = 20;
  constexpr double kMostBehind = 0.8, kMostRows_px = 0.7;
  const std::size_t count = recording.entries.size();
  double worst_rows_px = 0;
  for (const std::size_t at : {std::size_t{0}, count / 2, count - 1}) {
    const auto pair = decoder.read(recording.entries[at], config.limits);
    if (!std::holds_alternative<Pair>(pair)) continue;
    const auto found = decoder.depth().check(std::get<Pair>(pair).left, std::get<Pair>(pair).right);
    if (!found || found->corners < kFewestCorners) continue;
    if (found->share_behind > kMostBehind) {
      return Error{ErrorCode::kInput,
                   fmt::format("left and right are exchanged: {:.0f} % of the corners are farther to the right in the "
                               "right picture, which nothing before the cameras can be. Exchange the folders",
                               100 * found->share_behind),
                   recording.entries[at].colour->string()};
    }
    if (std::abs(found->rows_px) > std::abs(worst_rows_px)) worst_rows_px = found->rows_px;
  }
  if (std::abs(worst_rows_px) > kMostRows_px) {
    recording.warnings.push_back(fmt::format(
        "the pictures are not rectified as the cameras say: what is in one row of the left picture is {:.1f} "
        "pixels {} in the right one (expected: at most {}), so that depth is missing or wrong. Calibrate "
        "the rig again",
        std::abs(worst_rows_px), worst_rows_px > 0 ? "lower" : "higher", kMostRows_px));
  }
  return {};
}

Result<void> refuse_settings(const AcquireConfig& config, const StereoRig& rig) {
  if (const auto allowed = refuse_other_cameras(config, rig.file.string()); !allowed) return allowed;
  if (config.masks && !rig.is_rectified()) {
    return Error{ErrorCode::kConfig, "acquire.masks: not for pairs that are yet to be rectified, which masks are not"};
  }
  return {};
}

/// Poses are the left camera's; the rectified camera is turned against it.
void turn_poses(const Pose& T_left_rectified, std::vector<FrameEntry>& entries) {
  for (FrameEntry& entry : entries) {
    if (entry.T_world_camera && *entry.T_world_camera)
      entry.T_world_camera = Result<Pose>(**entry.T_world_camera * T_left_rectified);
  }
}

}  // namespace

bool has_stereo_pairs(const fs::path& path, const Limits& limits) {
  return find_stereo_folders(path, limits).has_value();
}

Result<Recording> index_stereo(const fs::path& path, const AcquireConfig& config) {
  const auto folders = find_stereo_folders(path, config.limits);
  if (!folders) {
    return Error{
        ErrorCode::kInput,
        "no stereo pairs; looked for the folders left/ and right/, image_0/ and image_1/, image_2/ and image_3/ "
        "(KITTI), infra1/ and infra2/, cam0/data/ and cam1/data/ (EuRoC)",
        path.string()};
  }
  auto rig = read_stereo_rig(*folders, config.limits);
  if (!rig) return rig.error();
  if (const auto allowed = refuse_settings(config, *rig); !allowed) return allowed.error();
  auto entries = list_stereo_pairs(*folders, config.limits);
  if (!entries) return entries.error();
  if (entries->empty()) return Error{ErrorCode::kInput, "there is no picture", folders->left.string()};
  if (const auto sized = take_size(*entries, config.limits, *rig); !sized) return sized.error();
  auto depth = PairDepth::create(*rig, config.min_depth_m);
  if (!depth) return depth.error();
  const auto decoder = std::make_shared<const PairDecoder>(*std::move(rig), *std::move(depth));
  Recording recording{.format = "stereo", .folder = folders->recording.path};
  recording.sensor = decoder->depth().sensor();
  recording.entries = *std::move(entries);
  turn_poses(decoder->pair().T_left_rectified, recording.entries);
  recording.camera = decoder->pair().camera;
  recording.has_metric_depth = true;
  recording.decode = [decoder](const FrameEntry& entry, const DecodeSettings& settings) {
    return decoder->decode(entry, settings.limits);
  };
  if (const auto checked = check_pairs(*decoder, config, recording); !checked) return checked.error();
  return recording;
}

}  // namespace scanknit
