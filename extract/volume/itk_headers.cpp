#include "extract/volume/itk_headers.h"

#include <NrrdIO.h>
#include <metaImage.h>
#include <nifti1_io.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "extract/volume/header_text.h"

namespace scanknit {
namespace {

using Path = std::filesystem::path;

Result<void> set_type(FileLayout& layout, std::optional<SampleType> type, const char* format, const Path& path) {
  if (!type) return bad_volume(path, "the samples' type: expected one integer or float of 8 to 64 bits");
  layout.type = *type;
  layout.header.format = format;
  set_sample_type(layout.header, *type);
  return {};
}

// ---------------------------------------------------------------------------------------------------------------- NRRD

constexpr std::size_t kLongNrrdLine = 512;

// The first kLongNrrdLine bytes of a line that ends as NrrdIO has it: with \n, \r\n or \r. Empty at the file's end.
std::string next_nrrd_line(std::istream& file) {
  constexpr int kEnd = std::istream::traits_type::eof();
  std::string line;
  int c = file.get();
  for (; c != '\n' && c != '\r' && c != kEnd; c = file.get()) {
    if (line.size() < kLongNrrdLine) line += static_cast<char>(c);
  }
  if (c == '\r' && file.peek() == '\n') file.get();
  return line;
}

// NrrdIO quotes a field that it refuses in an error of 1024 bytes, whatever the field's length, and lets a list of data
// files run to the file's end: it gets neither. Comments and keys ("key:=value") may be long.
Result<void> check_nrrd_text(const Path& path) {
  std::ifstream file(path, std::ios::binary);
  for (std::string text = next_nrrd_line(file); !text.empty(); text = next_nrrd_line(file)) {
    const std::string_view line = text;
    const bool is_field = !line.starts_with('#') && line.find(":=") >= line.find(": ");
    if (is_field && line.size() == kLongNrrdLine) return bad_volume(path, "not NRRD: a field has 512 bytes or more");
    const std::size_t colon = std::min(line.find(':'), line.size() - 1);
    const std::string name = lower_case(trimmed(line.substr(0, colon)));
    const bool is_list = trimmed(line.substr(colon + 1)).starts_with("LIST") || line.find('%') < line.size();
    if (is_list && (name == "data file" || name == "datafile")) {
      return bad_volume(path, "samples in several files; join them into one first");
    }
  }
  return {};
}

struct NrrdFile {
  Nrrd* nrrd = nrrdNew();
  NrrdIoState* io = nrrdIoStateNew();

  NrrdFile() = default;
  NrrdFile(const NrrdFile&) = delete;
  NrrdFile& operator=(const NrrdFile&) = delete;
  ~NrrdFile() {
    if (io->dataFile != nullptr) std::fclose(io->dataFile);
    nrrdIoStateNix(io);
    nrrdNuke(nrrd);
  }

