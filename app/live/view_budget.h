// ViewBudget: how much of the scan's time may go into the live view.
#pragma once

#include <algorithm>
#include <chrono>

namespace scanknit {

/// A twenty-fifth of the time between frames is earned: what single updates take too long keeps within a twentieth. A
/// pause or a silent scanner earns next to nothing, and no more is saved up than one update of the mesh takes, so that
/// the share holds for any second of the scan on a computer that has nothing else to do. What an update took too long
/// is paid back by the next frames.
class ViewBudget {
 public:
  using Clock = std::chrono::steady_clock;
  static constexpr double kShare = 0.04;

  /// A frame has come.
  void earn(Clock::time_point now) {
    const auto passed = std::clamp(now - last_frame_, Clock::duration::zero(), kLongestGap);
    last_frame_ = now;
    scanned_ += passed;
    credit_ = std::min(credit_ + std::chrono::duration_cast<Clock::duration>(kShare * passed), kMostCredit);
  }
  /// The scan begins, or goes on after a pause: what has passed since the last frame does not count.
  void go_on(Clock::time_point now) { last_frame_ = now; }

  /// Work that takes longer than can be saved up is done when all is saved.
  [[nodiscard]] bool allows(Clock::duration expected) const { return std::min(expected, kMostCredit) <= credit_; }
  void spend(Clock::duration spent) {
    credit_ -= spent;
    spent_ += spent;
  }
  /// What has been spent, of the time in which frames came.
  [[nodiscard]] double share() const {
    return scanned_ > Clock::duration::zero() ? std::chrono::duration<double>(spent_) / scanned_ : 0;
  }

 private:
  static constexpr Clock::duration kLongestGap = std::chrono::milliseconds(500);  // between frames of a slow scan
  static constexpr Clock::duration kMostCredit = std::chrono::milliseconds(50);

  Clock::time_point last_frame_ = Clock::now();
  Clock::duration scanned_{}, credit_{}, spent_{};
};

}  // namespace scanknit
