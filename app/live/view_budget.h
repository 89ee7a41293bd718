// ViewBudget: limits the share of the scan's time that the live view takes.
#pragma once

#include <algorithm>
#include <chrono>

namespace scanknit {

/// The view earns 1/25 of the time between frames; with updates that take longer than expected it stays below 1/20. A
/// pause or a silent scanner earns almost nothing, and at most one update of the mesh can be saved up, so that the
/// share holds for any second of the scan on an otherwise idle computer. When an update takes too long, the next frames
/// have no update until the share holds again.
class ViewBudget {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr double kShare = 0.04;

  /// To be called for each frame.
  void earn(Clock::time_point now) {
    const auto passed = std::clamp(now - last_frame_, Clock::duration::zero(), kLongestGap);
    last_frame_ = now;
    scanned_ += passed;
    credit_ = std::min(credit_ + std::chrono::duration_cast<Clock::duration>(kShare * passed), kMostCredit);
  }
  /// To be called when the scan begins, or goes on after a pause: the time since the last frame does not count.
  void go_on(Clock::time_point now) { last_frame_ = now; }

  /// True when the credit covers work that takes `expected`. For work longer than the largest credit, that credit is
  /// enough.
  [[nodiscard]] bool allows(Clock::duration expected) const { return std::min(expected, kMostCredit) <= credit_; }
  void spend(Clock::duration spent) {
    credit_ -= spent;
    spent_ += spent;
  }
  /// Time spent on the view / time in which frames came.
  [[nodiscard]] double share() const {
    return scanned_ > Clock::duration::zero() ? std::chrono::duration<double>(spent_) / scanned_ : 0;
  }

 private:
  static constexpr Clock::duration kLongestGap = std::chrono::milliseconds(500);  // one frame earns for at most this
  static constexpr Clock::duration kMostCredit = std::chrono::milliseconds(50);

  Clock::time_point last_frame_ = Clock::now();
  Clock::duration scanned_{}, credit_{}, spent_{};
};

}  // namespace scanknit