  Result<void> load(const Path& path) {
    nrrdIoStateSet(io, nrrdIoStateSkipData, 1);
    nrrdIoStateSet(io, nrrdIoStateKeepNrrdDataFileOpen, 1);  // it then stands at the first sample
    if (nrrdLoad(nrrd, path.c_str(), io) == 0) return {};
    io->dataFile = nullptr;  // closed already
    const std::unique_ptr<char, decltype(&std::free)> trace(biffGetDone(NRRD), &std::free);
    std::string_view cause = trace ? trace.get() : "";
    while (cause.ends_with('\n')) cause.remove_suffix(1);
    cause.remove_prefix(cause.rfind('\n') + 1);  // the last line is the innermost call
    return bad_volume(path, "not NRRD, or truncated: " + std::string(cause));
  }
};

std::optional<SampleType> nrrd_type(int type) {
  constexpr std::array kTypes = {SampleType::kInt8,  SampleType::kUint8,  SampleType::kInt16, SampleType::kUint16,
                                 SampleType::kInt32, SampleType::kUint32, SampleType::kInt64, SampleType::kUint64,
                                 SampleType::kFloat, SampleType::kDouble};
  if (type < nrrdTypeChar || type > nrrdTypeDouble) return std::nullopt;
  return kTypes[static_cast<std::size_t>(type - nrrdTypeChar)];
}

using SpatialAxes = std::array<unsigned, 3>;

Result<SpatialAxes> spatial_axes(const Nrrd& nrrd, const Path& path) {
  std::vector<unsigned> found;
  for (unsigned n = 0; n < nrrd.dim; ++n) {
    if (nrrd.dim <= 3 || nrrd.axis[n].size > 1) found.push_back(n);
  }
  if (found.size() < 3) return bad_volume(path, "expected at least 2 samples along each of three axes");
  for (const unsigned n : found) {
    const int kind = nrrd.axis[n].kind;
    const bool is_spatial = kind == nrrdKindUnknown || kind == nrrdKindDomain || kind == nrrdKindSpace;
    if (is_spatial && (n < 3 || found.size() == 3)) continue;
    const std::string name = kind == nrrdKindUnknown ? "" : std::string(" (") + airEnumStr(nrrdKind, kind) + ")";
    return bad_volume(path, "axis " + std::to_string(n) + name + " has " + std::to_string(nrrd.axis[n].size) +
                                " entries; expected three axes in space and one number per sample; save one "
                                "component or time as a volume of its own");
  }
  return SpatialAxes{found[0], found[1], found[2]};
}

Result<void> set_nrrd_geometry(const Nrrd& nrrd, SpatialAxes axes, VolumeHeader& header, const Path& path) {
  Eigen::Affine3d& T = header.T_file_index;
  const bool has_directions =
      std::ranges::any_of(axes, [&](unsigned n) { return AIR_EXISTS(nrrd.axis[n].spaceDirection[0]); });
  if (has_directions && nrrd.spaceDim != 3) return bad_volume(path, "directions not of a space of 3 dimensions");
  bool has_spacing = true;
  for (int n = 0; n < 3; ++n) {
    const NrrdAxisInfo& axis = nrrd.axis[axes[static_cast<std::size_t>(n)]];
    if (has_directions) {
      T.linear().col(n) = Eigen::Vector3d(axis.spaceDirection);  // "none" is NaN: checked_bytes refuses it
    } else if (AIR_EXISTS(axis.spacing)) {
      T.linear()(n, n) = axis.spacing;
    } else {
      has_spacing = false;
    }
  }
  if (!has_directions && !has_spacing) {
    header.warnings.emplace_back("the header does not give all spacings: 1 assumed");
  }
  std::array<double, NRRD_DIM_MAX> origin{};
  if (nrrd.spaceDim == 3 && AIR_EXISTS(nrrd.spaceOrigin[0])) {
    T.translation() = Eigen::Vector3d(nrrd.spaceOrigin);
  } else if (nrrdOriginCalculate(&nrrd, axes.data(), 3, nrrdCenterCell, origin.data()) == nrrdOriginStatusOkay) {
    T.translation() = Eigen::Vector3d(origin.data());
  }
  return {};
}

// NRRD leaves units to the writer.
std::optional<double> metres_of(std::string_view unit) {
  if (unit == "m" || unit == "meter" || unit == "metre") return 1;
  if (unit == "cm") return 1e-2;
  if (unit == "mm" || unit == "millimeter" || unit == "millimetre") return 1e-3;
  if (unit == "um" || unit == "\u00b5m" || unit == "\u03bcm" || unit == "micron") return 1e-6;
  if (unit == "nm") return 1e-9;
  if (unit == "in") return 0.0254;
  return std::nullopt;
}

void set_nrrd_unit(const Nrrd& nrrd, const SpatialAxes& axes, VolumeHeader& header) {
  std::array<std::string, 3> units;
  for (std::size_t n = 0; n < 3; ++n) {
    const char* unit = nrrd.spaceDim == 3 ? nrrd.spaceUnits[n] : nrrd.axis[axes[n]].units;
    if (unit != nullptr) units[n] = unit;
  }
  if (units == std::array<std::string, 3>{}) return;
  const auto metres = metres_of(units[0]);
  if (metres && units[1] == units[0] && units[2] == units[0]) {
    header.metres_per_unit = *metres;
  } else {
    header.warnings.push_back("units '" + units[0] + "', '" + units[1] + "', '" + units[2] +
                              "' are not one known unit of length: mm assumed");
  }
}

Result<void> set_nrrd_data(const NrrdIoState& io, FileLayout& layout, const Path& path) {
  if (io.dataFile == nullptr) return bad_volume(path, "no file of samples");
  if (io.dataFNArr->len == 1) layout.data_file = io.dataFN[0];
  const long offset = std::ftell(io.dataFile);
  if (offset < 0) return bad_volume(path, "the samples cannot be reached");
  layout.data_offset = static_cast<std::uint64_t>(offset);
  if (io.endian == airEndianBig) layout.order = ByteOrder::kBig;
  if (io.encoding == nrrdEncodingRaw) return {};
  if (io.encoding == nrrdEncodingAscii) {
    layout.encoding = Encoding::kText;
    return {};
  }
  if (io.encoding != nrrdEncodingGzip) {
    return bad_volume(path, std::string("encoding ") + io.encoding->name + ", expected raw, gzip or ascii");
  }
  if (io.byteSkip < 0) return bad_volume(path, "'byte skip: -1' before compressed samples; save them without");
  layout.encoding = Encoding::kCompressed;
  layout.decoded_offset = static_cast<std::uint64_t>(io.byteSkip);
  return {};
}

// ----------------------------------------------------------------------------------------------------------- MetaImage

// MetaIO reports on std::cerr; a library never prints.
class QuietErrors {
 public:
  QuietErrors() : kept_(std::cerr.rdbuf(nullptr)) {}
  ~QuietErrors() { std::cerr.rdbuf(kept_); }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  std::streambuf* kept_;
};

// A line of a MetaImage header as MetaIO splits it; nothing where MetaIO would leave its arrays. It trusts its input:
// texts go into 255 characters, numbers into 10 dimensions, the value of a line without one is sought in the lines that
// follow, and what cannot be printed is stripped past the beginning of a value.
struct MetaLine {
  std::string_view name, value;
};

std::optional<MetaLine> safe_meta_line(std::string_view line) {
  constexpr std::size_t kTextCapacity = 255, kMostDimensions = 10;
  line = trimmed(line);
  if (!std::ranges::all_of(line, [](char c) { return (c >= ' ' && c <= '~') || c == '\t'; })) return std::nullopt;
  if (line.empty()) return MetaLine{};
  const std::size_t separator = line.find_first_of("=:");
  if (separator == std::string_view::npos) return std::nullopt;
  const std::size_t value = line.find_first_not_of("=: \t", separator);
  if (separator == 0 || value == std::string_view::npos) return std::nullopt;
  const MetaLine split{trimmed(line.substr(0, separator)), line.substr(value)};
  const bool is_matrix = split.name == "TransformMatrix" || split.name == "Rotation" || split.name == "Orientation";
  if (!is_matrix && line.size() >= kTextCapacity) return std::nullopt;
  if (split.name != "NDims") return split;
  const auto dimension = parse_number<std::size_t>(split.value);
  if (!dimension || *dimension < 1 || *dimension > kMostDimensions) return std::nullopt;
  return split;
}

struct MetaText {
  std::uint64_t length = 0;  // of the header
  bool has_spacing = false;
  bool has_unit = false;
};

// Nothing where MetaIO must not see the file.
std::optional<MetaText> check_meta_text(const Path& path) {
  constexpr int kMostLines = 10'000;
  std::ifstream file(path, std::ios::binary);
  MetaText text;
  std::array<char, 4096> buffer;
  for (int n = 0; n < kMostLines && file.getline(buffer.data(), buffer.size()); ++n) {
    text.length += static_cast<std::uint64_t>(file.gcount());
    const std::string_view line(buffer.data(), static_cast<std::size_t>(file.gcount()) - (file.eof() ? 0 : 1));
    const auto split = safe_meta_line(line);
    if (!split) return std::nullopt;
    text.has_spacing |= split->name == "ElementSpacing" || split->name == "ElementSize";
    text.has_unit |= split->name == "DistanceUnits";
    if (split->name == "ElementDataFile") return text;
  }
  return std::nullopt;
}

std::optional<SampleType> meta_type(MET_ValueEnumType type) {
  if (type < MET_CHAR || type > MET_DOUBLE) return std::nullopt;
  const bool is_signed = (type - MET_CHAR) % 2 == 0;  // up to MET_ULONG_LONG signed and unsigned take turns
  return sample_type_of(MET_ValueTypeSize[type], is_signed, type == MET_FLOAT || type == MET_DOUBLE);
}

Result<void> set_meta_sizes(const MetaImage& image, VolumeHeader& header, const Path& path) {
  if (image.NDims() < 3) return bad_volume(path, "NDims, expected 3, with at least 2 samples along each axis");
  for (int n = 3; n < image.NDims(); ++n) {
    if (image.DimSize(n) == 1) continue;
    return bad_volume(path, "dimension " + std::to_string(n + 1) + " has " + std::to_string(image.DimSize(n)) +
                                " entries; expected three axes in space; save one time as a volume of its own");
  }
  if (image.ElementNumberOfChannels() != 1) {
    return bad_volume(path, "ElementNumberOfChannels, expected 1 number per sample");
  }
  header.dims = {image.DimSize(0), image.DimSize(1), image.DimSize(2)};
  return {};
}

void set_meta_geometry(const MetaImage& image, const MetaText& text, VolumeHeader& header) {
  Eigen::Affine3d& T = header.T_file_index;
  for (int n = 0; n < 3; ++n) {
    // The matrix lists the direction of one axis after the other.
    for (int i = 0; i < 3; ++i) T.linear()(i, n) = image.TransformMatrix(n, i) * image.ElementSpacing(n);
    T.translation()[n] = image.Offset(n);
  }
  switch (image.DistanceUnits()) {
    case MET_DISTANCE_UNITS_UM: header.metres_per_unit = 1e-6; break;
    case MET_DISTANCE_UNITS_CM: header.metres_per_unit = 1e-2; break;
    case MET_DISTANCE_UNITS_MM: break;
    case MET_DISTANCE_UNITS_UNKNOWN:
      if (text.has_unit) header.warnings.emplace_back("DistanceUnits is none of um, mm and cm: mm assumed");
  }
  if (!text.has_spacing) header.warnings.emplace_back("the header gives no spacing: 1 along each axis assumed");
}

Result<void> set_meta_data(const MetaImage& image, std::uint64_t header_end, FileLayout& layout, const Path& path) {
  const std::string file = image.ElementDataFileName();
  if (file.empty() || file.starts_with("LIST") || file.find('%') != std::string::npos) {
    return bad_volume(path, "ElementDataFile = '" + file + "', expected LOCAL or one file; join listed files first");
  }
  const bool is_local = file == "LOCAL" || file == "Local" || file == "local";
  if (!is_local) layout.data_file = file;
  if (image.BinaryDataByteOrderMSB()) layout.order = ByteOrder::kBig;
  if (image.CompressedData()) layout.encoding = Encoding::kCompressed;
  if (!image.BinaryData()) layout.encoding = Encoding::kText;
  const int skip = image.HeaderSize();
  if (skip < -1 || (skip == -1 && layout.encoding != Encoding::kRaw)) {
    return bad_volume(path, "HeaderSize = " + std::to_string(skip) + ", expected bytes before the samples");
  }
  layout.is_at_end = skip == -1;
  if (skip > 0) layout.data_offset = static_cast<std::uint64_t>(skip);  // counts from the start of the file
  if (skip == 0 && is_local) layout.data_offset = header_end;
  return {};
}

// --------------------------------------------------------------------------------------------------------------- NIfTI

std::optional<SampleType> nifti_type(int datatype) {
  switch (datatype) {
    case DT_UINT8: return SampleType::kUint8;
    case DT_INT8: return SampleType::kInt8;
    case DT_INT16: return SampleType::kInt16;
    case DT_UINT16: return SampleType::kUint16;
    case DT_INT32: return SampleType::kInt32;
    case DT_UINT32: return SampleType::kUint32;
    case DT_INT64: return SampleType::kInt64;
    case DT_UINT64: return SampleType::kUint64;
    case DT_FLOAT32: return SampleType::kFloat;
    case DT_FLOAT64: return SampleType::kDouble;
    default: return std::nullopt;
  }
}

struct NiftiHeader {
  nifti_1_header fields;  // in this machine's byte order
  bool is_swapped;
};

Result<NiftiHeader> nifti_fields(std::span<const std::byte> bytes, const Path& path) {
  static_assert(sizeof(nifti_1_header) == kNiftiHeaderBytes);
  if (bytes.size() < kNiftiHeaderBytes) return bad_volume(path, "truncated: a NIfTI header has 348 bytes");
  NiftiHeader header{};
  std::memcpy(&header.fields, bytes.data(), kNiftiHeaderBytes);
  nifti_1_header& fields = header.fields;
  header.is_swapped = fields.sizeof_hdr != static_cast<int>(kNiftiHeaderBytes) && fields.sizeof_hdr != 540;
  if (header.is_swapped) swap_nifti_header(&fields, 1);
  if (fields.sizeof_hdr == 540) return bad_volume(path, "NIfTI-2; convert it to NIfTI-1 or NRRD");
  if (fields.sizeof_hdr != static_cast<int>(kNiftiHeaderBytes)) {
    return bad_volume(path, "not NIfTI: the first number is neither 348 nor 540");
  }
  if (NIFTI_VERSION(fields) != 1) {
    return bad_volume(path, "Analyze 7.5, which has no orientation; convert it to NIfTI-1");
  }
  if (fields.dim[0] < 3 || fields.dim[0] > 7) {
    return bad_volume(path, "dim[0] = " + std::to_string(fields.dim[0]) + ", expected 3 dimensions");
  }
  for (int n = 4; n <= fields.dim[0]; ++n) {
    if (fields.dim[n] == 1) continue;
    constexpr std::array<const char*, 4> kNames = {"time", "vector component", "dimension 6", "dimension 7"};
    return bad_volume(path, "dim[" + std::to_string(n) + "] (" + kNames[static_cast<std::size_t>(n) - 4] +
                                ") = " + std::to_string(fields.dim[n]) +
                                ", expected one number per sample; save one of them as a volume of its own");
  }
  return header;
}

// Where the samples begin. 0 is taken as "right after the header", which in a single file (magic "n+1") are its 348
// bytes and the 4 that say whether extensions follow (nifti1.h).
Result<std::uint64_t> nifti_offset(const nifti_1_header& fields, const Path& path) {
  constexpr std::uint64_t kLeastInSingleFile = kNiftiHeaderBytes + 4;
  constexpr float kMost = 1e18f;  // more than any file holds, and well within 64 bits
  const float offset = fields.vox_offset;
  const std::uint64_t least = NIFTI_ONEFILE(fields) ? kLeastInSingleFile : 0;
  if (offset == 0) return least;
  const bool is_whole = offset > 0 && offset <= kMost && std::trunc(offset) == offset;  // not NaN
  if (!is_whole || static_cast<std::uint64_t>(offset) < least) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.9g", static_cast<double>(offset));
    return bad_volume(path, std::string("vox_offset = ") + text.data() + ", expected whole bytes, " +
                                std::to_string(least) + " or more (or 0)");
  }
  return static_cast<std::uint64_t>(offset);
}

Eigen::Affine3d affine(const mat44& matrix) {
  Eigen::Affine3d T = Eigen::Affine3d::Identity();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) T(row, column) = static_cast<double>(matrix.m[row][column]);
  }
  return T;
}

}  // namespace

