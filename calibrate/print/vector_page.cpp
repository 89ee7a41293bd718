#include "calibrate/print/vector_page.h"

#include <fmt/format.h>

#include <cstddef>

namespace scanknit {
namespace {

constexpr double kMillimetres = 1000;
constexpr double kPoints = 72 / 0.0254;

std::string escaped_xml(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  return escaped;
}

/// A string object in brackets.
std::string escaped_pdf(const std::string& text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '(' || c == ')' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

/// What draws the page. PDF's y points up from the bottom.
std::string pdf_content(const VectorPage& page) {
  const double height = page.size_m.y();
  std::string content = "0 g\n";
  for (const auto& [corner, size] : page.rectangles) {
    content += fmt::format("{:.4f} {:.4f} {:.4f} {:.4f} re\n", kPoints * corner.x(),
                           kPoints * (height - corner.y() - size.y()), kPoints * size.x(), kPoints * size.y());
  }
  content += "f\n";
  for (const PageText& text : page.texts) {
    content += fmt::format("BT /F1 {:.3f} Tf {} {:.4f} {:.4f} Tm ({}) Tj ET\n", kPoints * text.height_m,
                           text.is_upwards ? "0 1 -1 0" : "1 0 0 1", kPoints * text.baseline_m.x(),
                           kPoints * (height - text.baseline_m.y()), escaped_pdf(text.text));
  }
  return content;
}

}  // namespace

std::string svg_of(const VectorPage& page) {
  const Eigen::Vector2d size = kMillimetres * page.size_m;
  std::string svg = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.4f}mm\" height=\"{1:.4f}mm\" viewBox=\"0 0 {0:.4f} "
      "{1:.4f}\" "
      "shape-rendering=\"crispEdges\">\n<rect width=\"{0:.4f}\" height=\"{1:.4f}\" fill=\"#fff\"/>\n<path d=\"",
      size.x(), size.y());
  for (const auto& [corner, extent] : page.rectangles) {
    svg += fmt::format("M{:.4f} {:.4f}h{:.4f}v{:.4f}h{:.4f}z\n", kMillimetres * corner.x(), kMillimetres * corner.y(),
                       kMillimetres * extent.x(), kMillimetres * extent.y(), -kMillimetres * extent.x());
  }
  svg += "\"/>\n";
  for (const PageText& text : page.texts) {
    svg += fmt::format(
        "<text transform=\"translate({:.4f} {:.4f}){}\" font-family=\"Helvetica, Arial, sans-serif\" "
        "font-size=\"{:.3f}\">{}</text>\n",
        kMillimetres * text.baseline_m.x(), kMillimetres * text.baseline_m.y(), text.is_upwards ? " rotate(-90)" : "",
        kMillimetres * text.height_m, escaped_xml(text.text));
  }
  return svg + "</svg>\n";
}

std::string pdf_of(const VectorPage& page) {
  const std::string content = pdf_content(page);
  const std::vector<std::string> objects = {
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      fmt::format("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.4f} {:.4f}] /Contents 4 0 R "
                  "/Resources << /Font << /F1 5 0 R >> >> >>",
                  kPoints * page.size_m.x(), kPoints * page.size_m.y()),
      fmt::format("<< /Length {} >>\nstream\n{}endstream", content.size(), content),
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
  std::string pdf = "%PDF-1.4\n";
  std::string table = fmt::format("xref\n0 {}\n0000000000 65535 f \n", objects.size() + 1);
  for (std::size_t i = 0; i < objects.size(); ++i) {
    table += fmt::format("{:010} 00000 n \n", pdf.size());
    pdf += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
  }
  const std::size_t place = pdf.size();
  return pdf + table +
         fmt::format("trailer\n<< /Size {} /Root 1 0 R >>\nstartxref\n{}\n%%EOF\n", objects.size() + 1, place);
}

}  // namespace scanknit
