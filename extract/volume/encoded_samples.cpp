#include <zlib.h>

#include <algorithm>
#include <bit>
#include <fstream>
#include <iomanip>
#include <vector>

#include "core/check.h"
#include "extract/volume/header_text.h"
#include "extract/volume/readers.h"

namespace scanknit {
namespace {

using Path = std::filesystem::path;

class WholeReader final : public SliceReader {
 public:
  WholeReader(FileLayout layout, std::vector<std::byte> bytes) : layout_(std::move(layout)), bytes_(std::move(bytes)) {}

  [[nodiscard]] const VolumeHeader& header() const override { return layout_.header; }
  [[nodiscard]] bool is_streamed() const override { return false; }

  [[nodiscard]] Result<void> read_slice(int k, std::span<float> samples) override {
    SCANKNIT_CHECK(k >= 0 && k < layout_.header.dims.z());
    const std::size_t slice_bytes = bytes_.size() / static_cast<std::size_t>(layout_.header.dims.z());
    const auto slice = std::span(bytes_).subspan(static_cast<std::size_t>(k) * slice_bytes, slice_bytes);
    decode_samples(slice, layout_.type, layout_.order, layout_.rescale, samples);
    return {};
  }

 private:
  FileLayout layout_;
  std::vector<std::byte> bytes_;
};

// An inflating stream of zlib's or gzip's format. gzip may have several parts, one after the other.
class Inflater {
 public:
  Inflater(const Path& path, std::uint64_t offset) : file_(path, std::ios::binary), input_(kChunkBytes) {
    file_.seekg(static_cast<std::streamoff>(offset));
    constexpr int kZlibOrGzip = 15 + 32;  // zlib.h, inflateInit2
    is_good_ = inflateInit2(&stream_, kZlibOrGzip) == Z_OK;
  }
  ~Inflater() { inflateEnd(&stream_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  /// False when the stream is corrupt or ends before `bytes` is full.
  [[nodiscard]] bool fill(std::span<std::byte> bytes) {
    while (is_good_ && !bytes.empty()) {
      if (is_at_end_) is_good_ = inflateReset(&stream_) == Z_OK;
      bytes = bytes.subspan(step(bytes));
    }
    return is_good_;
  }

  /// False unless `size` bytes follow.
  [[nodiscard]] bool skip(std::uint64_t size) {
    std::vector<std::byte> skipped(kChunkBytes);
    for (; is_good_ && size > 0; size -= std::min<std::uint64_t>(size, kChunkBytes)) {
      (void)fill(std::span(skipped).first(static_cast<std::size_t>(std::min<std::uint64_t>(size, kChunkBytes))));
    }
    return is_good_;
  }

  /// False unless the stream goes on without a fault to its check sum.
  [[nodiscard]] bool finish() {
    std::vector<std::byte> skipped(kChunkBytes);
    while (is_good_ && !is_at_end_) (void)step(skipped);
    return is_good_;
  }

 private:
  // Inflates into the first of `bytes`, as many as are returned. Without input, inflate reports Z_BUF_ERROR: the end of
  // the file needs no case of its own.
  [[nodiscard]] std::size_t step(std::span<std::byte> bytes) {
    if (stream_.avail_in == 0) {
      file_.read(input_.data(), static_cast<std::streamsize>(input_.size()));
      stream_.next_in = reinterpret_cast<Bytef*>(input_.data());
      stream_.avail_in = static_cast<uInt>(file_.gcount());
    }
    const std::size_t part = std::min<std::size_t>(bytes.size(), std::size_t{1} << 30);  // zlib counts in 32 bits
    stream_.next_out = reinterpret_cast<Bytef*>(bytes.data());
    stream_.avail_out = static_cast<uInt>(part);
    const int status = inflate(&stream_, Z_NO_FLUSH);
    is_at_end_ = status == Z_STREAM_END;
    is_good_ = is_good_ && (status == Z_OK || is_at_end_);
    return part - stream_.avail_out;
  }

  static constexpr std::size_t kChunkBytes = std::size_t{1} << 16;
  std::ifstream file_;
  std::vector<char> input_;
  z_stream stream_{};
  bool is_good_ = false;
  bool is_at_end_ = false;
};

// To the end of the stream, whose check sum tells whether the samples are what was written.
bool inflate_samples(const Path& path, const FileLayout& layout, std::vector<std::byte>& bytes) {
  Inflater stream(path, layout.data_offset);
  return stream.skip(layout.decoded_offset) && stream.fill(bytes) && stream.finish();
}

// Numbers between blanks, kept as doubles.
bool parse_samples(const Path& path, const FileLayout& layout, std::vector<std::byte>& bytes) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(static_cast<std::streamoff>(layout.data_offset));
  std::string word;
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(double)) {
    if (!(file >> std::setw(64) >> word)) return false;
    const auto value = parse_number<double>(word);
    if (!value) return false;
    std::ranges::copy(std::as_bytes(std::span(&*value, 1)), bytes.begin() + static_cast<std::ptrdiff_t>(at));
  }
  return true;
}

}  // namespace

Result<std::unique_ptr<SliceReader>> open_encoded_samples(const Path& data_path, FileLayout layout,
                                                          std::size_t budget_bytes) {
  const auto bytes = checked_bytes(data_path, layout.header, layout.type);
  if (!bytes) return bytes.error();
  std::error_code code;
  const std::uint64_t file_bytes = std::filesystem::file_size(data_path, code);
  if (code) return bad_volume(data_path, "the file of the samples: " + code.message());
  const SampleType stored_type = layout.type;
  // Deflate packs at most 1032 bytes into one (zlib's technical notes); text needs a character for each sample.
  constexpr std::uint64_t kDeflateRatio = 1032;
  const bool is_impossible = layout.encoding == Encoding::kText ? *bytes / bytes_per_sample(stored_type) > file_bytes
                                                                : *bytes / kDeflateRatio > file_bytes;
  if (is_impossible) {
    return bad_volume(data_path, "the header promises " + std::to_string(*bytes) + " bytes of samples; a file of " +
                                     std::to_string(file_bytes) + " bytes cannot hold them");
  }
  const std::uint64_t held =
      layout.encoding == Encoding::kText ? *bytes / bytes_per_sample(stored_type) * sizeof(double) : *bytes;
  if (auto fits = check_budget(data_path, held, budget_bytes,
                               "decoding " + dims_text(layout.header.dims) + " samples of " + layout.header.sample_type,
                               "save the volume uncompressed (it is then streamed) or raise the budget");
      !fits) {
    return fits.error();
  }
  if (layout.encoding == Encoding::kText) {
    layout.type = SampleType::kDouble;
    layout.order = std::endian::native == std::endian::little ? ByteOrder::kLittle : ByteOrder::kBig;
  }
  const auto samples = static_cast<std::size_t>(*bytes) / bytes_per_sample(stored_type);
  std::vector<std::byte> decoded(samples * bytes_per_sample(layout.type));
  const bool is_text = layout.encoding == Encoding::kText;
  if (!(is_text ? parse_samples : inflate_samples)(data_path, layout, decoded)) {
    return bad_volume(data_path, "the samples are truncated or corrupt");
  }
  return std::unique_ptr<SliceReader>(std::make_unique<WholeReader>(std::move(layout), std::move(decoded)));
}

}  // namespace scanknit
