#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "core/check.h"
#include "core/files/byte_reader.h"
#include "core/files/read_file.h"
#include "core/limits.h"
#include "extract/volume/header_text.h"
#include "extract/volume/natural_order.h"
#include "extract/volume/readers.h"
#include "extract/volume/slice_files.h"

namespace scanknit {
namespace {

using Path = std::filesystem::path;

struct PixelCounts {
  std::int64_t image = 0;
  std::int64_t tile = 0;
};

PixelCounts png_pixels(ByteReader reader) {
  (void)reader.take(16);  // signature, length and name of the first chunk, IHDR
  const auto width = reader.big_endian<std::uint32_t>();
  const auto height = reader.big_endian<std::uint32_t>();
  if (!width || !height || (*width | *height) >> 31) return {};
  return {std::int64_t{*width} * std::int64_t{*height}, 1};
}

// TIFF 6.0: what a directory says of its page.
struct TiffPage {
  std::int64_t width = 0, height = 0, tile_width = 1, tile_height = 1;
  std::int64_t kind = 0;          // NewSubfileType
  std::uint32_t next_offset = 0;  // of the next page's directory; 0: none
};

std::optional<TiffPage> tiff_page(std::span<const std::byte> bytes, std::uint32_t offset, bool is_little) {
  const auto number = [&]<typename T>(ByteReader& reader, T) {
    return (is_little ? reader.little_endian<T>() : reader.big_endian<T>()).value_or(T{0});
  };
  if (offset > bytes.size()) return std::nullopt;
  ByteReader directory(bytes.subspan(offset));
  TiffPage page;
  for (auto count = number(directory, std::uint16_t{}); count > 0; --count) {
    const auto tag = number(directory, std::uint16_t{});
    const auto type = number(directory, std::uint16_t{});
    (void)directory.take(4);  // the number of values, 1
    const auto field = directory.take(4);
    if (!field) return std::nullopt;
    ByteReader reader(*field);
    constexpr std::uint16_t kShort = 3;
    const std::int64_t value = type == kShort ? number(reader, std::uint16_t{}) : number(reader, std::uint32_t{});
    switch (tag) {
      case 254: page.kind = value; break;
      case 256: page.width = value; break;
      case 257: page.height = value; break;
      case 322: page.tile_width = value; break;
      case 323: page.tile_height = value; break;
      default: break;
    }
  }
  page.next_offset = number(directory, std::uint32_t{});
  return page;
}

std::optional<TiffPage> first_tiff_page(std::span<const std::byte> bytes) {
  const bool is_little = bytes[0] == std::byte{'I'};
  ByteReader start(bytes);
  (void)start.take(4);
  const auto offset = is_little ? start.little_endian<std::uint32_t>() : start.big_endian<std::uint32_t>();
  return offset ? tiff_page(bytes, *offset, is_little) : std::nullopt;
}

PixelCounts tiff_pixels(std::span<const std::byte> bytes) {
  const auto page = first_tiff_page(bytes);
  if (!page || std::max({page->width, page->height, page->tile_width, page->tile_height}) >> 31) return {};
  return {page->width * page->height, page->tile_width * page->tile_height};
}

// Whether a second picture follows the first: a page that is neither a smaller copy of another nor a mask.
bool has_second_tiff_page(std::span<const std::byte> bytes) {
  constexpr int kMostPages = 64;  // directories may run in a circle
  constexpr std::int64_t kSmallerCopy = 1, kMask = 4;
  auto page = first_tiff_page(bytes);
  for (int n = 1; n < kMostPages && page && page->next_offset != 0; ++n) {
    page = tiff_page(bytes, page->next_offset, bytes[0] == std::byte{'I'});
    if (page && (page->kind & (kSmallerCopy | kMask)) == 0) return true;
  }
  return false;
}

// The decoder meets only pictures whose headers were checked: it allocates what they promise.
Result<void> check_sizes(std::span<const std::byte> bytes, const Path& path) {
  const auto begins = [&](std::string_view magic) {
    return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
  };
  using namespace std::string_view_literals;
  PixelCounts pixels;
  bool has_second_page = false;
  if (begins("\x89PNG\r\n\x1a\n"sv)) {
    pixels = png_pixels(ByteReader(bytes));
  } else if (begins("II*\0"sv) || begins("MM\0*"sv)) {
    pixels = tiff_pixels(bytes);
    has_second_page = has_second_tiff_page(bytes);
  } else {
    return bad_volume(path, "neither PNG nor TIFF (BigTIFF is not read)");
  }
  const std::int64_t limit = Limits{}.max_image_pixels;
  if (std::min(pixels.image, pixels.tile) < 1 || std::max(pixels.image, pixels.tile) > limit) {
    return bad_volume(path, "truncated, or not of 1 to " + std::to_string(limit) + " pixels");
  }
  if (has_second_page) return bad_volume(path, "a TIFF of several pages; save each page as a file of its own");
  return {};
}

Result<cv::Mat> decode_image(const Path& path) {
  auto bytes = read_file(path, Limits{}.max_image_bytes);
  if (!bytes) return bytes.error();
  if (auto fits = check_sizes(*bytes, path); !fits) return fits.error();
  try {
    const cv::Mat encoded(1, static_cast<int>(bytes->size()), CV_8UC1, bytes->data());
    cv::Mat image = cv::imdecode(encoded, cv::IMREAD_UNCHANGED);
    if (image.empty()) return bad_volume(path, "truncated, corrupt, or of a kind that cannot be decoded");
    return image;
  } catch (const cv::Exception& fault) {
    if (fault.code == cv::Error::StsNoMem) throw std::bad_alloc();
    return bad_volume(path, "cannot be decoded: " + fault.err);
  }
}

std::optional<SampleType> depth_type(const cv::Mat& image) {
  const bool is_floating_point = image.depth() == CV_32F || image.depth() == CV_64F;
  const bool is_signed = image.depth() != CV_8U && image.depth() != CV_16U;
  return sample_type_of(image.elemSize1(), is_signed, is_floating_point);
}

// ITU-R BT.601 luma of blue, green, red; a fourth channel is alpha.
void reduce_to_luminance(std::span<const float> pixels, std::size_t channels, std::span<float> samples) {
  for (std::size_t n = 0; n < samples.size(); ++n) {
    const auto pixel = pixels.subspan(n * channels, channels);
    samples[n] = 0.114f * pixel[0] + 0.587f * pixel[1] + 0.299f * pixel[2];
  }
}

// The first number that the sorted names leave out; nothing where there is none.
std::optional<std::string> gap_warning(const std::vector<Path>& files) {
  for (std::size_t n = 1; n < files.size(); ++n) {
    const std::string before = files[n - 1].filename().string(), after = files[n].filename().string();
    const auto missing = skipped_number(before, after);
    if (!missing) continue;
    return "no slice number " + std::to_string(*missing) + ": " + after + " follows " + before +
           "; the slices are taken as evenly spaced";
  }
  return std::nullopt;
}

class ImageStackReader final : public SliceReader {
 public:
  ImageStackReader(VolumeHeader header, std::vector<Path> files, int image_type)
      : header_(std::move(header)), files_(std::move(files)), image_type_(image_type) {}

