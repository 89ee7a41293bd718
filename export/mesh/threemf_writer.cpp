#include <fmt/format.h>
#include <zlib.h>

#include <array>
#include <cstring>
#include <limits>
#include <new>
#include <vector>

#include "core/version.h"
#include "export/mesh/byte_writer.h"
#include "export/mesh/mesh_writers.h"

namespace scanknit {
namespace {

constexpr std::string_view kContentTypes =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>
)";
constexpr std::string_view kRelations =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
)";

/// zlib's raw deflate, piece by piece into an AtomicFile, and the checksum of what went in.
class Deflater {
 public:
  explicit Deflater(AtomicFile& file) : file_(file), packed_(1u << 16) {
    constexpr int kRaw = -15, kMemory = 8;  // no zlib header: zip has its own
    is_open_ = deflateInit2(&stream_, Z_DEFAULT_COMPRESSION, Z_DEFLATED, kRaw, kMemory, Z_DEFAULT_STRATEGY) == Z_OK;
    if (!is_open_) throw std::bad_alloc();
  }
  ~Deflater() {
    if (is_open_) deflateEnd(&stream_);
  }
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;

  void add(std::string_view text) {
    block_ += text;
    if (block_.size() >= kBlockBytes) flush(Z_NO_FLUSH);
  }
  [[nodiscard]] Result<void> finish() {
    flush(Z_FINISH);
    return status_;
  }
  [[nodiscard]] std::uint32_t checksum() const { return static_cast<std::uint32_t>(checksum_); }
  [[nodiscard]] std::uint64_t plain_bytes() const { return plain_bytes_; }
  [[nodiscard]] std::uint64_t packed_bytes() const { return packed_bytes_; }

 private:
  static constexpr std::size_t kBlockBytes = 1u << 16;

  void flush(int mode) {
    if (!status_) return;
    auto* bytes = reinterpret_cast<Bytef*>(block_.data());
    checksum_ = crc32(checksum_, bytes, static_cast<uInt>(block_.size()));
    plain_bytes_ += block_.size();
    stream_.next_in = bytes;
    stream_.avail_in = static_cast<uInt>(block_.size());
    do {
      stream_.next_out = packed_.data();
      stream_.avail_out = static_cast<uInt>(packed_.size());
      deflate(&stream_, mode);  // cannot fail while there is room for its output
      const std::size_t made = packed_.size() - stream_.avail_out;
      packed_bytes_ += made;
      status_ = file_.write(std::as_bytes(std::span(packed_.data(), made)));
    } while (status_ && stream_.avail_out == 0);
    block_.clear();
  }

  AtomicFile& file_;
  std::vector<Bytef> packed_;
  z_stream stream_{};
  bool is_open_ = false;
  std::string block_;
  uLong checksum_ = crc32(0, nullptr, 0);
  std::uint64_t plain_bytes_ = 0, packed_bytes_ = 0;
  Result<void> status_;
};

struct Entry {
  std::string name;
  std::uint32_t checksum = 0;
  std::uint64_t packed_bytes = 0, plain_bytes = 0, offset = 0;
};

// PKWARE's APPNOTE.TXT, 4.3.7, 4.3.9, 4.3.12, 4.3.16. Sizes follow each file's data (bit 3), so that it is written in
// one go. 1 January 1980: the same mesh gives the same bytes.
constexpr std::uint16_t kVersionNeeded = 20, kSizesFollow = 1u << 3, kDeflated = 8, kMidnight = 0, kFirstDay = 0x21;

class ZipWriter {
 public:
  explicit ZipWriter(AtomicFile& file) : file_(file) {}

  /// `fill(Deflater&)` adds what the file holds.
  template <typename Fill>
  [[nodiscard]] Result<void> add(const std::string& name, Fill&& fill) {
    Entry entry{name, 0, 0, 0, offset_};
    std::string head = word(0x04034b50);
    head += half(kVersionNeeded) + half(kSizesFollow) + half(kDeflated) + half(kMidnight) + half(kFirstDay);
    head += word(0) + word(0) + word(0) + half(static_cast<std::uint16_t>(name.size())) + half(0) + name;
    if (auto written = put(head); !written) return written;
    Deflater deflater(file_);
    fill(deflater);
    if (auto written = deflater.finish(); !written) return written;
    entry.checksum = deflater.checksum();
    entry.packed_bytes = deflater.packed_bytes();
    entry.plain_bytes = deflater.plain_bytes();
    offset_ += entry.packed_bytes;
    entries_.push_back(entry);
    return put(word(0x08074b50) + sizes_of(entry));
  }

  [[nodiscard]] Result<void> finish() {
    const std::uint64_t begin = offset_;
    for (const Entry& entry : entries_) {
      std::string head = word(0x02014b50) + half(kVersionNeeded) + half(kVersionNeeded) + half(kSizesFollow);
      head += half(kDeflated) + half(kMidnight) + half(kFirstDay) + sizes_of(entry);
      head += half(static_cast<std::uint16_t>(entry.name.size())) + half(0) + half(0) + half(0) + half(0) + word(0);
      head += word(entry.offset) + entry.name;
      if (auto written = put(head); !written) return written;
    }
    const auto count = static_cast<std::uint16_t>(entries_.size());
    std::string end = word(0x06054b50) + half(0) + half(0) + half(count) + half(count);
    end += word(offset_ - begin) + word(begin) + half(0);
    return put(end);
  }

