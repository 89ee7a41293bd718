#include "scan/lost_frames.h"

#include <utility>

namespace scanknit {
namespace {

constexpr std::size_t kMostWaiting = 32;  // frames; 2 MB each at 640 x 480
constexpr int kMostMisses = 5;            // frames in a row: then the camera has moved too far
constexpr std::size_t kSureViews = 3;

KnownFrame known(const Frame& frame, const TrackResult& result) {
  return {result.T_world_camera, frame.timestamp_ns};
}

}  // namespace

Result<void> LostFrames::add_known_frame(const KnownFrame& frame) {
  recognised_.clear();
  if (auto tracked = track_backward_from(frame); !tracked) return tracked;
  before_ = frame;
  misses_ = 0;
  return {};
}

Result<void> LostFrames::add_lost_frame(const Frame& frame) {
  const auto found = track_forward(frame);
  if (!found) return found.error();
  if (*found) return {};
  waiting_.push_back(frame);
  if (waiting_.size() > kMostWaiting) waiting_.pop_front();
  return relocalise(frame);
}

Result<std::optional<LostFrames::Found>> LostFrames::find(const Frame& frame,
                                                          const std::optional<KnownFrame>& neighbour) {
  Found found{frame, {}};
  auto result = calls_.track(found.frame, neighbour);
  if (!result) return result.error();
  if (result->is_lost()) return std::optional<Found>();
  found.result = *std::move(result);
  return std::optional(std::move(found));
}

/// Whether the frame was found from the one before it.
Result<bool> LostFrames::track_forward(const Frame& frame) {
  if (!before_) return false;
  auto found = find(frame, before_);
  if (!found) return found.error();
  if (!*found) {
    if (++misses_ == kMostMisses) before_.reset();
    return false;
  }
  if (auto fused = calls_.fuse((*found)->frame, (*found)->result); !fused) return fused.error();
  before_ = known(frame, (*found)->result);
  misses_ = 0;
  return true;
}

/// Looks for known places that the frame may show. When a few in a row show one, they are fused.
Result<void> LostFrames::relocalise(const Frame& frame) {
  const auto neighbour =
      recognised_.empty() ? std::nullopt : std::optional(known(recognised_.back().frame, recognised_.back().result));
  auto found = find(frame, neighbour);
  if (!found) return found.error();
  if (!*found) {
    recognised_.clear();
    return {};
  }
  recognised_.push_back(*std::move(*found));
  if (recognised_.size() < kSureViews) return {};
  std::vector<Found> sure = std::exchange(recognised_, {});
  waiting_.resize(waiting_.size() - sure.size());
  for (Found& view : sure) {
    if (auto fused = calls_.fuse(view.frame, view.result); !fused) return fused;
  }
  before_ = known(sure.back().frame, sure.back().result);
  misses_ = 0;
  return track_backward_from(known(sure.front().frame, sure.front().result));
}

/// Tracks the waiting frames, the last one first, from the known frame after them.
Result<void> LostFrames::track_backward_from(KnownFrame frame) {
  std::deque<Frame> waiting = std::exchange(waiting_, {});
  int misses = 0;
  for (; !waiting.empty() && misses < kMostMisses; waiting.pop_back()) {
    auto found = find(waiting.back(), frame);
    if (!found) return found.error();
    if (!*found) {
      ++misses;
      continue;
    }
    misses = 0;
    frame = known(waiting.back(), (*found)->result);
    if (auto fused = calls_.fuse((*found)->frame, (*found)->result); !fused) return fused;
  }
  return {};
}

}  // namespace scanknit