  [[nodiscard]] const VolumeHeader& header() const override { return header_; }
  [[nodiscard]] bool is_streamed() const override { return true; }

  [[nodiscard]] Result<void> read_slice(int k, std::span<float> samples) override {
    SCANKNIT_CHECK(k >= 0 && k < header_.dims.z());
    const Path& path = files_[static_cast<std::size_t>(k)];
    auto image = decode_image(path);
    if (!image) return image.error();
    if (image->cols != header_.dims.x() || image->rows != header_.dims.y() || image->type() != image_type_) {
      return bad_volume(path, "differs from the first slice in size, type or number of channels");
    }
    const auto channels = static_cast<std::size_t>(image->channels());
    const std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(image->data),
                                           image->total() * image->elemSize());
    constexpr ByteOrder kHere = std::endian::native == std::endian::little ? ByteOrder::kLittle : ByteOrder::kBig;
    if (channels == 1) {
      decode_samples(bytes, *depth_type(*image), kHere, {}, samples);
      return {};
    }
    pixels_.resize(samples.size() * channels);
    decode_samples(bytes, *depth_type(*image), kHere, {}, pixels_);
    reduce_to_luminance(pixels_, channels, samples);
    return {};
  }

 private:
  VolumeHeader header_;
  std::vector<Path> files_;
  int image_type_;
  std::vector<float> pixels_;
};

}  // namespace

Result<std::unique_ptr<SliceReader>> open_image_stack(const Path& folder, const VolumeOptions& options) {
  const auto usage = [&](const char* message) { return Error{ErrorCode::kUsage, message, folder.string()}; };
  if (!options.spacing) return usage("a stack of images needs its spacing: x, y and between slices, in mm");
  if (!(options.spacing->minCoeff() > 0) || !options.spacing->allFinite()) return usage("spacing: expected > 0 mm");
  if (options.dims || options.type) return usage("dims and type are for raw samples; images say their own");
  std::vector<Path> files;
  std::error_code code;
  for (std::filesystem::directory_iterator entry(folder, code), end; !code && entry != end; entry.increment(code)) {
    if (has_image_name(entry->path())) files.push_back(entry->path());
  }
  if (code) return bad_volume(folder, code.message());
  std::ranges::sort(files, [](const Path& a, const Path& b) {
    return is_naturally_before(a.filename().string(), b.filename().string());
  });
  if (files.empty()) return bad_volume(folder, "no image in this folder any more");
  auto first = decode_image(files.front());
  if (!first) return first.error();
  if (files.size() < 2) return bad_volume(folder, "a single image; a volume has at least 2 slices");
  const auto type = depth_type(*first);
  if (!type || first->channels() == 2) return bad_volume(files.front(), "neither grey nor colour");

  VolumeHeader header;
  header.format = "image stack";
  set_sample_type(header, *type);
  header.dims = {first->cols, first->rows, static_cast<int>(files.size())};
  header.T_file_index.linear() = options.spacing->asDiagonal();
  if (auto gap = gap_warning(files)) header.warnings.push_back(std::move(*gap));
  if (first->channels() > 1) header.warnings.emplace_back("colour images: their luminance is taken");
  if (auto bytes = checked_bytes(folder, header, *type); !bytes) return bytes.error();
  const auto slice_bytes = static_cast<std::uint64_t>(
      first->total() * (first->elemSize() + sizeof(float) * static_cast<std::size_t>(first->channels())));
  if (auto fits = check_budget(folder, slice_bytes, options.memory_budget_bytes, "one slice", "raise the budget");
      !fits) {
    return fits.error();
  }
  return std::unique_ptr<SliceReader>(
      std::make_unique<ImageStackReader>(std::move(header), std::move(files), first->type()));
}

}  // namespace scanknit
