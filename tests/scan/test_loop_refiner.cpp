#include "scan/refine/loop_refiner.h"

#include <gtest/gtest.h>

#include <memory>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using test::distance_m;
using test::look;
using test::motion;
using test::on_circle;

constexpr double kVoxel_m = 0.02;
constexpr double kNear_m = 0.5 * kVoxel_m;  // of tracked poses without noise

/// Steps of the circle, one for each frame.
using Steps = std::vector<int>;

Steps from_to(int first, int last) {
  Steps steps(static_cast<std::size_t>(last - first + 1));
  std::iota(steps.begin(), steps.end(), first);
  return steps;
}

/// Plays the frames of a walk.
class RoomFrames final : public FrameSource {
 public:
  RoomFrames(Steps steps, std::set<std::size_t> covered) : steps_(std::move(steps)), covered_(std::move(covered)) {}
  [[nodiscard]] const RecordingInfo& info() const override { return info_; }
  [[nodiscard]] FrameEvent next(std::stop_token /*stop*/) override {
    if (next_ == steps_.size()) return EndOfStream{};
    return frame(next_++);
  }
  [[nodiscard]] Frame frame(std::size_t number) const {
    Frame frame = look(covered_.contains(number) ? test::World() : test::small_room(), on_circle(steps_[number]));
    frame.sequence = number;
    frame.timestamp_ns = static_cast<std::int64_t>(number);
    return frame;
  }

 private:
  RecordingInfo info_;
  Steps steps_;
  std::set<std::size_t> covered_;
  std::size_t next_ = 0;
};

/// A walk round the small room, and what tracking made of it.
class RoomWalk {
 public:
  explicit RoomWalk(Steps steps) : steps_(std::move(steps)), T_world_true_(steps_.size(), Pose::Identity()) {}

  RoomWalk& lose(std::size_t first, std::size_t last) { return mark(lost_, first, last); }
  RoomWalk& cover(std::size_t first, std::size_t last) { return mark(covered_, first, last).lose(first, last); }
  RoomWalk& find_later(std::size_t first, std::size_t last) { return mark(found_later_, first, last); }
  /// The frames from `first` on have poses that are wrong by this.
  RoomWalk& misplace(std::size_t first, const Pose& T_world_true) {
    std::fill(T_world_true_.begin() + static_cast<std::ptrdiff_t>(first), T_world_true_.end(), T_world_true);
    return *this;
  }
  /// Each step is wrong by this.
  RoomWalk& drift(const Pose& bias) {
    Pose tracked = truth(0);
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      if (i > 0) tracked = tracked * truth(i - 1).inverse() * truth(i) * bias;
      T_world_true_[i] = tracked * truth(i).inverse();
    }
    return *this;
  }

  [[nodiscard]] Pose truth(std::size_t number) const { return on_circle(steps_[number]); }
  [[nodiscard]] Pose tracked(std::size_t number) const { return T_world_true_[number] * truth(number); }
  [[nodiscard]] FrameArchive archive() const {
    return FrameArchive([this](std::size_t /*every*/) -> Result<std::unique_ptr<FrameSource>> {
      return std::unique_ptr<FrameSource>(std::make_unique<RoomFrames>(steps_, covered_));
    });
  }
  /// Notes the frames that were neither lost nor found later.
  void note_in(LoopRefiner& refiner) const {
    const RoomFrames frames(steps_, covered_);
    bool follows_gap = false;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      if (found_later_.contains(i)) continue;
      if (!lost_.contains(i)) refiner.note_fused(frames.frame(i), tracked(i), follows_gap);
      follows_gap = lost_.contains(i);
    }
  }
  [[nodiscard]] Trajectory trajectory() const {
    Trajectory trajectory;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      if (!lost_.contains(i)) trajectory.push_back({i, static_cast<double>(i), tracked(i)});
    }
    return trajectory;
  }
  [[nodiscard]] TrackingResult tracking() const {
    TrackingResult tracking;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      TrackedFrame frame{.sequence = i, .state = lost_.contains(i) ? TrackState::kLost : TrackState::kOk};
      if (covered_.contains(i)) frame.reason = TrackReason::kNothingSeen;
      tracking.frames.push_back(frame);
    }
    return tracking;
  }

 private:
  RoomWalk& mark(std::set<std::size_t>& frames, std::size_t first, std::size_t last) {
    for (std::size_t i = first; i <= last; ++i) frames.insert(i);
    return *this;
  }

  Steps steps_;
  std::vector<Pose> T_world_true_;
  std::set<std::size_t> lost_, covered_, found_later_;
};

