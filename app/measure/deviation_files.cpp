#include "app/measure/deviation_files.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/measure/deviation_page.h"
#include "core/files/atomic_file.h"
#include "export/mesh/mesh_extension.h"
#include "export/mesh/write_mesh.h"
#include "export/picture/colour_scale.h"
#include "export/picture/preview.h"
#include "measure/compare/deviation_colours.h"

namespace scanknit {
namespace {

constexpr double kMillimetresPerM = 1000;

/// The axis that usually points up in a file.
UpAxis usual_up(const std::filesystem::path& file) {
  switch (mesh_format(file).value_or(MeshFormat::kPly)) {
    case MeshFormat::kGlb: return UpAxis::kY;
    case MeshFormat::kStl:
    case MeshFormat::kTiles:
    case MeshFormat::kStep:
    case MeshFormat::kThreeMf: return UpAxis::kZ;
    case MeshFormat::kPly:
    case MeshFormat::kObj: break;
  }
  return UpAxis::kMinusY;
}

ColourImage deviation_picture(const Comparison& comparison, const Mesh& coloured) {
  const double end_m = comparison.compared.deviation.histogram.end_m;
  std::vector<Rgb8> colours;
  constexpr int kSteps = 512;
  for (int i = 0; i < kSteps; ++i) colours.push_back(deviation_colour((2.0 * i / (kSteps - 1) - 1) * end_m, end_m));
  std::vector<ScaleLabel> labels;
  for (const double share : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    labels.push_back({(share + 1) / 2, fmt::format("{:+.4g} mm", share * end_m * kMillimetresPerM)});
  }
  const DeviationStats& area = comparison.compared.deviation.area;
  const std::string title = fmt::format(
      "deviation from the reference: mean {:+.4g} mm, rms {:.4g} mm, 95 % within {:.4g} mm",
      area.mean_m * kMillimetresPerM, area.rms_m * kMillimetresPerM, area.absolute_percentiles_m[2] * kMillimetresPerM);
  const ColourImage views = render_two_views(coloured, usual_up(comparison.reference.path), std::nullopt);
  return with_colour_scale(views, colours, labels, title);
}

std::string histogram_svg(const Comparison& comparison) {
  const DeviationHistogram& histogram = comparison.compared.deviation.histogram;
  constexpr double kWidth = 640, kHeight = 240, kBase = 200, kTall = 180, kLeft = 30;
  const double highest = std::max(1e-12, *std::max_element(histogram.shares.begin(), histogram.shares.end()));
  const auto bins = static_cast<double>(histogram.shares.size());
  const double bar = (kWidth - 2 * kLeft) / bins;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" "
      "font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{0}\" height=\"{1}\" fill=\"#fff\"/>\n",
      kWidth, kHeight);
  for (std::size_t i = 0; i < histogram.shares.size(); ++i) {
    const auto place = static_cast<double>(i);
    const double middle_m = ((place + 0.5) / bins * 2 - 1) * histogram.end_m;
    const Rgb8 colour = deviation_colour(middle_m, histogram.end_m);
    const double tall = histogram.shares[i] / highest * kTall;
    svg += fmt::format(
        "<rect x=\"{:.2f}\" y=\"{:.2f}\" width=\"{:.2f}\" height=\"{:.2f}\" fill=\"#{:02x}{:02x}{:02x}\" "
        "stroke=\"#555\" stroke-width=\"0.5\"><title>{:+.4g} mm: {:.3g} %</title></rect>\n",
        kLeft + place * bar, kBase - tall, bar, tall, colour.r, colour.g, colour.b, middle_m * kMillimetresPerM,
        histogram.shares[i] * 100);
  }
  for (const double share : {-1.0, -0.5, 0.0, 0.5, 1.0}) {
    svg +=
        fmt::format("<text x=\"{:.2f}\" y=\"{}\" text-anchor=\"middle\">{:+.4g}</text>\n",
                    kWidth / 2 + share * (kWidth / 2 - kLeft), kBase + 16, share * histogram.end_m * kMillimetresPerM);
  }
  return svg +
         fmt::format(
             "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">deviation of the area, mm; below the scale {:.3g} %, "
             "above it {:.3g} %; highest bar {:.3g} %</text>\n</svg>\n",
             kWidth / 2, kBase + 34, histogram.share_below * 100, histogram.share_above * 100, highest * 100);
}

}  // namespace

Result<void> write_deviation_files(Comparison& comparison, Mesh& mesh, const std::filesystem::path& folder) {
  const MeshDeviation& deviation = comparison.compared.deviation;
  mesh.colours = deviation_colours(deviation.vertices_m, deviation.histogram.end_m);
  const auto written = write_mesh(mesh, folder / "deviation.ply", {}, UpAxis::kMinusY);
  if (!written) return written.error();
  const ColourImage picture = deviation_picture(comparison, mesh);
  const std::string histogram = histogram_svg(comparison);
  if (auto done = write_png(picture, folder / "deviation.png"); !done) return done;
  if (auto done = write_file_atomically(folder / "histogram.svg", histogram); !done) return done;
  const auto page = deviation_page(comparison, picture, histogram);
  if (!page) return page.error();
  if (auto done = write_file_atomically(folder / "report.html", *page); !done) return done;
  for (const char* name : {"deviation.ply", "deviation.png", "histogram.svg", "report.html", "distance.json"}) {
    comparison.files.push_back(folder / name);
  }
  return write_file_atomically(folder / "distance.json", comparison_json(comparison));
}

}  // namespace scanknit
