#include <zlib.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <optional>
#include <string>
#include <utility>

#include "extract/volume/header_text.h"
#include "extract/volume/itk_headers.h"
#include "extract/volume/readers.h"
#include "extract/volume/volume_files.h"

namespace scanknit {
namespace {

using Path = std::filesystem::path;
using Opened = Result<std::unique_ptr<SliceReader>>;

constexpr const char* kUnknown =
    "unknown format; expected NRRD, MetaImage, NIfTI-1, a folder of DICOM, PNG or TIFF slices, or raw samples with "
    "their dims, type and spacing given";

// At most kNiftiHeaderBytes of the file; decompressed where it is gzip and `is_inflated`.
Result<std::vector<std::byte>> first_bytes(const Path& path, bool is_inflated) {
  std::vector<std::byte> bytes(kNiftiHeaderBytes);
  if (is_inflated) {
    gzFile file = gzopen(path.c_str(), "rb");
    if (file == nullptr) return bad_volume(path, "cannot be opened");
    const int count = gzread(file, bytes.data(), static_cast<unsigned>(bytes.size()));
    gzclose(file);
    // What precedes a fault in the stream is lost; a header that small is truncated anyway.
    if (count < 0) return bad_volume(path, "truncated or corrupt gzip stream");
    bytes.resize(static_cast<std::size_t>(count));
    return bytes;
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) return bad_volume(path, "cannot be opened");
  file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(file.gcount()));
  return bytes;
}

bool starts_with(std::span<const std::byte> bytes, std::string_view magic, std::size_t offset = 0) {
  return bytes.size() >= offset + magic.size() &&
         std::ranges::equal(bytes.subspan(offset, magic.size()), magic, {}, {}, [](char c) { return std::byte(c); });
}

Opened open_layout(const Path& path, Result<FileLayout> layout, const VolumeOptions& options) {
  if (!layout) return layout.error();
  const Path data_path = layout->data_file.empty() ? path : path.parent_path() / layout->data_file;
  if (layout->encoding == Encoding::kRaw) {
    return open_raw_samples(data_path, std::move(*layout), options.memory_budget_bytes);
  }
  return open_encoded_samples(data_path, std::move(*layout), options.memory_budget_bytes);
}

Opened open_dicom(const Path& path, const VolumeOptions& options) {
  const auto files = load_volume_files();
  if (!files) return files.error();
  return (*files)->open_dicom_series(path, options);
}

// `path` without ".gz", in whatever case.
Path without_gz(const Path& path) {
  return lower_case(path.extension().string()) == ".gz" ? Path(path).replace_extension() : path;
}

// The other file of a pair: beside `path`, with this ending, in small letters or capitals, compressed or not.
std::optional<Path> partner_of(const Path& path, const std::string& ending) {
  std::string capitals = ending;
  for (char& c : capitals) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  std::error_code code;
  for (const std::string& name : {ending, ending + ".gz", capitals, capitals + ".GZ", capitals + ".gz"}) {
    Path partner = without_gz(path).replace_extension(name);
    if (std::filesystem::exists(partner, code)) return partner;
  }
  return std::nullopt;
}

// .nii and .hdr hold the header; .img is named instead of its .hdr.
Opened open_nifti(Path path, const VolumeOptions& options) {
  if (lower_case(without_gz(path).extension().string()) == ".img") {
    const auto header_path = partner_of(path, ".hdr");
    if (!header_path) return bad_volume(path, "its header, .hdr, is missing");
    path = *header_path;
  }
  auto bytes = first_bytes(path, true);
  if (!bytes) return bytes.error();
  const auto files = load_volume_files();
  if (!files) return files.error();
  auto layout = (*files)->read_nifti_header(*bytes, path);
  if (!layout) return layout.error();
  const bool is_pair = *(bytes->begin() + 345) == std::byte{'i'};
  const auto data_path = is_pair ? partner_of(path, ".img") : path;
  if (!data_path) return bad_volume(path, "its file of samples, .img, is missing");
  auto stored = first_bytes(*data_path, false);
  if (!stored) return stored.error();
  if (starts_with(*stored, "\x1f\x8b")) {
    layout->encoding = Encoding::kCompressed;
    layout->decoded_offset = std::exchange(layout->data_offset, 0);
    return open_encoded_samples(*data_path, std::move(*layout), options.memory_budget_bytes);
  }
  return open_raw_samples(*data_path, std::move(*layout), options.memory_budget_bytes);
}

Opened open_raw(const Path& path, const VolumeOptions& options) {
  const auto usage = [&](const char* message) { return Error{ErrorCode::kUsage, message, path.string()}; };
  if (!options.dims || !options.type || !options.spacing) {
    return usage("raw samples need their dims, type and spacing, all three");
  }
  if (!(options.spacing->minCoeff() > 0) || !options.spacing->allFinite()) return usage("spacing: expected > 0 mm");
  FileLayout layout;
  layout.header.dims = *options.dims;
  layout.header.T_file_index.linear() = options.spacing->asDiagonal();
  layout.header.format = "raw";
  set_sample_type(layout.header, *options.type);
  layout.type = *options.type;
  layout.order = options.byte_order;
  layout.data_offset = options.header_bytes;
  const auto bytes = checked_bytes(path, layout.header, layout.type);
  if (!bytes) return bytes.error();
  std::error_code code;
  const std::uint64_t file_bytes = std::filesystem::file_size(path, code);
  // A longer file means wrong dims or a header that was not mentioned: the samples would be sheared.
  if (!code && file_bytes > *bytes && file_bytes - *bytes > options.header_bytes) {
    return bad_volume(path, dims_text(layout.header.dims) + " samples of " + layout.header.sample_type + " after " +
                                std::to_string(options.header_bytes) + " header bytes need " +
                                std::to_string(*bytes + options.header_bytes) + " bytes; the file has " +
                                std::to_string(file_bytes) + "; check dims, type and header bytes");
  }
  return open_raw_samples(path, std::move(layout), options.memory_budget_bytes);
}

Opened open_images(const Path& folder, const VolumeOptions& options) {
  const auto files = load_volume_files();
  if (!files) return files.error();
  return (*files)->open_image_stack(folder, options);
}

bool has_other_image_name(const Path& path) {
  constexpr std::array kEndings = {".jpg", ".jpeg", ".jp2", ".bmp", ".gif", ".webp", ".pgm", ".ppm"};
  return std::ranges::find(kEndings, lower_case(path.extension().string())) != kEndings.end();
}

Opened open_folder(const Path& path, const VolumeOptions& options) {
  std::error_code code;
  std::string other_image;  // the first by name
  for (std::filesystem::directory_iterator entry(path, code), end; !code && entry != end; entry.increment(code)) {
    if (has_image_name(entry->path())) return open_images(path, options);
    const std::string name = entry->path().filename().string();
    if (has_other_image_name(name) && (other_image.empty() || name < other_image)) other_image = name;
  }
  if (code) return bad_volume(path, code.message());
  if (options.spacing && !other_image.empty()) {
    return bad_volume(path, "no PNG or TIFF slices in this folder, but " + other_image +
                                "; of images only PNG and TIFF are read: convert them");
  }
  return open_dicom(path, options);
}

bool is_nifti_name(const Path& path) {
  constexpr std::array kEndings = {".nii", ".hdr", ".img"};
  return std::ranges::find(kEndings, lower_case(without_gz(path).extension().string())) != kEndings.end();
}

Opened open_self_described(const Path& path, const VolumeOptions& options) {
  auto bytes = first_bytes(path, false);
  if (!bytes) return bytes.error();
  const std::string name = lower_case(path.filename().string());
  const bool is_nrrd = starts_with(*bytes, "NRRD000");
  if (is_nrrd || name.ends_with(".mhd") || name.ends_with(".mha")) {
    const auto files = load_volume_files();
    if (!files) return files.error();
    return open_layout(path, is_nrrd ? (*files)->read_nrrd_header(path) : (*files)->read_meta_header(path), options);
  }
  if (is_nifti_name(path)) return open_nifti(path, options);
  if (has_image_name(path)) {
    return bad_volume(path,
                      "a single image; name the folder of all slices, with at least 2 of them, each in a file of its "
                      "own (no TIFF of several pages)");
  }
  if (starts_with(*bytes, "DICM", 128) || name.ends_with(".dcm")) return open_dicom(path, options);
  if (name.ends_with(".nrrd") || name.ends_with(".nhdr")) return bad_volume(path, "not NRRD, or truncated");
  return bad_volume(path, kUnknown);
}

}  // namespace