 private:
  static std::string sizes_of(const Entry& entry) {
    return word(entry.checksum) + word(entry.packed_bytes) + word(entry.plain_bytes);
  }
  static std::string half(std::uint16_t value) {
    return {static_cast<char>(value & 0xFF), static_cast<char>(value >> 8)};
  }
  static std::string word(std::uint64_t value) {
    return half(static_cast<std::uint16_t>(value & 0xFFFF)) + half(static_cast<std::uint16_t>(value >> 16 & 0xFFFF));
  }
  Result<void> put(const std::string& bytes) {
    offset_ += bytes.size();
    return file_.write(bytes);
  }

  AtomicFile& file_;
  std::uint64_t offset_ = 0;
  std::vector<Entry> entries_;
};

/// The colours of a mesh, each once: its place in the group, by 0xRRGGBB.
class Palette {
 public:
  explicit Palette(const std::vector<Rgb8>& colours) : place_(colours.empty() ? 0 : 1u << 24, kNone) {
    for (const Rgb8 colour : colours) {
      std::uint32_t& place = place_[code(colour)];
      if (place != kNone) continue;
      place = static_cast<std::uint32_t>(colours_.size());
      colours_.push_back(colour);
    }
  }
  [[nodiscard]] const std::vector<Rgb8>& colours() const { return colours_; }
  [[nodiscard]] std::uint32_t place_of(Rgb8 colour) const { return place_[code(colour)]; }

 private:
  static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  static std::size_t code(Rgb8 c) {
    return static_cast<std::size_t>(c.r) << 16 | static_cast<std::size_t>(c.g) << 8 | c.b;
  }
  std::vector<std::uint32_t> place_;
  std::vector<Rgb8> colours_;
};

void put_model(const Mesh& mesh, const Placement& placement, Deflater& out) {
  const bool has_colours = !mesh.colours.empty();
  out.add(R"(<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xml:lang="en" xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02" xmlns:m="http://schemas.microsoft.com/3dmanufacturing/material/2015/02">
)");
  out.add(fmt::format("<metadata name=\"Application\">ScanKnit {}</metadata>\n<resources>\n", kVersion));
  const Palette palette(mesh.colours);
  if (has_colours) {
    out.add("<m:colorgroup id=\"1\">\n");
    for (const Rgb8 c : palette.colours()) {
      out.add(fmt::format("<m:color color=\"#{:02X}{:02X}{:02X}\"/>\n", c.r, c.g, c.b));
    }
    out.add("</m:colorgroup>\n");
  }
  out.add(has_colours ? "<object id=\"2\" type=\"model\" pid=\"1\" pindex=\"0\"><mesh>\n<vertices>\n"
                      : "<object id=\"2\" type=\"model\"><mesh>\n<vertices>\n");
  for (const Eigen::Vector3f& position : mesh.positions_m) {
    const Eigen::Vector3f p = placement.position(position);
    out.add(fmt::format("<vertex x=\"{}\" y=\"{}\" z=\"{}\"/>\n", p.x(), p.y(), p.z()));
  }
  out.add("</vertices>\n<triangles>\n");
  for (const Triangle& t : mesh.triangles) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;  // which the format forbids
    out.add(fmt::format("<triangle v1=\"{}\" v2=\"{}\" v3=\"{}\"", t[0], t[1], t[2]));
    if (has_colours) {
      const auto colour = [&](std::size_t i) { return palette.place_of(mesh.colours[t[i]]); };
      out.add(fmt::format(" pid=\"1\" p1=\"{}\" p2=\"{}\" p3=\"{}\"", colour(0), colour(1), colour(2)));
    }
    out.add("/>\n");
  }
  out.add("</triangles>\n</mesh></object>\n</resources>\n<build><item objectid=\"2\"/></build>\n</model>\n");
}

}  // namespace

Result<void> write_3mf(const Mesh& mesh, const Placement& placement, AtomicFile& file, std::size_t max_triangles) {
  if (mesh.triangles.size() > max_triangles) {
    return Error{ErrorCode::kOutput,
                 fmt::format("{} triangles are more than a 3MF file of ours may have ({}): few slicers would open it; "
                             "write STL or PLY, or take a larger voxel size",
                             mesh.triangles.size(), max_triangles)};
  }
  try {
    ZipWriter zip(file);
    const auto text = [](std::string_view words) { return [words](Deflater& out) { out.add(words); }; };
    if (auto written = zip.add("[Content_Types].xml", text(kContentTypes)); !written) return written;
    if (auto written = zip.add("_rels/.rels", text(kRelations)); !written) return written;
    const auto model = [&](Deflater& out) { put_model(mesh, placement, out); };
    if (auto written = zip.add("3D/3dmodel.model", model); !written) return written;
    return zip.finish();
  } catch (const std::bad_alloc&) {
    return Error{ErrorCode::kBudget, "out of memory while the 3MF was built; larger voxels, or a file .ply, need less"};
  } catch (const std::exception& problem) {
    return Error{ErrorCode::kOutput, std::string("the 3MF could not be built: ") + problem.what()};
  }
}

}  // namespace scanknit
