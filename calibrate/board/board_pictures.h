// The pictures of a board: colour of a recording, or a folder of pictures.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "acquire/acquire_config.h"
#include "core/frame.h"
#include "core/image.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// No more pictures of a recording are looked at: every n-th is taken.
inline constexpr std::size_t kMostBoardPictures = 400;

/// One of them.
struct BoardPicture {
  const ColourImage& image;
  std::string name;
  std::size_t expected = 0;                  ///< pictures in all
  std::optional<std::int64_t> timestamp_ns;  ///< of its frame; nothing: a file, or a recording without time stamps
  std::uint64_t sequence = 0;                ///< of its frame
};

/// What the pictures are.
struct BoardPictures {
  std::size_t read = 0;     ///< pictures that were given to the caller
  std::size_t dropped = 0;  ///< frames without colour, or that could not be read
  bool is_recording = false;
  std::size_t every = 1;  ///< of a recording, every so many frames were looked at
  bool was_stopped = false;
  /// The size of depth, if depth has the colour camera's view: then the colour camera's lens is also its own.
  std::optional<CameraIntrinsics> registered_depth = {};
  Pose T_colour_depth = Pose::Identity();  ///< as the recording's first picture says
};

/// Called for each picture.
using TakeBoardPicture = std::function<Result<void>(const BoardPicture& picture)>;

/// The name of a recording's picture.
[[nodiscard]] std::string board_frame_name(const Frame& frame);

/// Pictures as the camera took them: lenses that the recording states are not straightened. `acquire` is for reading
/// the recording; its cameras are ignored. Of a recording, at most `most` pictures are taken. Ends at the first error
/// of `take`, and when a stop is asked for. Errors (kInput): neither a recording nor a folder with .png or .jpg files,
/// a recording without colour, a file of the folder that is no picture.
[[nodiscard]] Result<BoardPictures> read_board_pictures(const std::filesystem::path& path, AcquireConfig acquire,
                                                        const TakeBoardPicture& take, const std::stop_token& stop,
                                                        std::size_t most = kMostBoardPictures);

}  // namespace scanknit