Result<FileLayout> read_nrrd_header(const Path& path) {
  if (auto checked = check_nrrd_text(path); !checked) return checked.error();
  NrrdFile file;
  if (auto loaded = file.load(path); !loaded) return loaded.error();
  const Nrrd& nrrd = *file.nrrd;
  FileLayout layout;
  if (auto typed = set_type(layout, nrrd_type(nrrd.type), "NRRD", path); !typed) return typed.error();
  const auto axes = spatial_axes(nrrd, path);
  if (!axes) return axes.error();
  for (std::size_t n = 0; n < 3; ++n) {
    constexpr std::size_t kMost = std::numeric_limits<int>::max();
    if (nrrd.axis[(*axes)[n]].size > kMost) return bad_volume(path, "an axis has 2^31 samples or more");
    layout.header.dims[static_cast<int>(n)] = static_cast<int>(nrrd.axis[(*axes)[n]].size);
  }
  if (auto set = set_nrrd_geometry(nrrd, *axes, layout.header, path); !set) return set.error();
  set_nrrd_unit(nrrd, *axes, layout.header);
  if (auto set = set_nrrd_data(*file.io, layout, path); !set) return set.error();
  return layout;
}

Result<FileLayout> read_meta_header(const Path& path) {
  const auto text = check_meta_text(path);
  if (!text) {
    return bad_volume(path,
                      "truncated or not MetaImage: expected lines 'Name = Value' of printable characters, NDims of 1 "
                      "to 10, and ElementDataFile last");
  }
  std::ifstream file(path, std::ios::binary);
  MetaImage image;
  const QuietErrors quiet;
  if (!image.ReadStream(0, &file, false)) return bad_volume(path, "not MetaImage: MetaIO cannot read its header");
  FileLayout layout;
  if (auto typed = set_type(layout, meta_type(image.ElementType()), "MetaImage", path); !typed) return typed.error();
  if (auto set = set_meta_sizes(image, layout.header, path); !set) return set.error();
  set_meta_geometry(image, *text, layout.header);
  if (auto set = set_meta_data(image, text->length, layout, path); !set) return set.error();
  return layout;
}

