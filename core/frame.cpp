#include "core/frame.h"

namespace scanknit {

const char* to_string(DropReason reason) {
  switch (reason) {
    case DropReason::kMissingFile: return "missing_file";
    case DropReason::kUnreadable: return "unreadable";
    case DropReason::kSizeMismatch: return "size_mismatch";
    case DropReason::kNoPose: return "no_pose";
    case DropReason::kBadPose: return "bad_pose";
    case DropReason::kNoIntrinsics: return "no_intrinsics";
    case DropReason::kNoDepth: return "no_depth";
    case DropReason::kTimestamp: return "timestamp";
    case DropReason::kUnsafePath: return "unsafe_path";
    case DropReason::kQueue: return "queue";
  }
  return "unreadable";
}

}  // namespace scanknit
