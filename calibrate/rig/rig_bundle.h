// RigBundle: the cameras of a rig and the board's poses before them, estimated together.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "calibrate/lens/bundle.h"
#include "calibrate/lens/lens.h"
#include "core/pose.h"

namespace scanknit {

/// What one camera saw of the board at a moment; the lists are of one length.
struct RigSighting {
  std::size_t camera = 0;
  std::vector<Eigen::Vector2d> board_m = {}, pixels = {};
  std::vector<Eigen::Vector2d> pixels_per_s = {};  ///< how the corners move
};

struct RigMoment {
  Pose T_rig_board = Pose::Identity();
  std::vector<RigSighting> sightings = {};
};

struct RigBundleCamera {
  LensVector lens = LensVector::Zero();
  FreeLens free = FreeLens::kNone;
  Pose T_camera_rig = Pose::Identity();
  double late_s = 0;  ///< at the moments its clock shows so much more than was assumed: it saw pixel + late_s speed
};

/// The first camera is the rig: its pose and clock are held.
struct RigBundle {
  std::vector<RigBundleCamera> cameras;
  std::vector<RigMoment> moments;
};

/// lens, pose (moved()) and clock of a camera.
inline constexpr Eigen::Index kRigNumbers = 9 + 6 + 1;

/// As optimise() of a Bundle: over poses, clocks and free lenses of all cameras. The board's poses are eliminated.
void optimise(RigBundle& bundle, double huber_px);

/// Seen minus projected, pixels; infinite where the corner would be behind the camera.
[[nodiscard]] std::vector<Eigen::Vector2d> residuals(const RigBundle& bundle, const RigMoment& moment,
                                                     const RigSighting& sighting);

/// The covariance of all cameras' numbers, kRigNumbers each, for residuals of deviation 1; those that are held are 0.
[[nodiscard]] Eigen::MatrixXd covariance(const RigBundle& bundle);

}  // namespace scanknit
