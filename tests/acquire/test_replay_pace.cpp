// The pace of a replay, by a clock that only moves when it is told to.
#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

#include "acquire/replay/paced_source.h"

namespace scanknit::test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// Frames 0, 1, 2 ... a hundred milliseconds apart; of some nothing can be used.
class Metronome final : public FrameSource {
 public:
  explicit Metronome(std::uint64_t count, bool has_clock = true, std::set<std::uint64_t> unusable = {})
      : count_(count), has_clock_(has_clock), unusable_(std::move(unusable)) {}
  [[nodiscard]] const RecordingInfo& info() const override { return info_; }
  [[nodiscard]] FrameEvent next(std::stop_token) override {
    if (next_ == count_) return EndOfStream{};
    if (unusable_.contains(next_)) return FrameDropped{next_++, DropReason::kNoDepth, {}};
    Frame frame;
    frame.sequence = next_;
    frame.has_clock = has_clock_;
    frame.timestamp_ns =
        has_clock_ ? 7'000'000'000 + static_cast<std::int64_t>(next_) * 100'000'000 : static_cast<std::int64_t>(next_);
    ++next_;
    return frame;
  }

 private:
  RecordingInfo info_;
  std::uint64_t count_, next_ = 0;
  bool has_clock_;
  std::set<std::uint64_t> unusable_;
};

class Paced : public ::testing::Test {
 protected:
  [[nodiscard]] PaceControl control() {
    return {.now = [this] { return now_; },
            .wait_until = [this](Clock::time_point due, const std::stop_token&) { now_ = std::max(now_, due); },
            .wait_for_step =
                [this](const std::stop_token&, std::chrono::milliseconds patience) {
                  if (steps_ > 0) return --steps_, Step::kTaken;
                  if (has_ended_) return Step::kNoMore;
                  now_ += patience;
                  return Step::kNotYet;
                }};
  }
  void open(Pace pace, std::uint64_t count, bool has_clock = true, std::set<std::uint64_t> unusable = {}) {
    source_ = paced(std::make_unique<Metronome>(count, has_clock, std::move(unusable)), pace, control());
  }
  // The number of the next frame; -1: dropped, -2: the end.
  int next() {
    const FrameEvent event = source_->next({});
    if (const auto* frame = std::get_if<Frame>(&event)) return static_cast<int>(frame->sequence);
    return std::holds_alternative<FrameDropped>(event) ? -1 : -2;
  }
  [[nodiscard]] std::chrono::milliseconds spent() const {
    return std::chrono::duration_cast<std::chrono::milliseconds>(now_ - begin_);
  }

  Clock::time_point begin_{}, now_{};
  int steps_ = 0;
  bool has_ended_ = false;  // no more steps will come
  std::unique_ptr<FrameSource> source_;
};

TEST_F(Paced, RealtimeHandsFramesOutWhenTheyWereTaken) {
  open(Pace::kRealtime, 4);
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(next(), i);
    EXPECT_EQ(spent(), i * 100ms);
  }
  EXPECT_EQ(next(), -2);
}

TEST_F(Paced, RealtimeGivesASlowReaderEveryFrame) {
  open(Pace::kRealtime, 6);
  EXPECT_EQ(next(), 0);
  now_ += 350ms;
  for (int i = 1; i <= 3; ++i) {
    EXPECT_EQ(next(), i);
    EXPECT_EQ(spent(), 350ms) << "what is late is handed out at once";
  }
  EXPECT_EQ(next(), 4);
  EXPECT_EQ(spent(), 400ms) << "and then the clock is kept again";
  EXPECT_EQ(next(), 5);
  EXPECT_EQ(next(), -2);
}

TEST_F(Paced, RealtimeTakesItsTimeOverFramesThatCannotBeUsed) {
  open(Pace::kRealtime, 8, true, {0, 3, 4, 7});
  EXPECT_EQ(next(), -1);
  EXPECT_EQ(spent(), 0ms) << "nothing is known of time yet";
  EXPECT_EQ(next(), 1);
  for (int i = 1; i < 6; ++i) {
    EXPECT_EQ(next(), i == 2 || i == 3 ? -1 : i + 1);
    EXPECT_EQ(spent(), i * 100ms);
  }
  EXPECT_EQ(next(), -1);
  EXPECT_EQ(spent(), 600ms);
  EXPECT_EQ(next(), -2);
}

TEST_F(Paced, RealtimeWithoutAClockIsThirtyFramesASecond) {
  open(Pace::kRealtime, 4, false);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(next(), i);
  EXPECT_EQ(spent(), 99ms);
}

TEST_F(Paced, SteppedGivesAFrameForEachStep) {
  open(Pace::kStepped, 9);
  steps_ = 2;
  has_ended_ = true;
  EXPECT_EQ(next(), 0);
  EXPECT_EQ(next(), 1);
  EXPECT_EQ(next(), -2);
}

TEST_F(Paced, WaitingForAStepEndsWithItsPatienceAndTakesNone) {
  open(Pace::kStepped, 9);
  EXPECT_FALSE(source_->wait({}, 50ms));
  EXPECT_EQ(spent(), 50ms);
  steps_ = 1;
  EXPECT_TRUE(source_->wait({}, 50ms));
  EXPECT_TRUE(source_->wait({}, 50ms)) << "the same step still";
  EXPECT_EQ(next(), 0);
  EXPECT_FALSE(source_->wait({}, 50ms));
}

TEST_F(Paced, WaitingForTheClockEndsWithItsPatienceAndLosesNoFrame) {
  open(Pace::kRealtime, 2);
  EXPECT_TRUE(source_->wait({}, 30ms)) << "the first sets the clock";
  EXPECT_EQ(next(), 0);
  EXPECT_FALSE(source_->wait({}, 30ms));
  EXPECT_EQ(spent(), 30ms);
  EXPECT_TRUE(source_->wait({}, 1s));
  EXPECT_EQ(spent(), 100ms);
  EXPECT_EQ(next(), 1);
  EXPECT_EQ(next(), -2);
}

TEST_F(Paced, FastWaitsForNothing) {
  open(Pace::kFast, 3);
  EXPECT_TRUE(source_->wait({}, 1h));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(next(), i);
  EXPECT_EQ(spent(), 0ms);
}

TEST(SteadyPace, StopsWaitingWhenStopped) {
  const PaceControl control = steady_pace_control();
  std::stop_source source;
  source.request_stop();
  const auto begin = control.now();
  control.wait_until(begin + 1h, source.get_token());
  EXPECT_LT(control.now() - begin, 10min);
}

}  // namespace
}  // namespace scanknit::test
