// The module libscanknit_calibrate_opencv.so.
#include <algorithm>
#include <opencv2/aruco.hpp>
#include <opencv2/core.hpp>
#include <opencv2/core/ocl.hpp>
#include <opencv2/imgproc.hpp>

#include "calibrate/board/calibrate_opencv.h"
#include "core/version.h"

namespace scanknit {
namespace {

cv::Ptr<cv::aruco::Dictionary> family() {
  return cv::aruco::getPredefinedDictionary(cv::aruco::DICT_APRILTAG_36h11);
}

/// OpenCV only reads it.
cv::Mat matrix_of(const Image<std::uint8_t>& grey) {
  return {grey.height(), grey.width(), CV_8U, const_cast<std::uint8_t*>(grey.pixels().data())};  // NOLINT
}

TagCells tag_cells(int id) {
  cv::Mat drawn;
  cv::aruco::drawMarker(family(), id, kTagCells, drawn);
  TagCells cells;
  for (int i = 0; i < kTagCells * kTagCells; ++i) {
    cells.black[static_cast<std::size_t>(i)] = drawn.at<std::uint8_t>(i / kTagCells, i % kTagCells) == 0;
  }
  return cells;
}

// At twice the size: the outlines of small tags are found whose white gaps are less than two pixels wide.
std::vector<FoundTag> find_tags(const Image<std::uint8_t>& grey) {
  constexpr int kTimes = 2;
  cv::Mat larger;
  cv::resize(matrix_of(grey), larger, {}, kTimes, kTimes, cv::INTER_LINEAR);
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  try {
    cv::aruco::detectMarkers(larger, family(), corners, ids);
  } catch (const cv::Exception&) {
    return {};  // a picture of a few pixels
  }
  std::vector<FoundTag> tags;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    FoundTag& tag = tags.emplace_back();
    tag.id = ids[i];
    for (std::size_t k = 0; k < tag.corners.size(); ++k) {  // pixel centres are integers in both pictures
      tag.corners[k] = {(corners[i][k].x + 0.5) / kTimes - 0.5, (corners[i][k].y + 0.5) / kTimes - 0.5};
    }
  }
  return tags;
}

void refine(const Image<std::uint8_t>& grey, std::vector<RoughCorner>& corners) {
  const cv::Mat picture = matrix_of(grey);
  const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 1e-3);
  for (RoughCorner& corner : corners) {
    std::vector<cv::Point2f> point = {{static_cast<float>(corner.pixel.x()), static_cast<float>(corner.pixel.y())}};
    // With less, only one of the two shapes that meet at a corner may be seen, and its own corner is found.
    const int reach = std::max(3, static_cast<int>(corner.radius_px));
    cv::cornerSubPix(picture, point, {reach, reach}, {-1, -1}, until);
    corner.pixel = {point[0].x, point[0].y};
  }
}

}  // namespace
}  // namespace scanknit

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  using namespace scanknit;
  static constexpr CalibrateOpenCv kOffers{tag_cells, find_tags, refine};
  static constexpr ModuleEntry kEntry{kVersion, &kOffers};
  cv::ocl::setUseOpenCL(false);
  return &kEntry;
}
