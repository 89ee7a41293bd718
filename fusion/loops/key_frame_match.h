// The motion between two key frames, if they show the same place.
#pragma once

#include <optional>
#include <vector>

#include "core/noise_model.h"
#include "fusion/loops/key_frames.h"
#include "fusion/loops/pose_graph.h"

namespace scanknit {

struct KeyFrameMatch {
  Pose T_a_b = Pose::Identity();
  Matrix6d information = Matrix6d::Zero();  ///< as PoseEdge's
  double overlap = 0;                       ///< the smaller of the two ways
  double inlier_share = 0;                  ///< also
  double contradicted_share = 0;            ///< the larger
  double colour_agreement = 0;              ///< the smaller
};

/// The share of b's points that would lie in a's picture if b were at T_a_b.
[[nodiscard]] double expected_overlap(const KeyFrame& a, const KeyFrame& b, const Pose& T_a_b);

/// Whether the scene must hold the camera in all directions.
enum class Hold { kAllDirections, kAny };

/// Registers b with a from the best of `T_a_b_guesses`, and a with b from where that leads. Nothing unless both fit
/// well and lead to the same place, and the scene holds the camera as it must.
[[nodiscard]] std::optional<KeyFrameMatch> match_key_frames(const KeyFrame& a, const KeyFrame& b,
                                                            const std::vector<Pose>& T_a_b_guesses,
                                                            const NoiseModel& noise, Hold hold = Hold::kAllDirections);

}  // namespace scanknit