Result<FileLayout> read_nifti_header(std::span<const std::byte> bytes, const Path& path) {
  auto header = nifti_fields(bytes, path);
  if (!header) return header.error();
  FileLayout layout;
  // What niftilib refuses, it also prints; so it meets only types that we take.
  const auto type = nifti_type(header->fields.datatype);
  if (!type) return bad_volume(path, "datatype " + std::to_string(header->fields.datatype) + " is not one real number");
  if (auto typed = set_type(layout, type, "NIfTI", path); !typed) return typed.error();
  for (int n = 0; n < 3; ++n) {
    layout.header.dims[n] = header->fields.dim[n + 1];
    if (layout.header.dims[n] < 2) return bad_volume(path, "fewer than 2 samples along an axis; expected at least 2");
  }
  const auto offset = nifti_offset(header->fields, path);
  if (!offset) return offset.error();
  layout.data_offset = *offset;
  header->fields.vox_offset = 0;  // niftilib's own reading of it is not used
  const bool is_little = (std::endian::native == std::endian::little) != header->is_swapped;
  layout.order = is_little ? ByteOrder::kLittle : ByteOrder::kBig;
  nifti_set_debug_level(0);
  const std::unique_ptr<nifti_image, decltype(&nifti_image_free)> image(nifti_convert_nhdr2nim(header->fields, nullptr),
                                                                        &nifti_image_free);
  if (!image) return bad_volume(path, "not NIfTI: niftilib cannot read its header");
  if (image->sform_code > 0) {
    layout.header.T_file_index = affine(image->sto_xyz);
  } else {
    layout.header.T_file_index = affine(image->qto_xyz);
    if (image->qform_code <= 0) {
      layout.header.warnings.emplace_back("the header gives neither sform nor qform: spacing only, origin 0");
    }
  }
  layout.header.metres_per_unit = image->xyz_units == NIFTI_UNITS_METER    ? 1
                                  : image->xyz_units == NIFTI_UNITS_MICRON ? 1e-6
                                                                           : 1e-3;
  if (!std::isfinite(header->fields.scl_slope) || !std::isfinite(header->fields.scl_inter)) {
    layout.header.warnings.emplace_back("scl_slope or scl_inter is not finite: samples are not scaled");
  } else if (image->scl_slope != 0) {  // nifti1.h: 0 is no scaling
    layout.rescale = {static_cast<double>(image->scl_slope), static_cast<double>(image->scl_inter)};
  }
  return layout;
}

}  // namespace scanknit
