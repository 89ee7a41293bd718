#include "measure/section/section_drawing.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace scanknit {
namespace {

constexpr double kDrawnMmPerM = 1000;
constexpr std::size_t kMostTexts = 20;  // outlines whose lengths are written on the drawing

struct DrawnText {
  Eigen::Vector2d place_mm;
  std::string text;
};

double text_height_mm(const MeshSection& section) {
  return std::max(1e-3, (section.max_m - section.min_m).maxCoeff() * kDrawnMmPerM / 40);
}

/// The length of each long outline, at its rightmost point.
std::vector<DrawnText> length_texts(const MeshSection& section) {
  std::vector<DrawnText> texts;
  for (const Outline& outline : section.outlines) {
    if (texts.size() == kMostTexts) break;
    const auto rightmost = std::max_element(outline.points_m.begin(), outline.points_m.end(),
                                            [](const auto& a, const auto& b) { return a.x() < b.x(); });
    texts.push_back({kDrawnMmPerM * *rightmost, fmt::format("{:.5g} mm", outline.length_m * kDrawnMmPerM)});
  }
  return texts;
}

std::string summary_of(const MeshSection& section) {
  const Eigen::Vector2d size_mm = (section.max_m - section.min_m) * kDrawnMmPerM;
  return fmt::format("{:.5g} x {:.5g} mm, outlines {:.6g} mm, area {:.6g} mm2", size_mm.x(), size_mm.y(),
                     section.length_m * kDrawnMmPerM, section.area_m2 * kDrawnMmPerM * kDrawnMmPerM);
}

}  // namespace

std::string section_svg(const MeshSection& section) {
  const double text_mm = text_height_mm(section), margin_mm = 3 * text_mm;
  const Eigen::Vector2d size_mm = (section.max_m - section.min_m) * kDrawnMmPerM;
  const double width_mm = std::max(size_mm.x(), 30 * text_mm) + 12 * text_mm, height_mm = size_mm.y() + 3 * margin_mm;
  const auto x_of = [&](double x_mm) { return x_mm - section.min_m.x() * kDrawnMmPerM + margin_mm; };
  const auto y_of = [&](double y_mm) { return section.max_m.y() * kDrawnMmPerM - y_mm + margin_mm; };
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.4f}mm\" height=\"{1:.4f}mm\" viewBox=\"0 0 {0:.4f} "
      "{1:.4f}\" "
      "font-family=\"sans-serif\" font-size=\"{2:.4f}\">\n"
      "<g fill=\"#ddd\" fill-rule=\"evenodd\" stroke=\"#000\" stroke-width=\"{3:.4f}\">\n<path d=\"",
      width_mm, height_mm, text_mm, text_mm / 15);
  const auto path_of = [&](const Outline& outline) {
    std::string path;
    for (std::size_t i = 0; i < outline.points_m.size(); ++i) {
      const Eigen::Vector2d p = kDrawnMmPerM * outline.points_m[i];
      fmt::format_to(std::back_inserter(path), "{}{:.5f} {:.5f}", i == 0 ? 'M' : 'L', x_of(p.x()), y_of(p.y()));
    }
    return path + (outline.is_closed ? "Z\n" : "\n");
  };
  for (const Outline& outline : section.outlines) {
    if (outline.is_closed) svg += path_of(outline);
  }
  svg += "\"/>\n<path fill=\"none\" stroke=\"#c00\" d=\"";
  for (const Outline& outline : section.outlines) {
    if (!outline.is_closed) svg += path_of(outline);
  }
  svg += "\"/>\n</g>\n<g fill=\"#024\">\n";
  for (const DrawnText& text : length_texts(section)) {
    fmt::format_to(std::back_inserter(svg), "<text x=\"{:.4f}\" y=\"{:.4f}\">{}</text>\n",
                   x_of(text.place_mm.x()) + text_mm / 3, y_of(text.place_mm.y()), text.text);
  }
  return svg + fmt::format("<text x=\"{:.4f}\" y=\"{:.4f}\">{}</text>\n</g>\n</svg>\n", margin_mm, height_mm - text_mm,
                           summary_of(section));
}

std::string section_dxf(const MeshSection& section) {
  constexpr int kMillimetres = 4;  // of $INSUNITS
  std::string dxf = fmt::format(
      "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n{}\n0\nENDSEC\n"
      "0\nSECTION\n2\nENTITIES\n",
      kMillimetres);
  for (const Outline& outline : section.outlines) {
    const char* layer = !outline.is_closed ? "OPEN" : outline.area_m2 < 0 ? "HOLES" : "OUTLINES";
    fmt::format_to(std::back_inserter(dxf), "0\nPOLYLINE\n8\n{}\n66\n1\n70\n{}\n10\n0\n20\n0\n30\n0\n", layer,
                   outline.is_closed ? 1 : 0);
    for (const Eigen::Vector2d& p : outline.points_m) {
      fmt::format_to(std::back_inserter(dxf), "0\nVERTEX\n8\n{}\n10\n{:.6f}\n20\n{:.6f}\n30\n0\n", layer,
                     p.x() * kDrawnMmPerM, p.y() * kDrawnMmPerM);
    }
    fmt::format_to(std::back_inserter(dxf), "0\nSEQEND\n8\n{}\n", layer);
  }
  for (const DrawnText& text : length_texts(section)) {
    fmt::format_to(std::back_inserter(dxf), "0\nTEXT\n8\nLENGTHS\n10\n{:.6f}\n20\n{:.6f}\n30\n0\n40\n{:.6f}\n1\n{}\n",
                   text.place_mm.x(), text.place_mm.y(), text_height_mm(section), text.text);
  }
  return dxf + "0\nENDSEC\n0\nEOF\n";
}

}  // namespace scanknit
