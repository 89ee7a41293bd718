// The views of a board in the pictures of one camera, and what is said where there are too few.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "acquire/acquire_config.h"
#include "calibrate/board/board_pictures.h"
#include "calibrate/calibrate_camera.h"
#include "calibrate/target/calibration_target.h"
#include "core/result.h"

namespace scanknit {

/// The views of the board in the pictures so far.
struct FoundViews {
  std::vector<BoardView> views;
  PictureSize size;
  std::array<std::size_t, 5> by_sight{};  ///< pictures, by BoardSight

  [[nodiscard]] std::size_t count(BoardSight sight) const { return by_sight[static_cast<std::size_t>(sight)]; }
};

/// Adds the picture's view if it shows the board. Errors: kInput: another size than the pictures before it;
/// find_board()'s.
[[nodiscard]] Result<void> look_at(const BoardPicture& taken, const CalibrationTarget& target, FoundViews& found);

/// Why too few pictures show the board; nothing if enough do. `where` names the recording.
[[nodiscard]] std::optional<Error> why_unseen(const FoundViews& found, std::size_t pictures, const std::string& where);

/// What a lens says of the cameras of the recording that it was measured in: colour, or depth if the pictures are
/// depth's; of colour that has depth's view, depth, too.
[[nodiscard]] ScannerCamera cameras_of(const CameraModel& camera, const BoardPictures& pictures, bool is_depth);

}  // namespace scanknit
