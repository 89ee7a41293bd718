#include "acquire/replay/indexed_source.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "acquire/masks/check_masks.h"
#include "acquire/masks/found_masks.h"
#include "acquire/masks/frame_mask.h"
#include "acquire/masks/mask_files.h"
#include "acquire/replay/undistort.h"
#include "acquire/sensor/recognise_sensor.h"

namespace scanknit {
namespace {

std::string size_text(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

// The camera of a picture of this size: an unknown size (0) becomes the picture's, another size is a contradiction.
OrDrop<CameraIntrinsics> fit_camera(CameraIntrinsics camera, int width, int height, const std::filesystem::path& path) {
  if (camera.width == 0 && camera.height == 0) {
    camera.width = width;
    camera.height = height;
  }
  if (camera.width != width || camera.height != height) {
    return make_drop(
        DropReason::kSizeMismatch,
        "the picture is " + size_text(width, height) + ", its camera " + size_text(camera.width, camera.height), path);
  }
  if (!camera.is_valid()) return make_drop(DropReason::kNoIntrinsics, "the camera's intrinsics are not usable", path);
  return camera;
}

const ScannerCamera& stated_cameras(const AcquireConfig& config) {
  static const ScannerCamera kNothing;
  return config.camera ? *config.camera : kNothing;
}

// The camera of colour that the configuration states, or the files (which is straight then), else the depth camera's
// for the colour's size: such recordings are registered. `depth_camera` has the distortion that colour still has then.
CameraModel colour_camera(const DecodedFrame& decoded, const CameraModel& depth_camera, const ScannerCamera& stated) {
  if (stated.colour) return *stated.colour;
  if (decoded.colour_camera) return {*decoded.colour_camera, {}};
  return {depth_camera.intrinsics.resized(decoded.colour.width(), decoded.colour.height()), depth_camera.distortion};
}

Pose colour_pose(const DecodedFrame& decoded, const ScannerCamera& stated) {
  return stated.T_colour_depth.value_or(decoded.T_colour_depth);
}

OrDrop<ColourFrame> settle_colour(DecodedFrame& decoded, const CameraModel& depth_camera, const ScannerCamera& stated,
                                  const std::filesystem::path& path) {
  const CameraModel model = colour_camera(decoded, depth_camera, stated);
  auto camera = fit_camera(model.intrinsics, decoded.colour.width(), decoded.colour.height(), path);
  if (auto* drop = std::get_if<Drop>(&camera)) return std::move(*drop);
  ColourFrame colour{std::move(decoded.colour), std::get<CameraIntrinsics>(camera), colour_pose(decoded, stated),
                     decoded.encoded_colour};
  if (model.distortion != Distortion{}) {
    colour.image = undistort(colour.image, colour.intrinsics, model.distortion);
    colour.encoded = nullptr;
  }
  return colour;
}

/// True if a place in the colour picture is the same place in the depth picture, whatever their sizes, to a hundredth
/// of their width.
bool sees_the_same(const CameraIntrinsics& colour, const Pose& T_colour_depth, const CameraIntrinsics& depth) {
  constexpr double kNear_m = 0.002, kWithin = 0.01;
  if (T_colour_depth.translation().norm() > kNear_m) return false;
  const CameraIntrinsics same = depth.resized(colour.width, colour.height);
  for (const auto& [u, v] :
       {std::pair(0, 0), {same.width - 1, 0}, {0, same.height - 1}, {same.width - 1, same.height - 1}}) {
    const Eigen::Vector3d p = T_colour_depth.linear() * same.unproject(u, v, 1);
    if (!(p.z() > 0) || !((colour.project(p) - Eigen::Vector2d(u, v)).norm() <= kWithin * colour.width)) return false;
  }
  return true;
}

}  // namespace

IndexedSource::IndexedSource(Recording recording, const AcquireConfig& config, EmptyPicture empty)
    : recording_(std::move(recording)), config_(config), masks_(mask_origin(config)), empty_(std::move(empty)) {
  next_ = config_.from;
  last_ = std::min(config_.to, recording_.entries.size() - 1);
  if (const std::size_t jumps = make_times_ascend(recording_.entries); jumps > 0) {
    recording_.warnings.push_back("the time stamps step back or stand still " + std::to_string(jumps) +
                                  " times: the frames are taken in the order in which they were recorded, and at each "
                                  "of these times the clock goes on by the usual interval");
  }
  describe();
  look_at_first_frames();
  if (masks_ != MaskOrigin::kNone) look_at_masks();
}

void IndexedSource::describe() {
  const auto& entries = recording_.entries;
  info_.format = recording_.format;
  info_.folder = recording_.folder;
  info_.frames = entries.size();
  info_.sensor = recording_.sensor;
  info_.world_up = recording_.world_up;
  info_.topics = recording_.topics;
  info_.warnings = recording_.warnings;
  if (!recording_.has_metric_depth) {
    const auto of_entry = entries.empty() ? Rare<double>() : entries.front().depth_scale;
    info_.depth_scale = config_.depth_scale.value_or(of_entry.value_or(recording_.depth_scale));
  }
  info_.frames_with_pose =
      recording_.frames_bring_pose
          ? entries.size()
          : static_cast<std::size_t>(std::count_if(entries.begin(), entries.end(), [](const FrameEntry& entry) {
              return entry.T_world_camera.has_value();
            }));
  info_.poses = config_.poses;
  if (info_.poses == PoseMode::kAuto) {
    info_.poses = info_.frames_with_pose > 0 ? PoseMode::kRecording : PoseMode::kTrack;
  }
  // Without a single pose the world is the first camera's.
  if (info_.frames_with_pose == 0) info_.world_up = UpAxis::kMinusY;
  info_.has_colour =
      std::any_of(entries.begin(), entries.end(), [](const FrameEntry& entry) { return !entry.colour.empty(); });
  has_clock_ = std::all_of(entries.begin(), entries.end(), [](const FrameEntry& entry) {
    return entry.fault.has_value() || entry.timestamp_ns.has_value();
  });
  const auto first = std::find_if(entries.begin(), entries.end(),
                                  [](const FrameEntry& entry) { return entry.timestamp_ns.has_value(); });
  const auto last = std::find_if(entries.rbegin(), entries.rend(),
                                 [](const FrameEntry& entry) { return entry.timestamp_ns.has_value(); });
  if (!has_clock_ || first == entries.end()) {
    has_clock_ = false;
    return;
  }
  info_.duration_s = (static_cast<double>(*last->timestamp_ns) - static_cast<double>(*first->timestamp_ns)) * 1e-9;
}

/// And at some more where the first one has no colour and later ones do, as where colour began later.
void IndexedSource::look_at_first_frames() {
  int left = 8;  // that should have colour
  for (std::size_t index = next_; index <= last_ && left > 0; index += config_.every) {
    const FrameEntry& entry = recording_.entries[index];
    if (!info_.intrinsics || !entry.colour.empty()) {
      std::optional<Result<Pose>> pose;
      const auto loaded = load_pictures(entry, pose);
      if (const auto* frame = std::get_if<Frame>(&loaded)) {
        if (!config_.sensor && !info_.sensor) info_.sensor = sensor_by_depth(frame->depth_m, frame->intrinsics);
        if (!info_.intrinsics) info_.intrinsics = frame->intrinsics;
        // A camera whose picture is mirrored top to bottom looks into a world whose y points up (ICL-NUIM).
        if (frame->intrinsics.fy < 0) info_.world_up = UpAxis::kY;
        if (frame->colour) info_.colour_intrinsics = frame->colour->intrinsics;
        info_.has_colour |= frame->colour.has_value();
        if (frame->colour || !info_.has_colour) return;
        if (!entry.colour.empty()) --left;
      }
    }
    if (config_.every > last_ - index) return;
  }
}

/// At some of them, evenly spread: faulty masks are told before the scan.
void IndexedSource::look_at_masks() {
  constexpr std::size_t kMost = 8;
  if (!info_.intrinsics) return;
  AcquireConfig as_in_file = config_;
  as_in_file.mask_class.reset();
  as_in_file.keeps_labels = as_in_file.keeps_labels || config_.mask_class;
  std::vector<MaskFile> masks;
  const std::size_t frames = (last_ - next_) / config_.every + 1;
  const std::size_t looked_at = std::min(frames, kMost);
  for (std::size_t i = 0; i < looked_at; ++i) {
    const FrameEntry& entry = recording_.entries[next_ + i * frames / looked_at * config_.every];
    if (masks_ != MaskOrigin::kFiles) {
      const auto decoded = recording_.decode(entry, decode_settings(entry));
      if (!std::holds_alternative<DecodedFrame>(decoded)) continue;
      auto found = find_mask_in_colour(entry, std::get<DecodedFrame>(decoded), *info_.intrinsics);
      if (auto* mask = std::get_if<Mask>(&found)) masks.push_back({entry.colour, std::move(*mask)});
      continue;
    }
    const std::filesystem::path path = mask_of(entry);
    auto mask = path.empty() ? Result<Mask>(Mask()) : read_mask(path, as_in_file);
    if (mask && !mask->empty()) masks.push_back({path, *std::move(mask)});
  }
  for (std::string& warning : mask_warnings(masks, info_.intrinsics->width, info_.intrinsics->height, config_)) {
    info_.warnings.push_back(std::move(warning));
  }
}

FrameEvent IndexedSource::next(std::stop_token stop) {
  if (stop.stop_requested() || is_at_end_ || next_ > last_) return EndOfStream{};
  const std::size_t index = next_;
  go_on();
  return frame(index);
}

FrameEvent IndexedSource::frame(std::size_t index) {
  auto loaded = load(index);
  if (auto* drop = std::get_if<Drop>(&loaded)) {
    return FrameDropped{recording_.entries[index].sequence, drop->reason, std::move(drop->error)};
  }
  return std::get<Frame>(std::move(loaded));
}

void IndexedSource::skip_until(const std::function<bool(std::uint64_t sequence)>& is_wanted) {
  while (!is_at_end_ && next_ <= last_ && !is_wanted(recording_.entries[next_].sequence)) go_on();
}

void IndexedSource::go_on() {
  is_at_end_ = config_.every > last_ - next_;  // compared this way round, the sum cannot overflow
  if (!is_at_end_) next_ += config_.every;
}

OrDrop<Frame> IndexedSource::load(std::size_t index) {
  const FrameEntry& entry = recording_.entries[index];
  std::optional<Result<Pose>> pose;
  auto loaded = load_pictures(entry, pose);
  if (std::holds_alternative<Drop>(loaded)) return loaded;
  auto& frame = std::get<Frame>(loaded);

  const CameraIntrinsics first = info_.intrinsics.value_or(frame.intrinsics);
  if (frame.depth_m.width() != first.width || frame.depth_m.height() != first.height) {
    return make_drop(DropReason::kSizeMismatch,
                     "the depth picture is " + size_text(frame.depth_m.width(), frame.depth_m.height()) +
                         ", the first frame's " + size_text(first.width, first.height),
                     entry.depth);
  }
  correct_depth(frame);
  const auto depth = frame.depth_m.pixels();
  const bool has_depth = std::any_of(depth.begin(), depth.end(), [](float z) { return z > 0; });
  if (!has_depth && !is_tracked(info_.poses)) {
    return make_drop(DropReason::kNoDepth, "not one pixel has a depth", entry.depth);
  }
  if (auto drop = settle_pose(entry, pose, frame)) return *std::move(drop);
  frame.has_clock = has_clock_;
  frame.timestamp_ns = has_clock_ ? *entry.timestamp_ns : static_cast<std::int64_t>(index);
  frame.sequence = entry.sequence;
  return loaded;
}

/// Not before the sensor was recognised: by the steps of its depth.
void IndexedSource::correct_depth(Frame& frame) {
  if (!config_.camera || !config_.camera->depth_bias) return;
  if (!correction_) correction_.emplace(*config_.camera->depth_bias, frame.depth_m.width(), frame.depth_m.height());
  correction_->apply(frame.depth_m);
  if (!frame.outside_m.empty()) correction_->apply(frame.outside_m);
}

DecodeSettings IndexedSource::decode_settings(const FrameEntry& entry) const {
  return {.depth_scale = config_.depth_scale.value_or(entry.depth_scale.value_or(recording_.depth_scale)),
          .min_confidence = config_.min_confidence,
          .limits = config_.limits};
}

OrDrop<Frame> IndexedSource::load_pictures(const FrameEntry& entry, std::optional<Result<Pose>>& pose) const {
  if (entry.fault) return *entry.fault;
  auto decoding = recording_.decode(entry, decode_settings(entry));
  if (auto* drop = std::get_if<Drop>(&decoding)) return std::move(*drop);
  auto& decoded = std::get<DecodedFrame>(decoding);
  pose = decoded.T_world_camera ? decoded.T_world_camera : entry.T_world_camera.copy();

  std::optional<CameraIntrinsics> stated = decoded.camera ? decoded.camera : recording_.camera;
  if (config_.intrinsics) stated = config_.intrinsics->intrinsics;
  if (!stated) return make_drop(DropReason::kNoIntrinsics, "the frame's camera is unknown", entry.depth);
  auto camera = fit_camera(*stated, decoded.depth_m.width(), decoded.depth_m.height(), entry.depth);
  if (auto* drop = std::get_if<Drop>(&camera)) return std::move(*drop);

  Frame frame;
  frame.intrinsics = std::get<CameraIntrinsics>(camera);
  frame.depth_m = std::move(decoded.depth_m);
  const Distortion distortion = config_.intrinsics ? config_.intrinsics->distortion : Distortion{};
  if (distortion != Distortion{}) frame.depth_m = undistort(frame.depth_m, frame.intrinsics, distortion);
  if (masks_ != MaskOrigin::kNone) {
    if (auto drop = use_mask(entry, decoded, distortion, frame)) return *std::move(drop);
  }
  if (!decoded.colour.empty()) {
    auto colour = settle_colour(decoded, {frame.intrinsics, distortion}, stated_cameras(config_), entry.colour);
    if (auto* drop = std::get_if<Drop>(&colour)) return std::move(*drop);
    frame.colour = std::get<ColourFrame>(std::move(colour));
  }
  return frame;
}

std::filesystem::path IndexedSource::mask_of(const FrameEntry& entry) const {
  std::filesystem::path path = find_mask(masks_folder(), entry.depth);
  if (path.empty() && !entry.colour.empty()) path = find_mask(masks_folder(), entry.colour);
  return path;
}

OrDrop<Mask> IndexedSource::read_mask_file(const FrameEntry& entry) const {
  const std::filesystem::path path = mask_of(entry);
  if (path.empty()) {
    return make_drop(DropReason::kMissingFile, "no mask of this frame in " + masks_folder().string(), entry.depth);
  }
  auto mask = read_mask(path, config_);
  if (!mask) return make_drop(DropReason::kUnreadable, mask.error().message, path);
  return *std::move(mask);
}

/// A mask from the colour picture, which must show what the depth camera sees.
OrDrop<Mask> IndexedSource::find_mask_in_colour(const FrameEntry& entry, const DecodedFrame& decoded,
                                                const CameraIntrinsics& depth_camera) const {
  const bool is_alpha = masks_ == MaskOrigin::kAlpha;
  const std::string key = masks_ == MaskOrigin::kDifference ? "acquire.background" : "acquire.masks: " + *config_.masks;
  if (decoded.colour.empty()) {
    return make_drop(DropReason::kMissingFile, key + " needs a colour picture, which this frame has not", entry.depth);
  }
  const ScannerCamera& stated = stated_cameras(config_);
  const CameraIntrinsics camera = colour_camera(decoded, {depth_camera, {}}, stated).intrinsics;
  if (!sees_the_same(camera, colour_pose(decoded, stated), depth_camera)) {
    return make_drop(DropReason::kNoIntrinsics,
                     key +
                         " needs colour in the depth camera's view, but this recording's colour camera "
                         "sees another; give a folder of masks of the depth pictures (acquire.masks)",
                     entry.colour);
  }
  if (is_alpha && !decoded.encoded_colour) {
    return make_drop(DropReason::kUnreadable, "this recording's colour has no alpha (acquire.masks: alpha)",
                     entry.colour);
  }
  const auto encoded = is_alpha ? std::span<const std::byte>(*decoded.encoded_colour) : std::span<const std::byte>();
  auto mask = find_mask(masks_, decoded.colour, encoded, empty_, config_.limits);
  if (!mask) return make_drop(DropReason::kUnreadable, mask.error().message + " (" + key + ")", entry.colour);
  return *std::move(mask);
}

/// Leaves the depth within the frame's mask, or adds its labels.
std::optional<Drop> IndexedSource::use_mask(const FrameEntry& entry, const DecodedFrame& decoded,
                                            const Distortion& distortion, Frame& frame) const {
  auto found =
      masks_ == MaskOrigin::kFiles ? read_mask_file(entry) : find_mask_in_colour(entry, decoded, frame.intrinsics);
  if (auto* drop = std::get_if<Drop>(&found)) return std::move(*drop);
  const Mask& whole = std::get<Mask>(found);
  const auto as_the_depth = [&](Mask mask) {
    return distortion != Distortion{} ? undistort(mask, frame.intrinsics, distortion) : mask;
  };
  const int width = frame.depth_m.width(), height = frame.depth_m.height();
  Mask mask = as_the_depth(resized(whole, width, height));
  if (config_.keeps_labels) {
    frame.labels = std::move(mask);
    return std::nullopt;
  }
  keep_within(mask, config_.mask_means, frame);
  if (config_.keeps_masks) frame.labels = as_the_depth(resized_by_mean(whole, width, height));
  return std::nullopt;
}

std::optional<Drop> IndexedSource::settle_pose(const FrameEntry& entry, const std::optional<Result<Pose>>& pose,
                                               Frame& frame) const {
  if (info_.poses == PoseMode::kStill) {
    frame.T_world_camera = Pose::Identity();
    return std::nullopt;
  }
  if (is_tracked(info_.poses)) {
    if (pose && *pose) frame.T_world_camera = **pose;
    return std::nullopt;
  }
  if (!pose) return make_drop(DropReason::kNoPose, "the frame has no pose", entry.depth);
  if (!*pose) return Drop{DropReason::kBadPose, pose->error()};
  frame.T_world_camera = **pose;
  return std::nullopt;
}

}  // namespace scanknit
