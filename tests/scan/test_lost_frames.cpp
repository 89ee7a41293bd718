#include "scan/lost_frames.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <set>
#include <string>
#include <vector>

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
      const auto met =
          frames[i] == 'k' ? search.meet_known({Pose::Identity(), frame.timestamp_ns}) : search.meet_lost(frame);
      EXPECT_TRUE(met);
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

TEST(LostFrames, ThatShowNothingKnownStayLost) {
  EXPECT_EQ(Walk(0).find("k" + std::string(100, '.') + "k"), Frames());
}

}  // namespace
}  // namespace scanknit