ScanConfig small_config() {
  ScanConfig config;
  config.fusion.voxel_size_m = kVoxel_m;
  return config;
}

/// A LoopRefiner that has seen a walk.
class Refined {
 public:
  explicit Refined(const RoomWalk& walk) : Refined(walk, walk.archive()) {}
  Refined(const RoomWalk& walk, const FrameArchive& archive) : walk_(walk) {
    LoopRefiner refiner(config_, archive, session_);
    walk.note_in(refiner);
    const Trajectory trajectory = walk.trajectory();
    const std::optional<TrackingResult> tracking = walk.tracking();
    auto better = refiner.refine({trajectory, tracking});
    EXPECT_TRUE(better) << better.error().text();
    if (better) trajectory_ = *std::move(better);
    result_ = refiner.result();
  }

  [[nodiscard]] const std::optional<Trajectory>& trajectory() const { return trajectory_; }
  [[nodiscard]] const RefinerResult& result() const { return result_; }
  [[nodiscard]] const std::vector<ScanWarning>& warnings() const { return session_.warnings(); }
  [[nodiscard]] std::vector<std::uint64_t> recovered(TrackReason way) const {
    std::vector<std::uint64_t> frames;
    for (const TrackedFrame& frame : result_.recovered) {
      if (frame.reason == way) frames.push_back(frame.sequence);
    }
    return frames;
  }
  [[nodiscard]] double farthest_m() const {
    double farthest_m = 0;
    for (const PosedFrame& frame : *trajectory_) {
      farthest_m = std::max(farthest_m, distance_m(frame.T_world_camera, walk_.truth(frame.sequence)));
    }
    return farthest_m;
  }

 private:
  const RoomWalk& walk_;
  ScanConfig config_ = small_config();
  ScanObserver observer_;
  ScanSession session_{observer_, {}};
  std::optional<Trajectory> trajectory_;
  RefinerResult result_;
};

std::vector<std::uint64_t> numbers(std::uint64_t first, std::uint64_t last) {
  std::vector<std::uint64_t> all(last - first + 1);
  std::iota(all.begin(), all.end(), first);
  return all;
}

TEST(LoopRefiner, ALostRunInTheMiddleIsFoundWhereBothSidesAgree) {
  const RoomWalk walk = RoomWalk(from_to(0, 39)).lose(15, 24);
  const Refined refined(walk);
  ASSERT_TRUE(refined.trajectory());
  EXPECT_EQ(refined.trajectory()->size(), 40u);
  EXPECT_EQ(refined.recovered(TrackReason::kFoundFromBothSides), numbers(15, 24));
  EXPECT_LT(refined.farthest_m(), kNear_m);
  EXPECT_FALSE(refined.result().loops->is_corrected);
}

RoomWalk torn_walk(int steps) {
  return RoomWalk(from_to(0, steps - 1)).lose(60, 69).misplace(70, motion({0, 0, 0}, {0.1, 0, 0.05}));
}

TEST(LoopRefiner, ALostRunWhoseSidesDisagreeStaysLost) {
  const Refined refined(torn_walk(90));
  EXPECT_TRUE(refined.result().recovered.empty());
}

TEST(LoopRefiner, ALostRunWhoseSidesAgreeOnceALoopIsClosedIsFound) {
  const RoomWalk walk = torn_walk(135);
  const Refined refined(walk);
  ASSERT_TRUE(refined.trajectory());
  EXPECT_EQ(refined.recovered(TrackReason::kFoundFromBothSides), numbers(60, 69));
  EXPECT_LT(refined.farthest_m(), 2 * kNear_m);
}

