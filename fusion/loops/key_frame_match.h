// Finds the motion between two key frames, if they show the same place.
#pragma once

#include <optional>
#include <vector>

#include "fusion/loops/key_frames.h"
#include "fusion/loops/pose_graph.h"
#include "fusion/register/icp.h"

namespace scanknit {

struct KeyFrameMatch {
  Pose T_a_b = Pose::Identity();
  Matrix6d information = Matrix6d::Zero();  ///< like PoseEdge::information
  double overlap = 0;                       ///< the smaller value of both directions
  double inlier_share = 0;                  ///< likewise
  double contradicted_share = 0;            ///< the larger value
  double colour_agreement = 0;              ///< the smaller value
};

/// The share of b's points that fall into a's picture if b is at T_a_b.
[[nodiscard]] double expected_overlap(const KeyFrame& a, const KeyFrame& b, const Pose& T_a_b);

/// Whether the scene must determine the motion in all directions.
enum class Determined { kAllDirections, kAny };

/// Registers b with a from the best of `T_a_b_guesses`, and a with b from that result. Nothing unless both fit well and
/// agree, and the scene determines the motion as `determined` requires. `registration` has the noise of one frame.
[[nodiscard]] std::optional<KeyFrameMatch> match_key_frames(const KeyFrame& a, const KeyFrame& b,
                                                            const std::vector<Pose>& T_a_b_guesses,
                                                            const IcpConfig& registration,
                                                            Determined determined = Determined::kAllDirections);

}  // namespace scanknit
