#include <gtest/gtest.h>

#include <set>
#include <sstream>
#include <string>

#include "calibrate/print/target_page.h"
#include "calibrate/print/vector_page.h"
#include "calibrate/target/calibration_target.h"

namespace scanknit {
namespace {

constexpr CalibrationTarget kGrid{TargetType::kAprilGrid, 6, 4, 0.03};
constexpr CalibrationTarget kChess{TargetType::kCharuco, 9, 6, 0.028};

/// Whether a point is black, by the shapes that are printed.
bool is_black(const std::vector<BlackRectangle>& shapes, const Eigen::Vector2d& at) {
  for (const auto& [corner, size] : shapes) {
    const Eigen::Array2d within = (at - corner).array();
    if ((within >= 0).all() && (within < size.array()).all()) return true;
  }
  return false;
}

class EveryTarget : public ::testing::TestWithParam<CalibrationTarget> {};
INSTANTIATE_TEST_SUITE_P(Calibration, EveryTarget, ::testing::Values(kGrid, kChess), [](const auto& target) {
  return target.param.type == TargetType::kCharuco ? "chess" : "grid";
});

TEST_P(EveryTarget, LooksTheSameRoundACornerAfterHalfATurn) {
  const auto shapes = target_shapes(GetParam());
  ASSERT_TRUE(shapes) << shapes.error().text();
  const double reach_m = clear_radius_m(GetParam());
  std::size_t black = 0, points = 0;
  for (const Eigen::Vector2d& corner : target_corners(GetParam())) {
    for (int i = 0; i < 400; ++i) {  // off the edges: none lies at such a share of the reach
      const Eigen::Vector2d off(reach_m * 0.0997 * (i % 20 - 9.53), reach_m * 0.0997 * (i / 20 - 9.53));
      if (off.cwiseAbs().maxCoeff() > 0.9 * reach_m) continue;
      const bool here = is_black(*shapes, corner + off);
      EXPECT_EQ(here, is_black(*shapes, corner - off)) << corner.transpose() << " + " << off.transpose();
      black += here ? 1 : 0;
      ++points;
    }
  }
  EXPECT_GT(black, points / 5);
  EXPECT_LT(black, points * 4 / 5);
}

TEST_P(EveryTarget, ReachesFromItsOriginToItsExtent) {
  const auto shapes = target_shapes(GetParam());
  ASSERT_TRUE(shapes);
  Eigen::AlignedBox2d box;
  for (const auto& [corner, size] : *shapes) box.extend(corner), box.extend(corner + size);
  EXPECT_LT(box.min().norm(), 1e-12);
  EXPECT_LT((box.max() - extent_m(GetParam())).norm(), 1e-12);
}

TEST_P(EveryTarget, HasEveryCornerAtSomeTag) {
  std::set<int> seen;
  for (int tag = 0; tag < tag_count(GetParam()); ++tag) {
    for (const int corner : corners_of_tag(GetParam(), tag)) seen.insert(corner);
  }
  EXPECT_EQ(seen.size(), target_corners(GetParam()).size());
}

TEST(CalibrationTarget, OfImpossibleNumbersIsRefused) {
  for (const auto& [target, part] : std::vector<std::pair<CalibrationTarget, std::string>>{
           {{TargetType::kAprilGrid, 1, 4, 0.03}, "columns: 1"},
           {{TargetType::kCharuco, 9, 2, 0.03}, "rows: 2"},
           {{TargetType::kAprilGrid, 40, 40, 0.03}, "1600 tags"},
           {{TargetType::kAprilGrid, 6, 4, 0}, "size: 0"},
           {{TargetType::kAprilGrid, 6, 4, std::nan("")}, "size: nan"}}) {
    const auto valid = validate(target);
    ASSERT_FALSE(valid) << part;
    EXPECT_EQ(valid.error().code, ErrorCode::kConfig);
    EXPECT_NE(valid.error().message.find(part), std::string::npos) << valid.error().message;
  }
}

TEST_P(EveryTarget, FitsOnPaperAtTheLargestSizeAndNoLarger) {
  for (const Paper paper : {Paper::kA4, Paper::kA3, Paper::kLetter}) {
    CalibrationTarget target = GetParam();
    const auto largest = largest_size_m(target, paper);
    ASSERT_TRUE(largest);
    target.size_m = *largest;
    EXPECT_TRUE(target_page(target, paper));
    target.size_m += 0.001;
    const auto page = target_page(target, paper);
    ASSERT_FALSE(page);
    EXPECT_EQ(page.error().code, ErrorCode::kUsage);
    EXPECT_NE(page.error().message.find(std::to_string(static_cast<int>(*largest * 1000 + 0.5)) + " mm"),
              std::string::npos)
        << page.error().message;
  }
}

/// The board and the lines of 100 mm are in the PDF in points of 1/72 inch: what it says is measured back.
TEST(TargetPage, IsOfTrueSizeAsPdf) {
  const auto page = target_page(kGrid, Paper::kA4);
  ASSERT_TRUE(page);
  const std::string pdf = pdf_of(*page);
  std::istringstream lines(pdf);
  constexpr double kMillimetres = 25.4 / 72;
  double widest_line = 0, tallest_line = 0;
  std::size_t tags_rows = 0;
  for (std::string line; std::getline(lines, line);) {
    double x = 0, y = 0, width = 0, height = 0;
    if (std::sscanf(line.c_str(), "%lf %lf %lf %lf re", &x, &y, &width, &height) != 4) continue;
    if (height < 1) widest_line = std::max(widest_line, width * kMillimetres);
    if (width < 1) tallest_line = std::max(tallest_line, height * kMillimetres);
    tags_rows += std::abs(width * kMillimetres - 30) < 1e-3 ? 1 : 0;  // a tag's upper or lower border
  }
  constexpr double kBars_mm = 0.6;  // the line is between two bars of 0.3 mm
  EXPECT_NEAR(widest_line, 100 - kBars_mm, 1e-3);
  EXPECT_NEAR(tallest_line, 100 - kBars_mm, 1e-3);
  EXPECT_EQ(tags_rows, 2u * 24);
  EXPECT_NE(pdf.find("/MediaBox [0 0 841.8898 595.2756]"), std::string::npos) << "A4 across";
  EXPECT_NE(pdf.find("/PrintScaling /None"), std::string::npos);
}

TEST(TargetPage, HasATableOfItsPdfObjectsThatIsRight) {
  const auto page = target_page(kChess, Paper::kA4);
  ASSERT_TRUE(page);
  const std::string pdf = pdf_of(*page);
  const std::size_t start = pdf.rfind("startxref\n") + 10;
  const std::size_t table = std::stoul(pdf.substr(start));
  EXPECT_EQ(pdf.substr(table, 5), "xref\n");
  std::istringstream entries(pdf.substr(table));
  std::string line;
  std::getline(entries, line), std::getline(entries, line), std::getline(entries, line);
  for (int object = 1; object <= 5; ++object) {
    std::getline(entries, line);
    const std::string begin = std::to_string(object) + " 0 obj";
    EXPECT_EQ(pdf.substr(std::stoul(line), begin.size()), begin);
  }
}

TEST(TargetPage, IsOfTrueSizeAsSvg) {
  const auto page = target_page(kChess, Paper::kA3);
  ASSERT_TRUE(page);
  const std::string svg = svg_of(*page);
  EXPECT_NE(svg.find("width=\"420.0000mm\" height=\"297.0000mm\" viewBox=\"0 0 420.0000 297.0000\""),
            std::string::npos);
  EXPECT_NE(svg.find("h28.0000v28.0000h-28.0000z"), std::string::npos);
  EXPECT_NE(svg.find("Both lines must measure 100.0 mm"), std::string::npos);
}

}  // namespace
}  // namespace scanknit
