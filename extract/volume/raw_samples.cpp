#include <fstream>
#include <vector>

#include "core/check.h"
#include "extract/volume/readers.h"

namespace scanknit {
namespace {

class RawReader final : public SliceReader {
 public:
  RawReader(const std::filesystem::path& path, FileLayout layout, std::uint64_t offset, std::size_t slice_bytes)
      : path_(path), layout_(std::move(layout)), offset_(offset), slice_(slice_bytes), file_(path, std::ios::binary) {}

  [[nodiscard]] const VolumeHeader& header() const override { return layout_.header; }
  [[nodiscard]] bool is_streamed() const override { return true; }

  [[nodiscard]] Result<void> read_slice(int k, std::span<float> samples) override {
    SCANKNIT_CHECK(k >= 0 && k < layout_.header.dims.z());
    file_.clear();
    file_.seekg(static_cast<std::streamoff>(offset_ + static_cast<std::uint64_t>(k) * slice_.size()));
    file_.read(reinterpret_cast<char*>(slice_.data()), static_cast<std::streamsize>(slice_.size()));
    if (file_.gcount() != static_cast<std::streamsize>(slice_.size())) {
      return bad_volume(path_, "slice " + std::to_string(k) + " cannot be read");
    }
    decode_samples(slice_, layout_.type, layout_.order, layout_.rescale, samples);
    return {};
  }

 private:
  std::filesystem::path path_;
  FileLayout layout_;
  std::uint64_t offset_;
  std::vector<std::byte> slice_;
  std::ifstream file_;
};

}  // namespace

Result<std::unique_ptr<SliceReader>> open_raw_samples(const std::filesystem::path& data_path, FileLayout layout,
                                                      std::size_t budget_bytes) {
  const auto bytes = checked_bytes(data_path, layout.header, layout.type);
  if (!bytes) return bytes.error();
  std::error_code code;
  const std::uint64_t file_bytes = std::filesystem::file_size(data_path, code);
  if (code) return bad_volume(data_path, "the file of the samples: " + code.message());
  std::uint64_t offset = layout.data_offset;
  if (layout.is_at_end && file_bytes >= *bytes) offset = file_bytes - *bytes;
  if (offset > file_bytes || *bytes > file_bytes - offset) {
    return bad_volume(data_path, dims_text(layout.header.dims) + " samples of " + layout.header.sample_type +
                                     " from byte " + std::to_string(offset) + " need " + std::to_string(*bytes) +
                                     " bytes; the file has " + std::to_string(file_bytes) + " in all");
  }
  const std::uint64_t slice_bytes = *bytes / static_cast<std::uint64_t>(layout.header.dims.z());
  if (auto fits = check_budget(data_path, slice_bytes, budget_bytes, "one slice", "raise the budget"); !fits) {
    return fits.error();
  }
  return std::unique_ptr<SliceReader>(
      std::make_unique<RawReader>(data_path, std::move(layout), offset, static_cast<std::size_t>(slice_bytes)));
}

}  // namespace scanknit
