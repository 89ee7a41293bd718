// FrameIntake: which frames a scan is made of, and what becomes of the others.
#include "scan/frames/frame_intake.h"

#include <gtest/gtest.h>

#include <deque>
#include <utility>

#include "scan/frames/only_frames.h"

namespace scanknit {
namespace {

FrameEvent frame(std::uint64_t sequence) {
  Frame made;
  made.sequence = sequence;
  return made;
}

FrameEvent dropped(std::uint64_t sequence) {
  return FrameDropped{sequence, DropReason::kQueue, {ErrorCode::kInput, "a newer frame was there already"}};
}

class Listed final : public FrameSource {
 public:
  explicit Listed(std::deque<FrameEvent> events) : events_(std::move(events)) { info_.poses = PoseMode::kTrack; }
  [[nodiscard]] const RecordingInfo& info() const override { return info_; }
  [[nodiscard]] FrameEvent next(std::stop_token /*stop*/) override {
    if (events_.empty()) return EndOfStream{};
    FrameEvent event = std::move(events_.front());
    events_.pop_front();
    return event;
  }

 private:
  std::deque<FrameEvent> events_;
  RecordingInfo info_;
};

class FrameIntakeTest : public testing::Test {
 protected:
  explicit FrameIntakeTest(std::deque<FrameEvent> events = {frame(1), frame(4), dropped(2), dropped(3), frame(7),
                                                            dropped(5), dropped(6), frame(8)})
      : source(std::move(events)), session(observer, {}), intake(source, config, session, {}) {}

  void take(int events) {
    for (int i = 0; i < events; ++i) (void)intake.next();
  }
  [[nodiscard]] std::vector<std::uint64_t> taken() const {
    std::vector<std::uint64_t> numbers;
    for (std::uint64_t i = 0; i < 20; ++i) {
      if (intake.taken().contains(i)) numbers.push_back(i);
    }
    return numbers;
  }

  Listed source;
  AcquireConfig config;
  ScanObserver observer;
  ScanSession session;
  FrameIntake intake;
};

using Numbers = std::vector<std::uint64_t>;

TEST_F(FrameIntakeTest, TakesAllThatComesAndWhatGaveWayToIt) {
  take(8);
  EXPECT_EQ(taken(), (Numbers{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(intake.left_out().read, 0u);
  EXPECT_EQ(intake.counts().read, 8u);
  EXPECT_EQ(intake.counts().dropped_by_reason.at("queue"), 4u);
}

TEST_F(FrameIntakeTest, WhatIsPassedOverIsLeftOutAndWhatGaveWayToIt) {
  take(4);
  intake.skip_frame("paused");
  take(3);
  EXPECT_EQ(taken(), (Numbers{1, 2, 3, 4, 8}));
  EXPECT_EQ(intake.left_out().read, 3u);
  EXPECT_EQ(intake.left_out().dropped, 3u);
  EXPECT_EQ(intake.left_out().dropped_by_reason.at("paused"), 1u);
  EXPECT_EQ(intake.left_out().dropped_by_reason.at("queue"), 2u);
  EXPECT_EQ(intake.counts().dropped, 5u);
}

TEST_F(FrameIntakeTest, WhatCameBeforeABeginningIsLeftOutAndWhatGaveWayToIt) {
  take(2);
  intake.start_over();
  take(6);
  EXPECT_EQ(taken(), (Numbers{5, 6, 7, 8}));
  EXPECT_EQ(intake.left_out().read, 4u);
  EXPECT_EQ(intake.counts().read, 8u);
}

TEST_F(FrameIntakeTest, ThoseThatWereTakenCanBeReadAgain) {
  take(4);
  intake.skip_frame("paused");
  take(3);
  std::deque<FrameEvent> recorded;
  for (std::uint64_t i = 0; i < 12; ++i) recorded.push_back(frame(i));
  OnlyFrames again(std::make_unique<Listed>(std::move(recorded)), intake.taken());
  Numbers read;
  for (FrameEvent event = again.next({}); std::holds_alternative<Frame>(event); event = again.next({})) {
    read.push_back(std::get<Frame>(event).sequence);
  }
  EXPECT_EQ(read, (Numbers{1, 2, 3, 4, 8}));
}

/// Frames 0 to 99 of a recording.
class Skipping final : public SkippingSource {
 public:
  explicit Skipping(std::vector<std::uint64_t>& read) : read_(read) {}
  [[nodiscard]] const RecordingInfo& info() const override { return info_; }
  [[nodiscard]] FrameEvent next(std::stop_token /*stop*/) override {
    if (next_ == 100) return EndOfStream{};
    read_.push_back(next_);
    return frame(next_++);
  }
  void skip_until(const std::function<bool(std::uint64_t sequence)>& is_wanted) override {
    while (next_ < 100 && !is_wanted(next_)) ++next_;
  }

 private:
  std::vector<std::uint64_t>& read_;
  RecordingInfo info_;
  std::uint64_t next_ = 0;
};

TEST(OnlyFramesTest, OthersAreNotReadWhereTheSourceCanPassOverThem) {
  SequenceRanges wanted;
  for (const std::uint64_t sequence : {20, 21, 22, 70}) {
    if (sequence == 70) wanted.cut();
    wanted.add(sequence);
  }
  std::vector<std::uint64_t> read, given;
  OnlyFrames only(std::make_unique<Skipping>(read), wanted);
  for (FrameEvent event = only.next({}); std::holds_alternative<Frame>(event); event = only.next({})) {
    given.push_back(std::get<Frame>(event).sequence);
  }
  EXPECT_EQ(given, (std::vector<std::uint64_t>{20, 21, 22, 70}));
  EXPECT_EQ(read, (std::vector<std::uint64_t>{20, 21, 22, 70, 71})) << "the one behind them tells that they are over";
}

}  // namespace
}  // namespace scanknit
