// The bytes of TrackedPoses in a plan's file. Private to the room.
#pragma once

#include <string>

#include "scan/bricks/plan_bytes.h"
#include "scan/bricks/planned_scan.h"

namespace scanknit {

void append_tracked(std::string& bytes, const TrackedPoses& tracked);

[[nodiscard]] TrackedPoses take_tracked(PlanReader& plan);

}  // namespace scanknit
