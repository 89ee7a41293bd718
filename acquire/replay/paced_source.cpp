#include "acquire/replay/paced_source.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <utility>
#include <variant>

namespace scanknit {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::int64_t kPeriod_ns = 33'333'333;  // of recordings without a clock, whose stamps count frames
constexpr std::chrono::milliseconds kPatience{100};
constexpr Clock::duration kLongestPeriod = std::chrono::seconds(1);

class SteppedSource final : public FrameSource {
 public:
  SteppedSource(std::unique_ptr<FrameSource> source, PaceControl control)
      : source_(std::move(source)), control_(std::move(control)) {}

  [[nodiscard]] const RecordingInfo& info() const override { return source_->info(); }

  [[nodiscard]] FrameEvent next(std::stop_token stop) override {
    while (!wait(stop, kPatience)) {
    }
    if (std::exchange(step_, Step::kNotYet) == Step::kNoMore) return EndOfStream{};
    return source_->next(stop);
  }

  [[nodiscard]] bool wait(std::stop_token stop, std::chrono::milliseconds patience) override {
    if (step_ == Step::kNotYet) step_ = control_.wait_for_step(stop, patience);
    return step_ != Step::kNotYet;
  }

 private:
  std::unique_ptr<FrameSource> source_;
  PaceControl control_;
  Step step_ = Step::kNotYet;  ///< that next() has not answered yet
};

class RealtimeSource final : public FrameSource {
 public:
  RealtimeSource(std::unique_ptr<FrameSource> source, PaceControl control)
      : source_(std::move(source)), control_(std::move(control)) {}

  [[nodiscard]] const RecordingInfo& info() const override { return source_->info(); }

  [[nodiscard]] FrameEvent next(std::stop_token stop) override {
    look_ahead(stop);
    if (due_at_) control_.wait_until(*due_at_, stop);
    FrameEvent event = *std::move(ahead_);
    ahead_.reset();
    return event;
  }

  [[nodiscard]] bool wait(std::stop_token stop, std::chrono::milliseconds patience) override {
    look_ahead(stop);
    if (!due_at_) return true;
    control_.wait_until(std::min(*due_at_, control_.now() + patience), stop);
    return stop.stop_requested() || control_.now() >= *due_at_;
  }

 private:
  void look_ahead(const std::stop_token& stop) {
    if (ahead_) return;
    ahead_ = source_->next(stop);
    due_at_.reset();
    if (const auto* frame = std::get_if<Frame>(&*ahead_)) {
      due_at_ = due_at(*frame);
      if (last_due_at_) period_ = std::clamp(*due_at_ - *last_due_at_, Clock::duration::zero(), kLongestPeriod);
    } else if (last_due_at_ && std::holds_alternative<FrameDropped>(*ahead_)) {
      due_at_ = *last_due_at_ + period_;  // it has no time of its own
    }
    if (due_at_) last_due_at_ = due_at_;
  }

  [[nodiscard]] Clock::time_point due_at(const Frame& frame) {
    const std::int64_t time_ns = frame.has_clock ? frame.timestamp_ns : frame.timestamp_ns * kPeriod_ns;
    if (!begin_) begin_ = Begin{control_.now(), time_ns};
    // Recorded stamps ascend but may jump by more than 64 bits hold.
    std::int64_t since_ns = 0;
    if (__builtin_sub_overflow(time_ns, begin_->time_ns, &since_ns)) return begin_->at;
    return begin_->at + std::chrono::nanoseconds(since_ns);
  }

  struct Begin {
    Clock::time_point at;
    std::int64_t time_ns;
  };

  std::unique_ptr<FrameSource> source_;
  PaceControl control_;
  std::optional<Begin> begin_;
  std::optional<FrameEvent> ahead_;          ///< read, but not asked for yet
  std::optional<Clock::time_point> due_at_;  ///< of the frame that it is
  std::optional<Clock::time_point> last_due_at_;
  Clock::duration period_ = std::chrono::nanoseconds(kPeriod_ns);  ///< between the last two frames
};

}  // namespace

PaceControl steady_pace_control() {
  return {
      .now = [] { return Clock::now(); },
      .wait_until =
          [](Clock::time_point due, const std::stop_token& stop) {
            std::mutex mutex;
            std::condition_variable_any never;
            std::unique_lock lock(mutex);
            (void)never.wait_until(lock, stop, due, [&] { return stop.stop_requested(); });
          },
      .wait_for_step = [](const std::stop_token& stop,
                          std::chrono::milliseconds) { return stop.stop_requested() ? Step::kNoMore : Step::kTaken; }};
}

std::unique_ptr<FrameSource> paced(std::unique_ptr<FrameSource> source, Pace pace, PaceControl control) {
  if (pace == Pace::kRealtime) return std::make_unique<RealtimeSource>(std::move(source), std::move(control));
  if (pace == Pace::kStepped) return std::make_unique<SteppedSource>(std::move(source), std::move(control));
  return source;
}

}  // namespace scanknit