TEST(LoopRefiner, ALostEndStaysLostWithoutALoop) {
  const Refined refined(RoomWalk(from_to(0, 39)).lose(25, 39));
  EXPECT_FALSE(refined.trajectory());
  EXPECT_TRUE(refined.result().recovered.empty());
}

TEST(LoopRefiner, ALostEndIsJoinedByItsLoop) {
  const RoomWalk walk = RoomWalk(from_to(0, 134)).drift(motion({0, 0.0006, 0}, {0.001, 0, 0})).lose(110, 134);
  const Refined refined(walk);
  ASSERT_TRUE(refined.trajectory());
  const auto joined = refined.recovered(TrackReason::kFoundByLoop);
  ASSERT_FALSE(joined.empty());
  EXPECT_EQ(joined, numbers(110, joined.back()));  // up to the last one that a loop joins
  EXPECT_GE(joined.back(), 120u);
  EXPECT_LT(distance_m(refined.trajectory()->back().T_world_camera, walk.truth(joined.back())),
            0.5 * distance_m(walk.tracked(joined.back()), walk.truth(joined.back())));
}

TEST(LoopRefiner, ALostBeginningIsJoinedByItsLoop) {
  const RoomWalk walk = RoomWalk(from_to(0, 134)).drift(motion({0, 0.0006, 0}, {0.001, 0, 0})).lose(0, 24);
  const Refined refined(walk);
  ASSERT_TRUE(refined.trajectory());
  const auto joined = refined.recovered(TrackReason::kFoundByLoop);
  ASSERT_FALSE(joined.empty());
  EXPECT_EQ(joined, numbers(joined.front(), 24));  // from the first one that a loop joins
  EXPECT_LE(joined.front(), 14u);
}

/// There and back again, all of it lost but the first steps: it meets itself, but nothing that is known.
TEST(LoopRefiner, ALoopWithinALostEndJoinsNothing) {
  Steps steps = from_to(0, 70);
  for (int step = 69; step >= 45; --step) steps.push_back(step);
  const Refined refined(RoomWalk(steps).lose(10, steps.size() - 1));
  EXPECT_TRUE(refined.result().recovered.empty());
  bool has_loop = false;
  for (const LoopResult::Pair& pair : refined.result().loops->pairs) {
    EXPECT_TRUE(!pair.refused.empty() || pair.from >= 10) << pair.from << " to " << pair.to;
    has_loop |= pair.refused.empty();
  }
  EXPECT_TRUE(has_loop) << "the test shows nothing";
}

TEST(LoopRefiner, AFrameFoundLaterMovesWithTheNearerSideOfAGap) {
  // What comes after the gap lies elsewhere in the world: 64 was found from before it, 67 from after it.
  const RoomWalk walk = RoomWalk(from_to(0, 129))
                            .cover(65, 66)
                            .find_later(64, 64)
                            .find_later(67, 67)
                            .misplace(65, motion({0, 0, 0}, {0.1, 0, 0.05}));
  const Refined refined(walk);
  ASSERT_TRUE(refined.trajectory());
  EXPECT_TRUE(refined.result().recovered.empty());
  const PosesBySequence better = poses_of(*refined.trajectory());
  EXPECT_EQ(better.size(), 128u);
  EXPECT_LT(distance_m(better.at(63).inverse() * better.at(68), walk.truth(63).inverse() * walk.truth(68)), kNear_m);
  EXPECT_LT(distance_m(better.at(63).inverse() * better.at(64), walk.truth(63).inverse() * walk.truth(64)), kNear_m);
  EXPECT_LT(distance_m(better.at(67).inverse() * better.at(68), walk.truth(67).inverse() * walk.truth(68)), kNear_m);
}

TEST(LoopRefiner, SaysWhyLostFramesCannotBeLookedForAgain) {
  const RoomWalk walk = RoomWalk(from_to(0, 39)).lose(15, 24);
  const FrameArchive gone([](std::size_t /*every*/) -> Result<std::unique_ptr<FrameSource>> {
    return Error{ErrorCode::kInput, "is not there any more", "walk.mcap"};
  });
  const Refined refined(walk, gone);
  EXPECT_FALSE(refined.trajectory());
  ASSERT_EQ(refined.warnings().size(), 1u);
  EXPECT_EQ(refined.warnings().front().code, WarningCode::kLostNotSearched);
  EXPECT_NE(refined.warnings().front().text.find("walk.mcap"), std::string::npos) << refined.warnings().front().text;
}

