// The pictures of a board: colour of a recording, or a folder of pictures.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include "acquire/acquire_config.h"
#include "core/frame.h"
#include "core/image.h"
#include "core/result.h"

namespace scanknit {

/// No more pictures of a recording are looked at: every n-th is taken.
inline constexpr std::size_t kMostBoardPictures = 400;

/// What the pictures are.
struct BoardPictures {
  std::size_t read = 0;     ///< pictures that were given to the caller
  std::size_t dropped = 0;  ///< frames without colour, or that could not be read
  bool is_recording = false;
  std::size_t every = 1;  ///< of a recording, every so many frames were looked at
  bool was_stopped = false;
  /// The size of depth, if depth has the colour camera's view: then the colour camera's lens is also its own.
  std::optional<CameraIntrinsics> registered_depth = {};
};

/// Called for each picture, with its name and the number of pictures that are expected.
using TakeBoardPicture =
    std::function<Result<void>(const ColourImage& picture, const std::string& name, std::size_t expected)>;

/// The name of a recording's picture.
[[nodiscard]] std::string board_frame_name(const Frame& frame);

/// Pictures as the camera took them: lenses that the recording states are not straightened. `acquire` is for reading
/// the recording; its cameras are ignored. Ends at the first error of `take`, and when a stop is asked for. Errors
/// (kInput): neither a recording nor a folder with .png or .jpg files, a recording without colour, a file of the folder
/// that is no picture.
[[nodiscard]] Result<BoardPictures> read_board_pictures(const std::filesystem::path& path, AcquireConfig acquire,
                                                        const TakeBoardPicture& take, const std::stop_token& stop);

}  // namespace scanknit