bool has_image_name(const Path& path) {
  const std::string extension = lower_case(path.extension().string());
  return extension == ".png" || extension == ".tif" || extension == ".tiff";
}

Opened open_volume(const Path& path, const VolumeOptions& options) {
  std::error_code code;
  const auto status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) return bad_volume(path, "no such file or folder");
  if (std::filesystem::is_directory(status)) return open_folder(path, options);
  if (!std::filesystem::is_regular_file(status)) return bad_volume(path, "neither a file nor a folder");
  if (options.dims || options.type) return open_raw(path, options);
  if (options.spacing) {
    return Error{ErrorCode::kUsage, "spacing is for raw samples, with dims and type, and for folders of images",
                 path.string()};
  }
  return open_self_described(path, options);
}

Result<DenseVolume> read_volume(SliceReader& reader, std::size_t memory_budget_bytes) {
  DenseVolume volume{reader.header(), {}};
  const Eigen::Vector3i& dims = volume.header.dims;
  const auto bytes = checked_bytes(volume.header.format, volume.header, SampleType::kFloat);
  if (!bytes) return bytes.error();
  if (auto fits = check_budget({}, *bytes, memory_budget_bytes, "the volume of " + dims_text(dims) + " samples",
                               "read it slice by slice or raise the budget");
      !fits) {
    return fits.error();
  }
  volume.samples.resize(static_cast<std::size_t>(*bytes / sizeof(float)));
  const std::size_t slice = volume.samples.size() / static_cast<std::size_t>(dims.z());
  for (int k = 0; k < dims.z(); ++k) {
    const auto samples = std::span(volume.samples).subspan(static_cast<std::size_t>(k) * slice, slice);
    if (auto read = reader.read_slice(k, samples); !read) return read.error();
  }
  return volume;
}

}  // namespace scanknit
