// FileLayout: where a volume's samples lie in its file, as the header says; and the checks that every header meets.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "core/result.h"
#include "extract/volume/sample_type.h"
#include "extract/volume/volume_header.h"

namespace scanknit {

enum class Encoding { kRaw, kCompressed, kText };

/// What a header says.
struct FileLayout {
  VolumeHeader header;
  SampleType type = SampleType::kUint8;
  ByteOrder order = ByteOrder::kLittle;
  Rescale rescale;
  Encoding encoding = Encoding::kRaw;
  std::string data_file;          ///< relative to the header's folder; empty: the samples follow in the header's file
  std::uint64_t data_offset = 0;  ///< of the first sample, or of the stream that inflates to the samples
  std::uint64_t decoded_offset = 0;  ///< of the first sample in what a compressed file inflates to
  bool is_at_end = false;            ///< the samples are the file's last bytes; data_offset is not used
};

/// An unusable input.
[[nodiscard]] inline Error bad_volume(const std::filesystem::path& path, std::string message) {
  return Error{ErrorCode::kInput, std::move(message), path.string()};
}

/// Names the samples' type, and warns where they are rounded to floats.
void set_sample_type(VolumeHeader& header, SampleType type);

/// Bytes of all samples. Errors (kInput): an axis of fewer than 2 samples, a size beyond 64 bits, a transform that is
/// not finite or not invertible.
[[nodiscard]] Result<std::uint64_t> checked_bytes(const std::filesystem::path& path, const VolumeHeader& header,
                                                  SampleType type);

/// kBudget when `needed` exceeds `budget`; `what` says what needs it, `advice` what to do instead.
[[nodiscard]] Result<void> check_budget(const std::filesystem::path& path, std::uint64_t needed, std::size_t budget,
                                        const std::string& what, const std::string& advice);

/// "1.5 GiB", "12.0 MiB" or "77 bytes".
[[nodiscard]] std::string bytes_text(std::uint64_t bytes);

/// 2 x 3 x 4
[[nodiscard]] std::string dims_text(const Eigen::Vector3i& dims);

}  // namespace scanknit
