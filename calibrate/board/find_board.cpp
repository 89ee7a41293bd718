#include "calibrate/board/find_board.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "calibrate/board/calibrate_opencv.h"
#include "calibrate/lens/homography.h"
#include "core/median.h"

namespace scanknit {
namespace {

using Grey = Image<std::uint8_t>;

// ITU-R BT.601: 0.299 R + 0.587 G + 0.114 B, in 1/256.
Grey grey_of(const ColourImage& picture, bool is_mirrored) {
  Grey grey(picture.width(), picture.height());
  for (int y = 0; y < grey.height(); ++y) {
    for (int x = 0; x < grey.width(); ++x) {
      const Rgb8& c = picture.at(is_mirrored ? grey.width() - 1 - x : x, y);
      grey.at(x, y) = static_cast<std::uint8_t>((77 * c.r + 150 * c.g + 29 * c.b + 128) >> 8);
    }
  }
  return grey;
}

/// By number; a tag that is there twice is not counted: one of the two is something else.
std::map<int, FoundTag> tags_by_number(const std::vector<FoundTag>& found) {
  std::map<int, std::vector<FoundTag>> all;
  for (const FoundTag& tag : found) all[tag.id].push_back(tag);
  std::map<int, FoundTag> tags;
  for (const auto& [id, same] : all) {
    if (same.size() == 1) tags.emplace(id, same.front());
  }
  return tags;
}

Eigen::Matrix3d homography_of(const CalibrationTarget& target, const FoundTag& tag) {
  const auto [corner, side] = tag_place(target, tag.id);
  const std::vector<Eigen::Vector2d> plane = {corner, corner + Eigen::Vector2d(side, 0),
                                              corner + Eigen::Vector2d(side, side), corner + Eigen::Vector2d(0, side)};
  return fit_homography(plane, {tag.corners.begin(), tag.corners.end()});
}

/// Pixels for a metre at `at`, in the direction in which it is shortest.
double scale_at(const Eigen::Matrix3d& H, const Eigen::Vector2d& at, double step_m) {
  const Eigen::Vector2d here = apply(H, at);
  const double right = (apply(H, at + Eigen::Vector2d(step_m, 0)) - here).norm();
  const double down = (apply(H, at + Eigen::Vector2d(0, step_m)) - here).norm();
  return std::min(right, down) / step_m;
}

/// Where the tags of a picture say that the corners are. By number.
std::map<int, RoughCorner> expected_corners(const CalibrationTarget& target, const std::map<int, FoundTag>& tags) {
  const std::vector<Eigen::Vector2d> corners_m = target_corners(target);
  const double clear_m = clear_radius_m(target);
  std::map<int, std::vector<RoughCorner>> told;
  for (const auto& [id, tag] : tags) {
    const Eigen::Matrix3d H = homography_of(target, tag);
    for (const int number : corners_of_tag(target, id)) {
      const Eigen::Vector2d& corner_m = corners_m[static_cast<std::size_t>(number)];
      told[number].push_back({apply(H, corner_m), clear_m * scale_at(H, corner_m, clear_m)});
    }
  }
  std::map<int, RoughCorner> expected;
  for (const auto& [number, opinions] : told) {
    RoughCorner mean{Eigen::Vector2d::Zero(), opinions.front().radius_px};
    for (const RoughCorner& opinion : opinions) {
      mean.pixel += opinion.pixel / static_cast<double>(opinions.size());
      mean.radius_px = std::min(mean.radius_px, opinion.radius_px);
    }
    expected.emplace(number, mean);
  }
  return expected;
}

bool is_inside(const Grey& grey, const RoughCorner& corner) {
  constexpr double kMargin_px = 4;  // the gradient needs a neighbour, the first places are some pixels wrong
  const double reach = std::max(2.0, corner.radius_px) + kMargin_px;
  const Eigen::Vector2d& p = corner.pixel;
  return p.x() >= reach && p.y() >= reach && p.x() <= grey.width() - 1 - reach && p.y() <= grey.height() - 1 - reach;
}

double steepness(const Grey& grey, const RoughCorner& corner) {
  const int reach = std::max(2, static_cast<int>(corner.radius_px));
  const int cx = static_cast<int>(std::lround(corner.pixel.x()));
  const int cy = static_cast<int>(std::lround(corner.pixel.y()));
  int low = 255, high = 0, right = 0, down = 0;
  for (int y = cy - reach; y <= cy + reach; ++y) {
    for (int x = cx - reach; x <= cx + reach; ++x) {
      const int value = grey.at(x, y);
      low = std::min(low, value);
      high = std::max(high, value);
      right = std::max(right, std::abs(grey.at(x + 1, y) - grey.at(x - 1, y)));
      down = std::max(down, std::abs(grey.at(x, y + 1) - grey.at(x, y - 1)));
    }
  }
  return high > low ? std::min(right, down) / (2.0 * (high - low)) : 0;
}

/// Places the corners exactly. One that leaves the part in which the print is symmetrical is dropped: it found another.
void place_exactly(const Grey& grey, const CalibrateOpenCv& opencv, std::map<int, RoughCorner> expected,
                   BoardSighting& sighting) {
  std::vector<RoughCorner> places;
  constexpr double kLeastRadius_px = 2.5;  // below, what is beyond the symmetrical part pulls the corner away
  std::erase_if(expected, [&](const auto& corner) {
    return corner.second.radius_px < kLeastRadius_px || !is_inside(grey, corner.second);
  });
  for (const auto& [number, corner] : expected) places.push_back(corner);
  opencv.refine(grey, places);
  std::vector<double> steep;
  std::size_t i = 0;
  for (const auto& [number, rough] : expected) {
    const RoughCorner& place = places[i++];
    const bool strays = !((place.pixel - rough.pixel).norm() <= std::max(2.0, rough.radius_px));
    if (strays || !is_inside(grey, {place.pixel, rough.radius_px - 2})) continue;
    sighting.corners.push_back({number, place.pixel});
    steep.push_back(steepness(grey, place));
  }
  if (!steep.empty()) sighting.sharpness = median(steep);
}

/// A lens bends the board a little; a board of other columns has its tags elsewhere altogether.
bool fits(const CalibrationTarget& target, const std::vector<SeenCorner>& corners) {
  const std::vector<Eigen::Vector2d> corners_m = target_corners(target);
  std::vector<Eigen::Vector2d> plane, pixels;
  for (const SeenCorner& corner : corners) {
    plane.push_back(corners_m[static_cast<std::size_t>(corner.number)]);
    pixels.push_back(corner.pixel);
  }
  const Eigen::Matrix3d H = fit_homography(plane, pixels);
  std::vector<double> errors_in_sizes;
  for (std::size_t i = 0; i < plane.size(); ++i) {
    const double size_px = target.size_m * scale_at(H, plane[i], target.size_m);
    errors_in_sizes.push_back((apply(H, plane[i]) - pixels[i]).norm() / size_px);
  }
  constexpr double kMost = 0.25;
  return median(errors_in_sizes) < kMost;
}

}  // namespace

Result<BoardSighting> find_board(const ColourImage& picture, const CalibrationTarget& target) {
  const auto opencv = load_calibrate_opencv();
  if (!opencv) return opencv.error();
  const Grey grey = grey_of(picture, false);
  auto tags = tags_by_number((*opencv)->find_tags(grey));
  BoardSighting sighting;
  if (tags.empty()) {
    constexpr std::size_t kCertain = 2;  // one may be an accident
    const auto mirrored = (*opencv)->find_tags(grey_of(picture, true));
    if (mirrored.size() >= kCertain) sighting.sight = BoardSight::kMirrored;
    return sighting;
  }
  const std::size_t foreign = std::erase_if(tags, [&](const auto& tag) { return tag.first >= tag_count(target); });
  place_exactly(grey, **opencv, expected_corners(target, tags), sighting);
  const bool is_enough = sighting.corners.size() >= kFewestCorners;
  const bool is_other = foreign > tags.size() || (is_enough && !fits(target, sighting.corners));
  sighting.sight = is_other ? BoardSight::kOther : is_enough ? BoardSight::kSeen : BoardSight::kTooLittle;
  if (sighting.sight != BoardSight::kSeen) sighting.corners.clear();
  return sighting;
}

}  // namespace scanknit
