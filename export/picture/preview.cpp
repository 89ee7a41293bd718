#include "export/picture/preview.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <span>

#include "core/files/atomic_file.h"
#include "core/files/located.h"
#include "core/picture/png_codec.h"
#include "export/picture/rasteriser.h"
#include "export/picture/view_choice.h"

namespace scanknit {
namespace {

void copy_into(const ColourImage& part, int left, int top, ColourImage& whole) {
  for (int y = 0; y < part.height(); ++y) {
    const auto row = part.row(y);
    std::copy(row.begin(), row.end(), whole.row(top + y).begin() + left);
  }
}

/// The first `count` views, in rows of two.
ColourImage render_views(const Mesh& mesh, UpAxis world_up, const std::optional<Pose>& T_world_scanner, int count,
                         int width, int height, std::span<const Rgb8> colours = {}) {
  ColourImage picture(width, height, kBackground);
  if (mesh.empty()) return picture;
  std::array<View, 4> views = choose_views(mesh, world_up);
  std::array<Framing, 4> frames;
  frames.fill(framing(mesh));
  if (T_world_scanner) {
    views[0] = views[3] = scanner_view(*T_world_scanner, world_up);
    views[3].in_colour = false;
    frames[0] = frames[3] = framing_seen_from(mesh, *T_world_scanner);
  }
  for (View& view : views) view.colours = colours;
  const int part_width = width / 2, part_height = height / (count / 2);
  std::array<ColourImage, 4> parts;
  const auto render = [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    parts[k] = render_view(mesh, frames[k], views[k], part_width, part_height);
  };
  // A view belongs to one thread: the same picture for every number of threads. It takes 16 bytes for each vertex.
  constexpr std::size_t kMostVerticesBeside = 4'000'000;
  if (mesh.positions_m.size() <= kMostVerticesBeside) {
    tbb::parallel_for(0, count, render);
  } else {
    for (int i = 0; i < count; ++i) render(i);
  }
  for (int i = 0; i < count; ++i) {
    copy_into(parts[static_cast<std::size_t>(i)], (i % 2) * part_width, (i / 2) * part_height, picture);
  }
  return picture;
}

}  // namespace

ColourImage render_preview(const Mesh& mesh, UpAxis world_up, const std::optional<Pose>& T_world_scanner, int width,
                           int height) {
  return render_views(mesh, world_up, T_world_scanner, 4, width, height);
}

ColourImage render_two_views(const Mesh& mesh, UpAxis world_up, const std::optional<Pose>& T_world_scanner,
                             std::span<const Rgb8> colours) {
  constexpr int kWidth = 1280, kHeight = 480;
  return render_views(mesh, world_up, T_world_scanner, 2, kWidth, kHeight, colours);
}

Result<void> write_png(const ColourImage& image, const std::filesystem::path& path) {
  auto bytes = encode_png(image, PngEffort::kFast);
  if (!bytes) return located(bytes.error(), path);
  auto file = AtomicFile::create(path);
  if (!file) return file.error();
  if (auto written = file->write(std::as_bytes(std::span(*bytes))); !written) return written;
  return file->commit();
}

}  // namespace scanknit
