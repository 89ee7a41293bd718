#include "acquire/range/range_files.h"

#include <new>
#include <utility>

#include "core/files/ascii_numbers.h"
#include "core/files/located.h"
#include "core/files/read_file.h"

namespace scanknit {
namespace {

/// ".ply" of "bun000.ply.gz".
std::string ending(const std::filesystem::path& path) {
  const std::filesystem::path inner = lower_case(path.extension().string()) == ".gz" ? path.stem() : path;
  return lower_case(inner.extension().string());
}

Result<RangeFile> parse(const std::string& kind, std::string_view bytes, const Limits& limits) {
  RangeFile file;
  if (kind == ".pcd") return parse_pcd_range(bytes, limits);
  if (kind == ".ptx") {
    auto scans = parse_ptx(bytes, limits);
    if (!scans) return scans.error();
    file.scans = *std::move(scans);
    return file;
  }
  if (!is_range_ply(bytes)) return file;
  auto scan = parse_range_ply(bytes, limits);
  if (!scan) return scan.error();
  file.scans.push_back(*std::move(scan));
  return file;
}

}  // namespace

bool is_range_path(const std::filesystem::path& path) {
  const std::string kind = ending(path);
  return kind == ".ply" || kind == ".pcd" || kind == ".ptx";
}

Result<RangeFile> read_range_file(const std::filesystem::path& path, const Limits& limits) {
  auto packed = read_text_file(path, limits.max_range_bytes);
  if (!packed) return packed.error();
  const auto bytes = unpack_gzip(*std::move(packed), limits.max_range_bytes);
  if (!bytes) return located(bytes.error(), path);
  try {
    auto file = parse(ending(path), *bytes, limits);
    if (!file) return located(file.error(), path);
    const std::string name = path.filename().string();
    for (std::size_t i = 0; i < file->scans.size(); ++i) {
      file->scans[i].name = file->scans.size() == 1 ? name : name + "#" + std::to_string(i + 1);
    }
    for (PointCloud& cloud : file->clouds) cloud.name = name;
    return file;
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "does not fit into memory", path.string()};
  }
}

}  // namespace scanknit
