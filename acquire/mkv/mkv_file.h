// What a Matroska file (RFC 9559) holds: its tracks, tags, an attached file, and where each picture is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acquire/mcap/random_access.h"
#include "core/limits.h"
#include "core/result.h"

namespace scanknit {

struct MkvTrack {
  std::uint64_t number = 0;  ///< by which blocks name it
  std::uint64_t uid = 0;     ///< by which tags name it
  std::string name;
  std::string codec;   ///< "V_MJPEG"; "V_MS/VFW/FOURCC": see fourcc
  std::string fourcc;  ///< "b16g", "MJPG"; empty: none
  std::uint64_t width = 0, height = 0;
  std::uint64_t period_ns = 0;  ///< 0: unknown
  bool is_video = false;
  bool is_packed = false;  ///< by a coding of the container's, which is not read
};

/// One picture, or whatever else a track holds.
struct MkvBlock {
  std::int64_t time_ns = 0;
  std::uint64_t at = 0, bytes = 0;
};

struct MkvFile {
  std::string title;
  std::vector<MkvTrack> tracks;
  std::map<std::string, std::string> tags;                 ///< whatever they are of; the first of a name
  std::map<std::string, std::vector<std::byte>> attached;  ///< JSON files by their names
  std::map<std::uint64_t, std::vector<MkvBlock>> blocks;   ///< by the track's number, in the order of the file
  bool is_torn = false;                                    ///< cut off or damaged: what comes after is not listed
  std::uint64_t laced = 0;                                 ///< blocks that hold several pictures, which are not listed
};

/// True if the file's first bytes are a Matroska file's.
[[nodiscard]] bool is_matroska(const RandomAccess& file);

/// Goes through the whole file by the sizes of its elements; the content of blocks is not read. Nothing that the file
/// says is allocated before it is checked. Blocks are listed of at most `limits.max_frames` a track.
[[nodiscard]] MkvFile survey_mkv(const RandomAccess& file, const Limits& limits);

}  // namespace scanknit
