#include "scan/lost_frames.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "scan/passes.h"
#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

/// A walk in which frame n is found from a neighbour not more than `reach` frames away, or by what it looks like.
class Walk {
 public:
  explicit Walk(std::int64_t reach) : reach_(reach) {}

  Walk& looks_known(std::set<std::int64_t> frames) {
    looks_known_ = std::move(frames);
    return *this;
  }

  /// 'k': known, '.': lost. Returns the frames that were found, in the order in which they were fused.
  std::vector<std::int64_t> find(const std::string& frames) {
    std::vector<std::int64_t> found;
    LostFrames search(
        {[&](Frame& frame, const std::optional<KnownFrame>& neighbour) { return track(frame, neighbour); },
         [&](Frame& frame, const TrackResult& /*result*/) {
           found.push_back(frame.timestamp_ns);
           return Result<void>();
         }});
    for (std::size_t i = 0; i < frames.size(); ++i) {
      Frame frame;
      frame.timestamp_ns = static_cast<std::int64_t>(i);
      const auto added = frames[i] == 'k' ? search.add_known_frame({Pose::Identity(), frame.timestamp_ns})
                                          : search.add_lost_frame(frame);
      EXPECT_TRUE(added);
    }
    return found;
  }

 private:
  Result<TrackResult> track(const Frame& frame, const std::optional<KnownFrame>& neighbour) const {
    TrackResult result;
    const bool is_near = neighbour && std::abs(frame.timestamp_ns - neighbour->timestamp_ns) <= reach_;
    const bool is_known = !neighbour && looks_known_.contains(frame.timestamp_ns);
    if (is_near || is_known) result.state = TrackState::kRecovered;
    return result;
  }

  std::int64_t reach_;
  std::set<std::int64_t> looks_known_;
};

using Frames = std::vector<std::int64_t>;

TEST(LostFrames, AreFoundFromTheFrameBeforeThem) {
  EXPECT_EQ(Walk(1).find("kk..k"), (Frames{2, 3}));
}

TEST(LostFrames, AreFoundFromTheFrameAfterThem) {
  EXPECT_EQ(Walk(0).find("k...k"), Frames());
  EXPECT_EQ(Walk(1).find("...k"), (Frames{2, 1, 0}));
}

TEST(LostFrames, AreFoundInTheMiddleWhereThreeInARowShowAKnownPlace) {
  const std::string far_from_all = "k" + std::string(60, '.');
  EXPECT_EQ(Walk(0).looks_known({20}).find(far_from_all), Frames());
  const Frames found = Walk(1).looks_known({20}).find("." + std::string(22, '.') + "..");
  EXPECT_EQ((Frames{found.begin(), found.begin() + 3}), (Frames{20, 21, 22}));
  EXPECT_EQ(found.size(), 25u);  // back to the first, and on to the last
}

/// Frames of a walk, of which some show nothing.
class CoveredWalk final : public FrameSource {
 public:
  CoveredWalk() { info_.poses = PoseMode::kTrack; }
  [[nodiscard]] const RecordingInfo& info() const override { return info_; }
  [[nodiscard]] FrameEvent next(std::stop_token /*stop*/) override {
    if (next_ == 12) return EndOfStream{};
    const bool is_covered = next_ >= 5 && next_ < 7;
    Frame frame = test::look(is_covered ? test::World() : test::small_room(), test::on_circle(next_));
    frame.sequence = static_cast<std::uint64_t>(next_);
    frame.timestamp_ns = ++next_;
    return frame;
  }

 private:
  RecordingInfo info_;
  int next_ = 0;
};

TEST(LostFrames, ThatCannotBeReadAgainCostNothingElse) {
  ScanJob job;
  job.config.fusion.voxel_size_m = 0.02;
  CoveredWalk walk;
  const FrameArchive gone([](std::size_t /*every*/) -> Result<std::unique_ptr<FrameSource>> {
    return Error{ErrorCode::kInput, "is not there any more", "walk.mcap"};
  });
  ScanObserver observer;
  ScanSession session(observer, {});
  const PassResult made = scan_walk(job, {.source = walk, .archive = gone}, session);
  EXPECT_TRUE(made.scan.outcome) << made.scan.outcome.error().text();
  EXPECT_EQ(made.scan.frames.fused, 10u);
  EXPECT_EQ(made.scan.frames.lost, 2u);
  ASSERT_TRUE(made.scan.mesh.check);
  EXPECT_GT(made.scan.mesh.check->triangles, 1000u);
  const auto warnings = session.warnings();
  ASSERT_FALSE(warnings.empty());
  EXPECT_EQ(warnings.front().code, WarningCode::kLostNotSearched);
  EXPECT_NE(warnings.front().text.find("walk.mcap"), std::string::npos) << warnings.front().text;
}

TEST(LostFrames, ThatShowNothingKnownStayLost) {
  EXPECT_EQ(Walk(0).find("k" + std::string(100, '.') + "k"), Frames());
}

}  // namespace
}  // namespace scanknit