/// What LostRunTracker finds of the only run of a walk.
FoundRun track_run(const RoomWalk& walk) {
  const ScanConfig config = small_config();
  const FrameArchive archive = walk.archive();
  const KeyFrames keys(config.fusion.noise);
  const Trajectory trajectory = walk.trajectory();
  const std::optional<TrackingResult> tracking = walk.tracking();
  const std::vector<LostRun> runs = lost_runs({trajectory, tracking});
  EXPECT_EQ(runs.size(), 1u);
  auto found = LostRunTracker(config, archive, keys, {}).track(runs.front());
  EXPECT_TRUE(found) << found.error().text();
  return *std::move(found);
}

std::vector<std::uint64_t> frames_of(const FoundSide& side) {
  std::vector<std::uint64_t> frames;
  for (const FoundFrame& frame : side.frames) frames.push_back(frame.posed.sequence);
  return frames;
}

TEST(LostRuns, AreTrackedFromBothSidesOfWhatShowsNothing) {
  const RoomWalk walk = RoomWalk(from_to(0, 89)).lose(15, 74).cover(30, 54);
  const FoundRun found = track_run(walk);
  EXPECT_EQ(frames_of(found.from_before), numbers(15, 29));
  EXPECT_EQ(frames_of(found.from_after), numbers(55, 74));
  EXPECT_FALSE(found.T_before_after);
  for (const FoundSide* side : {&found.from_before, &found.from_after}) {
    for (const FoundFrame& frame : side->frames) {
      EXPECT_LT(distance_m(frame.posed.T_world_camera, walk.truth(frame.posed.sequence)), kNear_m);
    }
  }
}

TEST(LostRuns, AreTrackedOverAShortCover) {
  const FoundRun found = track_run(RoomWalk(from_to(0, 39)).lose(15, 24).cover(18, 19));
  EXPECT_EQ(frames_of(found.from_before), (std::vector<std::uint64_t>{15, 16, 17, 20, 21, 22, 23, 24}));
  ASSERT_TRUE(found.T_before_after);
  EXPECT_LT(distance_m(*found.T_before_after, on_circle(14).inverse() * on_circle(25)), kNear_m);
}

TEST(LostRuns, AtTheBeginningHaveOneSide) {
  const FoundRun found = track_run(RoomWalk(from_to(0, 59)).lose(0, 39));
  EXPECT_TRUE(found.from_before.frames.empty());
  EXPECT_EQ(frames_of(found.from_after), numbers(0, 39));  // more than are in memory at a time
  EXPECT_FALSE(found.T_before_after);
}

TEST(LostRuns, ThatShowNothingAreNoRuns) {
  const RoomWalk walk = RoomWalk(from_to(0, 9)).cover(4, 6);
  const Trajectory trajectory = walk.trajectory();
  const std::optional<TrackingResult> tracking = walk.tracking();
  EXPECT_TRUE(lost_runs({trajectory, tracking}).empty());
}

TEST(LostRuns, AreHeldOnlyWhereBothSidesAgree) {
  FoundRun found{{{}, KeyFrames(NoiseModel{})}, {{}, KeyFrames(NoiseModel{})}, std::nullopt};
  EXPECT_FALSE(found.is_held_by(on_circle(0), on_circle(9)));
  found.T_before_after = on_circle(0).inverse() * on_circle(9);
  EXPECT_TRUE(found.is_held_by(on_circle(0), on_circle(9)));
  EXPECT_TRUE(found.is_held_by(on_circle(0), motion({0, 0, 0}, {0.01, 0, 0}) * on_circle(9)));
  EXPECT_FALSE(found.is_held_by(on_circle(0), motion({0, 0, 0}, {0.02, 0, 0}) * on_circle(9)));
  EXPECT_FALSE(found.is_held_by(on_circle(0), on_circle(9) * motion({0, 0.02, 0}, {0, 0, 0})));
}

}  // namespace
}  // namespace scanknit
