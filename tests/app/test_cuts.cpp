// Scans with frames cut out anywhere: the camera may be lost and found again, but is never taken for being elsewhere.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <vector>

#include "fusion/integrate/integrate.h"
#include "fusion/track/model_tracker.h"
#include "tests/app/small_scan.h"

namespace scanknit {
namespace {

constexpr double kVoxel_m = 0.02;
constexpr int kFrames = 120;  // the desk: 3 degrees and 5 cm apart; the room: 12 cm
constexpr int kFirstCut = 10;
constexpr int kLastCut = 100;

struct Found {
  TrackState state = TrackState::kLost;
  double error_m = 0;
};

class Cuts : public ::testing::TestWithParam<std::tuple<const char*, bool>> {
 protected:
  void SetUp() override {
    config_.voxel_size_m = kVoxel_m;
    frames_ = test::small_scan(std::get<0>(GetParam()), kFrames, kFrames, config_.noise);
    ASSERT_EQ(frames_.size(), std::size_t{kFrames});
  }

  /// The first frame after a cut whose pose `tracker` believes to know, of six.
  [[nodiscard]] Found find_after(std::size_t first, std::size_t cut, ModelTracker tracker,
                                 const TsdfVolume& volume) const {
    constexpr std::size_t kPatience = 6;
    for (std::size_t i = first + cut; i < std::min(first + cut + kPatience, frames_.size()); ++i) {
      Frame frame = frames_[i];
      if (!has_clock()) frame.timestamp_ns = frames_[i - cut].timestamp_ns;
      const TrackResult result = tracker.track(frame, volume);
      if (result.is_lost()) continue;
      return {result.state, (result.T_world_camera.translation() - frame.T_world_camera->translation()).norm()};
    }
    return {};
  }

  /// Without a clock nothing tells of the cut but what is seen.
  [[nodiscard]] static bool has_clock() { return std::get<1>(GetParam()); }

  /// Half of those that were found when this was written; the others look where little or nothing has been scanned.
  [[nodiscard]] static int least_found() {
    if (std::string(std::get<0>(GetParam())) == "desk") return 7;
    return has_clock() ? 5 : 1;
  }

  FusionConfig config_;
  std::vector<Frame> frames_;
};

TEST_P(Cuts, NeverLeadToAWrongPlace) {
  auto volume = TsdfVolume::create(config_);
  ASSERT_TRUE(volume);
  ModelTracker tracker({});
  int found = 0, tried = 0;
  for (std::size_t i = 0; i <= kLastCut; ++i) {
    for (const std::size_t cut : {5u, 8u, 20u, 40u}) {
      if (i < kFirstCut || i % 15 != 0) continue;
      const Found after = find_after(i, cut, tracker, *volume);
      // Tracking without any cut ends up to a voxel from the truth here.
      EXPECT_LT(after.error_m, 1.5 * kVoxel_m) << cut << " frames cut from " << i << ": " << to_string(after.state);
      ++tried;
      found += after.state == TrackState::kLost ? 0 : 1;
    }
    const TrackResult result = tracker.track(frames_[i], *volume);
    ASSERT_EQ(result.state, TrackState::kOk) << "frame " << i << ": " << to_string(result.reason);
    ASSERT_TRUE(integrate(frames_[i], result.T_world_camera, *volume));
  }
  EXPECT_EQ(tried, 24);
  EXPECT_GE(found, least_found());
}

INSTANTIATE_TEST_SUITE_P(Scenes, Cuts, ::testing::Combine(::testing::Values("desk", "room"), ::testing::Bool()),
                         [](const auto& scan) {
                           return std::string(std::get<0>(scan.param)) +
                                  (std::get<1>(scan.param) ? "WithAClock" : "WithoutAClock");
                         });

}  // namespace
}  // namespace scanknit
