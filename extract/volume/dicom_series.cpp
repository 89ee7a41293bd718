#include <gdcmImageReader.h>
#include <gdcmTrace.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <vector>

#include "core/check.h"
#include "core/files/read_file.h"
#include "core/limits.h"
#include "extract/volume/dicom_structure.h"
#include "extract/volume/file_layout.h"
#include "extract/volume/header_text.h"
#include "extract/volume/slice_files.h"

namespace scanknit {
namespace {

using Path = std::filesystem::path;

// One slice of 64 million pixels of 8 bytes fits.
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 30;

// What one file's header says.
struct Slice {
  Path path;
  std::string series_uid;
  int columns = 0, rows = 0;
  SampleType type = SampleType::kInt16;
  Eigen::Vector3d along_row, along_column;  // unit vectors: of increasing i, of increasing j
  Eigen::Vector3d origin;                   // of sample (0, 0), mm, patient coordinates
  double spacing_i_mm = 0, spacing_j_mm = 0;

  [[nodiscard]] Eigen::Vector3d normal() const { return along_row.cross(along_column).normalized(); }
  [[nodiscard]] double position_mm() const { return normal().dot(origin); }
};

// The backslash-separated text of an element; empty where it is missing.
std::string text_of(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  const gdcm::ByteValue* value = set.FindDataElement(tag) ? set.GetDataElement(tag).GetByteValue() : nullptr;
  if (value == nullptr) return {};
  std::string text(value->GetPointer(), value->GetLength());
  std::erase(text, '\0');
  return std::string(trimmed(text));
}

std::optional<std::vector<double>> numbers_of(const gdcm::DataSet& set, const gdcm::Tag& tag, std::size_t count) {
  return parse_numbers<double>(split_words(text_of(set, tag), "\\ "), count);
}

std::optional<SampleType> stored_type(const gdcm::PixelFormat& format) {
  if (format.GetSamplesPerPixel() != 1 || format.GetBitsAllocated() % 8 != 0) return std::nullopt;
  const auto scalar = format.GetScalarType();
  const bool is_floating_point = scalar == gdcm::PixelFormat::FLOAT32 || scalar == gdcm::PixelFormat::FLOAT64;
  return sample_type_of(format.GetBitsAllocated() / 8u, format.GetPixelRepresentation() == 1, is_floating_point);
}

Result<void> read_geometry(const gdcm::DataSet& set, Slice& slice) {
  const auto position = numbers_of(set, {0x0020, 0x0032}, 3);
  const auto orientation = numbers_of(set, {0x0020, 0x0037}, 6);
  const auto spacing = numbers_of(set, {0x0028, 0x0030}, 2);
  if (!position || !orientation || !spacing) {
    return bad_volume(slice.path, "no Image Position, Image Orientation or Pixel Spacing: not a slice in space");
  }
  slice.origin = Eigen::Map<const Eigen::Vector3d>(position->data());
  slice.along_row = Eigen::Map<const Eigen::Vector3d>(orientation->data());
  slice.along_column = Eigen::Map<const Eigen::Vector3d>(orientation->data() + 3);
  slice.spacing_j_mm = (*spacing)[0];  // Pixel Spacing: between rows first
  slice.spacing_i_mm = (*spacing)[1];
  const bool is_plane = std::abs(slice.normal().norm() - 1) < 1e-6 && slice.origin.allFinite();
  if (!is_plane || !(slice.spacing_i_mm > 0) || !(slice.spacing_j_mm > 0)) {
    return bad_volume(slice.path, "Image Orientation or Pixel Spacing is degenerate");
  }
  return {};
}

std::optional<int> count_of(const gdcm::DataSet& set, const gdcm::Tag& tag) {
  const gdcm::ByteValue* value = set.FindDataElement(tag) ? set.GetDataElement(tag).GetByteValue() : nullptr;
  if (value == nullptr || value->GetLength() != sizeof(std::uint16_t)) return std::nullopt;
  std::uint16_t count;
  std::memcpy(&count, value->GetPointer(), sizeof count);
  return count;
}

// Throws if the disk fails: GDCM takes what it did not get for an end, and asserts that there is none.
std::ifstream open_for_gdcm(const Path& path) {
  std::ifstream file(path, std::ios::binary);
  file.exceptions(std::ios::badbit);
  return file;
}

// GDCM asserts what is checked here.
Result<void> read_image_header(const gdcm::DataSet& set, Slice& slice) {
  const auto rows = count_of(set, {0x0028, 0x0010}), columns = count_of(set, {0x0028, 0x0011});
  const auto samples = count_of(set, {0x0028, 0x0002}), allocated = count_of(set, {0x0028, 0x0100});
  const auto stored = count_of(set, {0x0028, 0x0101}), high = count_of(set, {0x0028, 0x0102});
  const auto is_signed = count_of(set, {0x0028, 0x0103});
  if (!rows || !columns || !samples || !allocated || !stored || !high || !is_signed) {
    return bad_volume(slice.path, "a DICOM file without an image, or truncated");
  }
  const std::string frames = text_of(set, {0x0028, 0x0008});
  if (!frames.empty() && frames != "1") {
    return bad_volume(slice.path, "a multi-frame image; convert it to one file per slice, NRRD or NIfTI");
  }
  const std::int64_t pixels = std::int64_t{*rows} * std::int64_t{*columns};
  if (pixels < 1 || pixels > Limits{}.max_image_pixels) {
    return bad_volume(slice.path, "rows or columns out of range");
  }
  const auto type = sample_type_of(static_cast<std::size_t>(*allocated) / 8, *is_signed == 1, false);
  const bool is_sound =
      *allocated % 8 == 0 && *stored >= 1 && *stored <= *allocated && *high == *stored - 1 && *is_signed <= 1;
  const bool is_grey = *samples == 1 && text_of(set, {0x0028, 0x0004}).starts_with("MONOCHROME");
  if (!type || !is_sound || !is_grey) {
    return bad_volume(slice.path, "colour, or not one number of 8, 16, 32 or 64 bits per pixel");
  }
  slice.rows = *rows;
  slice.columns = *columns;
  slice.type = *type;
  return {};
}

// Everything but the pixels. Throws what GDCM throws.
Result<Slice> read_slice_header(const Path& path) {
  const auto bytes = read_file(path, kMaxFileBytes);
  if (!bytes) return bytes.error();
  if (!is_dicom_structure(*bytes)) return bad_volume(path, "not DICOM, deflated, or truncated");
  gdcm::Reader reader;
  std::ifstream file = open_for_gdcm(path);
  reader.SetStream(file);
  if (!reader.ReadUpToTag(gdcm::Tag(0x7fe0, 0x0010))) return bad_volume(path, "not DICOM, or truncated");
  const gdcm::DataSet& set = reader.GetFile().GetDataSet();
  Slice slice;
  slice.path = path;
  if (auto read = read_image_header(set, slice); !read) return read.error();
  slice.series_uid = text_of(set, {0x0020, 0x000e});
  if (auto read = read_geometry(set, slice); !read) return read.error();
  return slice;
}

// The samples of one slice. Throws what GDCM throws.
Result<void> read_slice_samples(const Slice& slice, std::vector<char>& buffer, std::span<float> samples) {
  if (auto still_sound = read_slice_header(slice.path); !still_sound) return still_sound.error();
  gdcm::ImageReader reader;
  std::ifstream file = open_for_gdcm(slice.path);
  reader.SetStream(file);
  if (!reader.Read()) return bad_volume(slice.path, "the image is truncated, corrupt or of an unknown encoding");
  const gdcm::Image& image = reader.GetImage();
  const auto type = stored_type(image.GetPixelFormat());
  if (type != slice.type || image.GetColumns() != static_cast<unsigned>(slice.columns) ||
      image.GetRows() != static_cast<unsigned>(slice.rows)) {
    return bad_volume(slice.path, "the image is not what its header says");
  }
  const std::size_t bytes = samples.size() * bytes_per_sample(slice.type);
  // GDCM copies as many bytes as the header promises, so the pixels must be there. A compressed image has no such
  // value.
  const gdcm::ByteValue* plain = image.GetDataElement().GetByteValue();
  if (image.GetBufferLength() != bytes || (plain != nullptr && plain->GetLength() < bytes)) {
    return bad_volume(slice.path, "truncated: fewer pixels than rows x columns");
  }
  buffer.resize(bytes);
  if (!image.GetBuffer(buffer.data())) return bad_volume(slice.path, "the pixels cannot be decoded");
  const Rescale rescale{image.GetSlope(), image.GetIntercept()};
  constexpr ByteOrder kHere = std::endian::native == std::endian::little ? ByteOrder::kLittle : ByteOrder::kBig;
  decode_samples(std::as_bytes(std::span(buffer)), slice.type, kHere, rescale, samples);
  return {};
}

// Runs `read`, which calls GDCM, quietly and without exceptions.
template <typename Read>
auto guarded(const Path& path, Read&& read) -> decltype(read()) {
  gdcm::Trace::DebugOff();
  gdcm::Trace::WarningOff();
  gdcm::Trace::ErrorOff();
  try {
    return read();
  } catch (const std::exception& fault) {  // bad_alloc too: GDCM believes the lengths that elements claim
    return bad_volume(path, std::string("not readable as DICOM: ") + fault.what());
  }
}

class DicomReader final : public SliceReader {
 public:
  DicomReader(VolumeHeader header, std::vector<Slice> slices)
      : header_(std::move(header)), slices_(std::move(slices)) {}

