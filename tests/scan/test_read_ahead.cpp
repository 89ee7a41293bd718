// ReadAhead: the same events in the same order, however fast either side is.
#include "scan/frames/read_ahead.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <variant>
#include <vector>

namespace scanknit {
namespace {

using namespace std::chrono_literals;

constexpr std::uint64_t kFrames = 20;

/// Frames 0 to 19, of which the eighth is dropped; then `last`, or an exception.
class Numbered final : public FrameSource {
 public:
  explicit Numbered(std::atomic<std::uint64_t>& read, std::optional<FrameEvent> last = EndOfStream{})
      : read_(read), last_(std::move(last)) {}
  [[nodiscard]] const RecordingInfo& info() const override { return info_; }
  [[nodiscard]] FrameEvent next(std::stop_token /*stop*/) override {
    const std::uint64_t number = read_++;
    if (number == kFrames && !last_) throw std::runtime_error("no memory");
    if (number >= kFrames) return *last_;
    if (number == 7) return FrameDropped{number, DropReason::kUnreadable, {ErrorCode::kInput, "damaged"}};
    Frame frame;
    frame.sequence = number;
    return frame;
  }

 private:
  std::atomic<std::uint64_t>& read_;
  std::optional<FrameEvent> last_;
  RecordingInfo info_;
};

class ReadAheadTest : public testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<FrameSource> numbered(std::optional<FrameEvent> last = EndOfStream{}) {
    return std::make_unique<Numbered>(read, std::move(last));
  }
  static void take_all(ReadAhead& ahead) {
    for (std::uint64_t i = 0; i < kFrames; ++i) {
      const FrameEvent event = ahead.next({});
      ASSERT_EQ(std::holds_alternative<FrameDropped>(event), i == 7);
      if (i != 7) {
        ASSERT_EQ(std::get<Frame>(event).sequence, i);
      }
    }
  }

  std::atomic<std::uint64_t> read = 0;
};

TEST_F(ReadAheadTest, GivesEachEventInItsOrderAndThenTheEnd) {
  ReadAhead ahead(numbered());
  take_all(ahead);
  EXPECT_TRUE(std::holds_alternative<EndOfStream>(ahead.next({})));
  EXPECT_TRUE(std::holds_alternative<EndOfStream>(ahead.next({})));
}

TEST_F(ReadAheadTest, GivesAnErrorAfterTheFramesBeforeIt) {
  ReadAhead ahead(numbered(Error{ErrorCode::kInput, "torn"}));
  take_all(ahead);
  const FrameEvent last = ahead.next({});
  ASSERT_TRUE(std::holds_alternative<Error>(last));
  EXPECT_EQ(std::get<Error>(last).message, "torn");
  EXPECT_TRUE(std::holds_alternative<EndOfStream>(ahead.next({})));
}

TEST_F(ReadAheadTest, ThrowsWhatTheSourceThrew) {
  ReadAhead ahead(numbered(std::nullopt));
  take_all(ahead);
  EXPECT_THROW((void)ahead.next({}), std::runtime_error);
}

TEST_F(ReadAheadTest, ReadsNoMoreThanAFewFramesAhead) {
  ReadAhead ahead(numbered());
  ASSERT_TRUE(std::holds_alternative<Frame>(ahead.next({})));
  constexpr std::uint64_t kMost = ReadAhead::kFramesAhead + 1;
  for (int i = 0; i < 1000 && read < kMost; ++i) std::this_thread::sleep_for(1ms);
  EXPECT_EQ(read, kMost);
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(read, kMost);
}

TEST_F(ReadAheadTest, AStopRequestEndsTheFrames) {
  ReadAhead ahead(numbered());
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(std::holds_alternative<EndOfStream>(ahead.next(stop.get_token())));
}

TEST_F(ReadAheadTest, OneThreadReadsWhenItIsAsked) {
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const auto source = read_ahead(numbered());
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(read, 0);
}

}  // namespace
}  // namespace scanknit
