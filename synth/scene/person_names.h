// The persons that may be in the picture.
#pragma once

#include <array>
#include <string_view>

namespace scanknit {

enum class PersonKind { kNobody, kSitting, kWalking };

/// In the order of PersonKind: nobody; somebody who sits on a chair, sways, and moves an arm; and somebody who walks to
/// and fro through the picture.
inline constexpr std::array<std::string_view, 3> kPersonNames = {"nobody", "sitting", "walking"};

}  // namespace scanknit