  [[nodiscard]] const VolumeHeader& header() const override { return header_; }
  [[nodiscard]] bool is_streamed() const override { return true; }
  [[nodiscard]] Result<void> read_slice(int k, std::span<float> samples) override {
    SCANKNIT_CHECK(k >= 0 && k < header_.dims.z());
    const Slice& slice = slices_[static_cast<std::size_t>(k)];
    return guarded(slice.path, [&] { return read_slice_samples(slice, buffer_, samples); });
  }

 private:
  VolumeHeader header_;
  std::vector<Slice> slices_;
  std::vector<char> buffer_;
};

// Scouts of another orientation or size may share a series' UID: they are a stack of their own.
std::string stack_key(const Slice& slice) {
  std::string key = slice.series_uid + '|' + std::to_string(slice.columns) + 'x' + std::to_string(slice.rows) + '|' +
                    std::string(sample_type_name(slice.type));
  const auto append = [&key](double value) { key += '|' + std::to_string(std::llround(value * 1e3)); };
  std::ranges::for_each(slice.along_row, append);
  std::ranges::for_each(slice.along_column, append);
  append(slice.spacing_i_mm);
  append(slice.spacing_j_mm);
  return key;
}

struct Stacks {
  std::map<std::string, std::vector<Slice>> by_key;
  std::size_t other_files = 0;
  std::optional<Error> first_fault;
};

Result<Stacks> read_folder(const Path& folder) {
  std::vector<Path> files;
  std::error_code code;
  for (std::filesystem::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    if (entry->is_regular_file(code)) files.push_back(entry->path());
  }
  if (code) return bad_volume(folder, code.message());
  std::ranges::sort(files);
  Stacks stacks;
  for (const Path& file : files) {
    auto slice = guarded(file, [&] { return read_slice_header(file); });
    if (slice) {
      stacks.by_key[stack_key(*slice)].push_back(std::move(*slice));
    } else {
      ++stacks.other_files;
      if (!stacks.first_fault) stacks.first_fault = slice.error();
    }
  }
  return stacks;
}

// Takes the wanted stack, or the largest, and tells of the others.
Result<std::vector<Slice>> choose_stack(const Path& folder, Stacks stacks, const std::string& wanted_key,
                                        std::vector<std::string>& warnings) {
  const auto by_size = [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); };
  auto chosen = wanted_key.empty() ? std::ranges::max_element(stacks.by_key, by_size) : stacks.by_key.find(wanted_key);
  if (chosen == stacks.by_key.end()) {
    const std::string why = stacks.first_fault ? "; for instance, " + stacks.first_fault->text() : "";
    return bad_volume(folder, "no PNG, TIFF or DICOM slices in this folder (other images are not read)" + why);
  }
  for (auto stack = stacks.by_key.begin(); stack != stacks.by_key.end(); ++stack) {
    if (stack == chosen) continue;
    const Slice& first = stack->second.front();
    warnings.push_back("left out: series " + first.series_uid + ", " + std::to_string(stack->second.size()) +
                       " slices of " + std::to_string(first.columns) + " x " + std::to_string(first.rows) +
                       ", such as " + first.path.filename().string() + "; name one of its files to take it");
  }
  if (stacks.other_files > 0) {
    warnings.push_back(std::to_string(stacks.other_files) + " files are no DICOM slices, such as " +
                       stacks.first_fault->text());
  }
  return std::move(chosen->second);
}

// `slices` sorted along the normal.
Result<void> check_steps(const std::vector<Slice>& slices, double mean_mm, std::vector<std::string>& warnings) {
  double least_mm = mean_mm, most_mm = mean_mm;
  for (std::size_t k = 1; k < slices.size(); ++k) {
    const double step_mm = slices[k].position_mm() - slices[k - 1].position_mm();
    if (!(step_mm > 1e-3 * mean_mm)) {
      return bad_volume(slices[k].path, "lies in the same plane as " + slices[k - 1].path.filename().string() +
                                            "; keep one slice for each place (a series over time has several)");
    }
    least_mm = std::min(least_mm, step_mm);
    most_mm = std::max(most_mm, step_mm);
  }
  if (most_mm - mean_mm > 0.01 * mean_mm || mean_mm - least_mm > 0.01 * mean_mm) {
    warnings.push_back("slices lie " + std::to_string(least_mm) + " to " + std::to_string(most_mm) +
                       " mm apart; the mean of " + std::to_string(mean_mm) + " mm is taken (is a slice missing?)");
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<SliceReader>> open_dicom_series(const Path& path, const VolumeOptions& options) {
  if (options.dims || options.type || options.spacing) {
    return Error{ErrorCode::kUsage, "dims, type and spacing are for raw samples and images; DICOM says its own",
                 path.string()};
  }
  std::error_code code;
  std::string wanted_key;
  Path folder = path;
  if (!std::filesystem::is_directory(path, code)) {
    const auto wanted = guarded(path, [&] { return read_slice_header(path); });
    if (!wanted) return wanted.error();
    wanted_key = stack_key(*wanted);
    folder = path.has_parent_path() ? path.parent_path() : Path(".");
  }
  auto stacks = read_folder(folder);
  if (!stacks) return stacks.error();
  VolumeHeader header;
  auto slices = choose_stack(folder, std::move(*stacks), wanted_key, header.warnings);
  if (!slices) return slices.error();
  if (slices->size() < 2) return bad_volume(path, "a single slice; a volume has at least 2 slices");
  std::ranges::stable_sort(*slices, {}, &Slice::position_mm);
  const Slice &first = slices->front(), &last = slices->back();
  const auto steps = static_cast<double>(slices->size() - 1);
  const double mean_mm = (last.position_mm() - first.position_mm()) / steps;
  if (auto uniform = check_steps(*slices, mean_mm, header.warnings); !uniform) return uniform.error();

  header.format = "DICOM";
  set_sample_type(header, first.type);
  header.dims = {first.columns, first.rows, static_cast<int>(slices->size())};
  header.T_file_index.linear().col(0) = first.along_row * first.spacing_i_mm;
  header.T_file_index.linear().col(1) = first.along_column * first.spacing_j_mm;
  header.T_file_index.linear().col(2) = (last.origin - first.origin) / steps;  // oblique where the gantry was tilted
  header.T_file_index.translation() = first.origin;
  if (auto bytes = checked_bytes(path, header, first.type); !bytes) return bytes.error();
  const auto slice_bytes = static_cast<std::uint64_t>(first.columns) * static_cast<std::uint64_t>(first.rows) *
                           bytes_per_sample(first.type) * 2;  // GDCM's copy and ours
  if (auto fits = check_budget(path, slice_bytes, options.memory_budget_bytes, "one slice", "raise the budget");
      !fits) {
    return fits.error();
  }
  return std::unique_ptr<SliceReader>(std::make_unique<DicomReader>(std::move(header), std::move(*slices)));
}

}  // namespace scanknit
