// The ways in which a hand may carry the camera along a scene's path.
#pragma once

#include <array>
#include <string_view>

namespace scanknit {

/// In the order of PathKind:
///   scene  the scene's own path at a steady pace, as a machine would fly it
///   hand   the same with tremor and sway
///   turns  a hand that looks aside suddenly and back again, by 40 to 75 degrees at up to 120 degrees a second
///   walk   steps, sway, tremor, and a stop of one to two seconds now and then
///   orbit  a hand that stays where the path begins, while the wrist circles round what it looks at
inline constexpr std::array<std::string_view, 5> kPathNames = {"scene", "hand", "turns", "walk", "orbit"};

enum class PathKind { kScene, kHand, kTurns, kWalk, kOrbit };

}  // namespace scanknit
