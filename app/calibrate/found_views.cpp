#include "app/calibrate/found_views.h"

#include <fmt/format.h>

#include <utility>

namespace scanknit {

Result<void> look_at(const BoardPicture& taken, const CalibrationTarget& target, FoundViews& found) {
  const ColourImage& picture = taken.image;
  if (found.size.width == 0) found.size = {picture.width(), picture.height()};
  if (picture.width() != found.size.width || picture.height() != found.size.height) {
    return Error{ErrorCode::kInput,
                 fmt::format("is {} x {}, the pictures before it are {} x {}; expected pictures of one camera and one "
                             "size",
                             picture.width(), picture.height(), found.size.width, found.size.height),
                 taken.name};
  }
  auto sighting = find_board(picture, target);
  if (!sighting) return sighting.error();
  ++found.by_sight[static_cast<std::size_t>(sighting->sight)];
  if (sighting->sight == BoardSight::kSeen) {
    found.views.push_back({taken.name, std::move(sighting->corners), sighting->sharpness});
  }
  return {};
}

std::optional<Error> why_unseen(const FoundViews& found, std::size_t pictures, const std::string& where) {
  const auto refuse = [&](ErrorCode code, std::string message) { return Error{code, std::move(message), where}; };
  const std::size_t other = found.count(BoardSight::kOther);
  const std::size_t mirrored = found.count(BoardSight::kMirrored);
  const std::size_t parts = found.count(BoardSight::kTooLittle);
  if (other > found.views.size()) {
    return refuse(ErrorCode::kInput,
                  fmt::format("{} of {} pictures show another board than target.yaml describes: other "
                              "tags, or in another arrangement; give the board's own file",
                              other, pictures));
  }
  if (found.views.size() >= kFewestViews) return std::nullopt;
  if (mirrored > found.views.size()) {
    return refuse(ErrorCode::kInput, fmt::format("the board is mirrored in {} of {} pictures; expected pictures as the "
                                                 "camera takes them, of a board that is not printed mirrored",
                                                 mirrored, pictures));
  }
  if (parts > found.views.size()) {
    return refuse(
        ErrorCode::kTooLittle,
        fmt::format("{} of {} pictures show fewer than {} corners of the board: it is too far away, covered or "
                    "out of the picture; expected at least {} pictures that show more",
                    parts, pictures, kFewestCorners, kFewestViews));
  }
  if (!found.views.empty()) return std::nullopt;
  return refuse(ErrorCode::kInput,
                fmt::format("no board is found in {} pictures; expected the board of target.yaml, in "
                            "focus, its tags at least 20 pixels wide",
                            pictures));
}

ScannerCamera cameras_of(const CameraModel& camera, const BoardPictures& pictures, bool is_depth) {
  ScannerCamera cameras;
  (is_depth ? cameras.depth : cameras.colour) = camera;
  if (const auto& depth = pictures.registered_depth; depth && !is_depth) {
    cameras.depth = CameraModel{camera.intrinsics.resized(depth->width, depth->height), camera.distortion};
  }
  return cameras;
}

}  // namespace scanknit
