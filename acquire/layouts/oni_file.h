// OniFile: a recording of OpenNI (.oni, versions 1 and 2). Read by ourselves: OpenNI's own player believes every number
// in the file (docs/devices.md). Private to the room.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "acquire/mcap/random_access.h"
#include "acquire/raw_frame.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

struct OniPicture {
  std::uint64_t offset = 0;  ///< of its bytes in the file
  std::uint32_t bytes = 0;
  std::uint32_t number = 0;
  std::uint64_t time_us = 0;
};

enum class OniCoding { kPlain, kDepthSteps, kDepthStepsTable, kJpeg, kUnknown };

/// Pictures of one kind, and what the file says of them before the first.
struct OniStream {
  StreamProfile profile;
  OniCoding coding = OniCoding::kUnknown;
  bool is_readable = true;  ///< false: pixels that we cannot use (infrared, shifts instead of depth)
  bool is_mirrored = false;
  bool is_cropped = false;
  double depth_unit_m = 0.001;
  double view_x_rad = 0, view_y_rad = 0;  ///< the whole picture's, as the file states it; 0: not at all
  std::vector<OniPicture> pictures;       ///< in the order of the file
};

/// Whether the file's first bytes say that it is one.
[[nodiscard]] bool is_oni(const RandomAccess& file);

class OniFile {
 public:
  /// Walks the whole file; what comes after a fault is left out. Errors (kInput, without `where`): no recording, of an
  /// unknown version, without a single picture of depth.
  [[nodiscard]] static Result<OniFile> open(std::unique_ptr<RandomAccess> file, const Limits& limits);

  [[nodiscard]] const OniStream& depth() const { return depth_; }
  [[nodiscard]] const std::optional<OniStream>& colour() const { return colour_; }

  /// Why the file is not whole; nothing when it is.
  [[nodiscard]] const std::optional<std::string>& fault() const { return fault_; }

  /// The picture with the left side on the left: JPEG as it is (unless mirrored), the rest as plain pixels. Errors
  /// (kInput, without `where`): damaged, not of its stream's size, of a kind that is not read.
  [[nodiscard]] Result<RawFrame> read(StreamKind kind, std::size_t index) const;

 private:
  OniFile(std::unique_ptr<RandomAccess> file, const Limits& limits) : file_(std::move(file)), limits_(limits) {}
  [[nodiscard]] Result<std::vector<std::byte>> read_pixels(const OniStream& stream, const OniPicture& picture) const;

  std::unique_ptr<RandomAccess> file_;
  Limits limits_;
  OniStream depth_;
  std::optional<OniStream> colour_;
  std::optional<std::string> fault_;
};

}  // namespace scanknit
