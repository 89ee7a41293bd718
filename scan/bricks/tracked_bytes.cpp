#include "scan/bricks/tracked_bytes.h"

#include <utility>

namespace scanknit {
namespace {

template <typename Enum>
void append_word(std::string& bytes, Enum word) {
  append_little_endian(bytes, static_cast<std::uint8_t>(word));
}

/// A word up to `last`.
template <typename Enum>
Enum take_word(PlanReader& plan, Enum last) {
  const auto word = plan.number<std::uint8_t>();
  plan.require(word <= static_cast<std::uint8_t>(last));
  return static_cast<Enum>(word);
}

void append_frame(std::string& bytes, const TrackedFrame& frame) {
  append_little_endian(bytes, frame.sequence);
  append_word(bytes, frame.state);
  append_word(bytes, frame.reason);
  for (const double figure : {frame.overlap, frame.inlier_share, frame.rms_sigma}) append_little_endian(bytes, figure);
  append_count(bytes, frame.points);
  append_little_endian(bytes, static_cast<std::int32_t>(frame.weak_directions));
}

TrackedFrame take_frame(PlanReader& plan) {
  TrackedFrame frame;
  frame.sequence = plan.number<std::uint64_t>();
  frame.state = take_word(plan, TrackState::kRecovered);
  frame.reason = take_word(plan, TrackReason::kFoundByLoop);
  for (double* figure : {&frame.overlap, &frame.inlier_share, &frame.rms_sigma}) *figure = plan.number<double>();
  frame.points = plan.size();
  frame.weak_directions = plan.number<std::int32_t>();
  return frame;
}

void append_pair(std::string& bytes, const LoopResult::Pair& pair) {
  append_little_endian(bytes, pair.from);
  append_little_endian(bytes, pair.to);
  for (const double figure : {pair.shift_m, pair.overlap, pair.inlier_share}) append_little_endian(bytes, figure);
  append_text(bytes, pair.refused);
}

LoopResult::Pair take_pair(PlanReader& plan) {
  LoopResult::Pair pair{};
  pair.from = plan.number<std::uint64_t>();
  pair.to = plan.number<std::uint64_t>();
  for (double* figure : {&pair.shift_m, &pair.overlap, &pair.inlier_share}) *figure = plan.number<double>();
  pair.refused = plan.text();
  return pair;
}

TrackingResult take_tracking(PlanReader& plan) {
  constexpr std::size_t kFrameBytes = 8 + 1 + 1 + 3 * 8 + 8 + 4;
  TrackingResult tracking;
  tracking.prior = take_word(plan, PosePrior::kRefine);
  tracking.found_later = plan.size();
  for (std::size_t left = plan.count(kFrameBytes); left > 0; --left) tracking.frames.push_back(take_frame(plan));
  return tracking;
}

LoopResult take_loops(PlanReader& plan) {
  constexpr std::size_t kLeastPairBytes = 8 + 8 + 3 * 8 + 8;
  LoopResult loops;
  loops.is_corrected = plan.number<std::uint8_t>() != 0;
  loops.drift_m = plan.number<double>();
  loops.largest_correction_m = plan.number<double>();
  for (std::size_t left = plan.count(kLeastPairBytes); left > 0; --left) loops.pairs.push_back(take_pair(plan));
  return loops;
}

}  // namespace

void append_tracked(std::string& bytes, const TrackedPoses& tracked) {
  append_word(bytes, tracked.tracking ? 1 : 0);
  if (tracked.tracking) {
    append_word(bytes, tracked.tracking->prior);
    append_count(bytes, tracked.tracking->found_later);
    append_count(bytes, tracked.tracking->frames.size());
    for (const TrackedFrame& frame : tracked.tracking->frames) append_frame(bytes, frame);
  }
  append_word(bytes, tracked.loops ? 1 : 0);
  if (tracked.loops) {
    append_word(bytes, tracked.loops->is_corrected ? 1 : 0);
    append_little_endian(bytes, tracked.loops->drift_m);
    append_little_endian(bytes, tracked.loops->largest_correction_m);
    append_count(bytes, tracked.loops->pairs.size());
    for (const LoopResult::Pair& pair : tracked.loops->pairs) append_pair(bytes, pair);
  }
  append_little_endian(bytes, tracked.timing.readout_s);
  append_little_endian(bytes, tracked.timing.colour_later_s);
}

TrackedPoses take_tracked(PlanReader& plan) {
  TrackedPoses tracked;
  if (plan.number<std::uint8_t>() != 0) tracked.tracking = take_tracking(plan);
  if (plan.number<std::uint8_t>() != 0) tracked.loops = take_loops(plan);
  tracked.timing.readout_s = plan.number<double>();
  tracked.timing.colour_later_s = plan.number<double>();
  return tracked;
}

}  // namespace scanknit
