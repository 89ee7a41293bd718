// The axis that points up.
#pragma once

namespace scanknit {

enum class UpAxis { kX, kY, kZ, kMinusX, kMinusY, kMinusZ };

}  // namespace scanknit
