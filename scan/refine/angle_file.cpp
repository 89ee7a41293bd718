#include "scan/refine/angle_file.h"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <string_view>

#include "core/files/quantity.h"
#include "core/files/read_file.h"

namespace scanknit {

Result<std::vector<double>> read_angle_file(const std::filesystem::path& path) {
  constexpr std::uintmax_t kMostBytes = 64u << 20;
  const auto text = read_text_file(path, kMostBytes);
  if (!text) return Error{ErrorCode::kConfig, text.error().message, path.string()};
  std::vector<double> degrees;
  std::size_t number = 0, first_blank = 0;
  for (std::size_t begin = 0; begin < text->size();) {
    const std::size_t end = std::min(text->find('\n', begin), text->size());
    std::string_view line(text->data() + begin, end - begin);
    begin = end + 1;
    ++number;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ' || line.back() == '\t')) line.remove_suffix(1);
    while (!line.empty() && (line.front() == ' ' || line.front() == '\t')) line.remove_prefix(1);
    if (line.empty() && first_blank == 0) first_blank = number;
    if (line.empty() || line.front() == '#') continue;
    if (first_blank > 0) {
      return Error{ErrorCode::kConfig, "an empty line; expected the angle of a frame on every line",
                   fmt::format("{}:{}", path.string(), first_blank)};
    }
    const auto value = parse_finite(line);
    if (!value || !std::isfinite(*value)) {
      return Error{ErrorCode::kConfig, fmt::format("expected an angle in degrees, got '{}'", line),
                   fmt::format("{}:{}", path.string(), number)};
    }
    degrees.push_back(*value);
  }
  if (degrees.empty()) return Error{ErrorCode::kConfig, "holds no angle", path.string()};
  return degrees;
}

}  // namespace scanknit
