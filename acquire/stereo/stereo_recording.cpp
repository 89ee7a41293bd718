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
#include "acquire/stereo/stereo_opencv.h"
#include "acquire/stereo/stereo_pairs.h"
#include "acquire/stereo/stereo_rig.h"
#include "core/picture/decode_picture.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr double kDisparityNoise_px = 0.2;  // what SGBM does not miss altogether: docs/stereo.md has the figures
constexpr double kNoiseFloor_m = 0.0005;
constexpr double kNearest_m = 0.3;  // where acquire.min_depth does not say it
constexpr double kLeastMatched = 0.01;

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

/// The disparity of the nearest depth that is looked for, as a multiple of 16. Unless asked for, at most a quarter of
/// the picture, and 256 pixels.
int disparities_of(const StereoRig& rig, const AcquireConfig& config) {
  constexpr int kStep = 16;
  const bool is_asked = config.min_depth_m.value_or(0) > 0;
  const int width = rig.left.intrinsics.width;
  const double most = is_asked ? std::min(width / 2, 1024) : std::min(width / 4, 256);
  const double nearest_m = is_asked ? *config.min_depth_m : kNearest_m;
  const double wanted = std::min(rig.left.intrinsics.fx * rig.baseline_m() / nearest_m + 1, most);
  return std::max(1, static_cast<int>(std::ceil(wanted / kStep))) * kStep;
}

DepthImage depth_of(const Image<float>& disparity_px, const RectifiedPair& pair) {
  const double scale = pair.camera.fx * pair.baseline_m;
  auto depth_m = DepthImage::uninitialised(disparity_px.width(), disparity_px.height());
  std::transform(disparity_px.pixels().begin(), disparity_px.pixels().end(), depth_m.pixels().begin(),
                 [&](float disparity) { return disparity > 0 ? static_cast<float>(scale / disparity) : 0.0F; });
  return depth_m;
}

/// Decodes the frames of one recording.
class PairDecoder {
 public:
  PairDecoder(StereoRig rig, std::unique_ptr<StereoMatcher> matcher)
      : rig_(std::move(rig)), matcher_(std::move(matcher)) {}

  [[nodiscard]] const RectifiedPair& pair() const { return matcher_->pair(); }

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
    auto matched = matcher_->match(std::get<Pair>(read_pair).left, std::get<Pair>(read_pair).right);
    if (!matched) return make_drop(DropReason::kUnreadable, "OpenCV could not match the pair", entry.colour);
    const auto pixels = matched->disparity_px.pixels();
    const auto known = std::count_if(pixels.begin(), pixels.end(), [](float d) { return d > 0; });
    const double share = static_cast<double>(known) / static_cast<double>(pixels.size());
    if (share < kLeastMatched) {
      return make_drop(DropReason::kNoDepth,
                       fmt::format("only {:.1f} % of the pixels match: too little texture, or the two pictures do not "
                                   "belong together",
                                   100 * share),
                       entry.colour);
    }
    return DecodedFrame{.depth_m = depth_of(matched->disparity_px, pair()),
                        .colour = std::move(matched->left),
                        .camera = pair().camera,
                        .colour_camera = pair().camera};
  }

  [[nodiscard]] std::optional<PairCheck> check(const Pair& pair) const {
    return matcher_->check(pair.left, pair.right);
  }

 private:
  StereoRig rig_;
  std::unique_ptr<StereoMatcher> matcher_;
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
    const auto found = decoder.check(std::get<Pair>(pair));
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

/// A rig's own: its error in depth is that of its disparities, which grows with the square of the distance.
RecognisedSensor sensor_of(const RectifiedPair& pair) {
  const double scale = pair.camera.fx * pair.baseline_m;
  return {.model = SensorModel::kNone,
          .reason = fmt::format("a stereo rig with a baseline of {:.4g} cm and a focal length of {:.4g} pixels, with "
                                "disparities to {} pixel",
                                100 * pair.baseline_m, pair.camera.fx, kDisparityNoise_px),
          .own_noise = NoiseModel{.floor_m = kNoiseFloor_m, .growth_per_m = kDisparityNoise_px / scale, .from_m = 0}};
}

Result<void> refuse_settings(const AcquireConfig& config, const StereoRig& rig) {
  if (config.camera) {
    return Error{ErrorCode::kConfig,
                 "acquire.camera: not for stereo pairs, whose two cameras are stated by " + rig.file.string(),
                 config.camera->file};
  }
  if (config.intrinsics) {
    return Error{ErrorCode::kConfig,
                 "acquire.intrinsics: not for stereo pairs, whose two cameras are stated by " + rig.file.string()};
  }
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
  const auto opencv = load_stereo_opencv();
  if (!opencv) return opencv.error();
  auto matcher = (*opencv)->make_matcher(*rig, disparities_of(*rig, config));
  if (!matcher) {
    return Error{ErrorCode::kInput, "the rig's pictures cannot be rectified: check the cameras and their places",
                 rig->file.string()};
  }
  const auto decoder = std::make_shared<const PairDecoder>(*std::move(rig), std::move(matcher));
  Recording recording{.format = "stereo", .folder = folders->recording.path};
  recording.sensor = sensor_of(decoder->pair());
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
