#include "app/live/tracking_advice.h"

namespace scanknit {

std::string tracking_advice(TrackReason reason) {
  switch (reason) {
    case TrackReason::kNone:
    case TrackReason::kFoundLater:
    case TrackReason::kFoundFromBothSides:
    case TrackReason::kFoundByLoop: return "";
    case TrackReason::kNothingSeen: return "uncover the lens, or move closer";
    case TrackReason::kTooClose: return "step back a little";
    case TrackReason::kTooFewPoints: return "show more of the object or the room";
    case TrackReason::kTooFast: return "go back a little, and move more slowly";
    case TrackReason::kPlaceNotRecognised: return "show something that was scanned before";
    case TrackReason::kMakingSure: return "hold still for a moment";
    case TrackReason::kFlatScene: return "let something with edges or a pattern into view";
    case TrackReason::kSceneIsChanging: return "wait until nothing moves";
    case TrackReason::kSceneHasChanged: return "wait until nothing moves";
    case TrackReason::kLittleOverlap: return "move more slowly";
    case TrackReason::kRecordedPoseKept: return "nothing to do: the recorded pose is used unchanged";
    case TrackReason::kRecordedPoseDoesNotFit: return "frames like this are left out";
  }
  return "";
}

}  // namespace scanknit
