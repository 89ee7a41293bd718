// The calls that make a mesh of recordings, with an observer, as a program that embeds them sees them.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "fusion/volume/tsdf_volume.h"
#include "scan/align/align.h"
#include "scan/checks/memory_share.h"
#include "scan/scan.h"
#include "synth/scene/scene.h"
#include "synth/write_recording.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFrames = 12;

/// Keeps what the scan tells it, and ends the frames after `most_frames`.
class Witness final : public ScanObserver {
 public:
  explicit Witness(std::size_t most_frames = kFrames + 1) : most_frames_(most_frames) {}

  void on_warning(const ScanWarning& warning) override { warnings.push_back(warning.text); }
  Result<void> on_open(const RecordingInfo& info) override {
    events.push_back("open " + std::to_string(info.frames));
    return {};
  }
  Result<void> on_begin(const ScanState&) override {
    events.emplace_back("begin");
    fused = 0;
    return {};
  }
  void on_frame(const Frame&, const std::optional<Pose>& T_world_camera, const ScanState& scan) override {
    if (T_world_camera) ++fused;
    EXPECT_EQ(scan.frames.fused, fused);
  }
  void on_phase(const ScanState& scan) override {
    if (scan.phase == ScanPhase::kWriting) events.emplace_back("write");
  }
  std::optional<ScanCommand> next_command(std::stop_token, std::chrono::nanoseconds) override {
    if (fused < most_frames_) return std::nullopt;
    return ScanCommand{ScanCommand::Kind::kFinish};
  }

  void on_tracked_mesh(const ScanState& scan) override {
    ++tracked_meshes;
    blocks_after_mesh = scan.volume.blocks();
  }
  bool needs_volume_after_mesh() const override { return needs_volume; }
  void on_refined(const ScanState&) override { ++refined; }

  std::size_t fused = 0, tracked_meshes = 0, refined = 0, blocks_after_mesh = 0;
  bool needs_volume = true;
  std::vector<std::string> events, warnings;

 private:
  std::size_t most_frames_;
};

/// A recording of a desk with known poses; the depth picture of frame 3 is damaged if `is_damaged`.
class WholeScan : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("scanknit_whole_scan_" + std::to_string(::getpid()));
    ASSERT_NO_FATAL_FAILURE(record(kFrames));
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Once round the desk in that many frames.
  void record(std::size_t frames_a_round) const {
    SynthConfig config;
    config.frames = static_cast<int>(frames_a_round);
    config.intrinsics = {160, 120, 131.25, 131.25, 79.5, 59.5};
    const auto scene = make_scene("desk");
    ASSERT_TRUE(scene);
    ASSERT_TRUE(write_synthetic_recording(**scene, config, recording()));
  }
  [[nodiscard]] fs::path recording() const { return folder_ / "recording"; }
  [[nodiscard]] fs::path mesh() const { return folder_ / "out" / "model.ply"; }
  [[nodiscard]] std::string bytes_of_mesh() const {
    std::ifstream file(mesh(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void damage_frame_3() const { std::ofstream(recording() / "depth" / "000003.png") << "no picture"; }

  [[nodiscard]] ScanJob job() const {
    ScanJob job;
    job.input = recording();
    job.config.fusion.voxel_size_m = 0.02;
    job.files.meshes = {mesh()};
    return job;
  }

 private:
  fs::path folder_;
};

std::vector<std::string> texts_of(const std::vector<ScanWarning>& warnings) {
  std::vector<std::string> texts;
  for (const ScanWarning& warning : warnings) texts.push_back(warning.text);
  return texts;
}

TEST_F(WholeScan, IsSeenByItsObserverFromTheFirstFrameToTheFile) {
  Witness witness;
  const ScanResult result = scan_recording(job(), witness);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  EXPECT_EQ(witness.events, (std::vector<std::string>{"open 12", "begin", "write"}));
  EXPECT_EQ(witness.fused, kFrames);
  EXPECT_EQ(result.frames.fused, kFrames);
  EXPECT_EQ(result.trajectory.size(), kFrames);
  EXPECT_EQ(result.files.at("ply"), mesh().string());
  EXPECT_GT(fs::file_size(mesh()), 1000u);
  EXPECT_EQ(texts_of(result.warnings), witness.warnings);
}

TEST_F(WholeScan, FreesItsVolumeBeforeTheMeshIsFinishedUnlessTheObserverNeedsIt) {
  ScanJob finished = job();
  finished.config.finish.smooth_steps = 2;
  std::vector<std::string> meshes;
  for (const bool needs_volume : {true, false}) {
    Witness witness;
    witness.needs_volume = needs_volume;
    const ScanResult result = scan_recording(finished, witness);
    ASSERT_TRUE(result.outcome) << result.outcome.error().text();
    ASSERT_EQ(witness.tracked_meshes, 1u);
    EXPECT_EQ(witness.blocks_after_mesh, needs_volume ? result.volume.blocks : 0u);
    EXPECT_GT(result.volume.blocks, 0u);  // the report is about the volume that was fused
    std::ifstream file(mesh(), std::ios::binary);
    meshes.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  }
  EXPECT_GT(meshes[0].size(), 1000u);
  EXPECT_TRUE(meshes[0] == meshes[1]);
}

TEST_F(WholeScan, EndsAtItsObserversCommand) {
  Witness witness(5);
  const ScanResult result = scan_recording(job(), witness);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  EXPECT_EQ(result.frames.fused, 5u);
  EXPECT_TRUE(fs::exists(mesh()));
}

TEST_F(WholeScan, LeavesNoMeshWhenItIsStoppedBeforeTheFirstFrame) {
  Witness witness;
  std::stop_source stop;
  stop.request_stop();
  const ScanResult result = scan_recording(job(), witness, stop.get_token());
  EXPECT_FALSE(result.outcome);
  EXPECT_EQ(witness.fused, 0u);
  EXPECT_FALSE(fs::exists(mesh()));
}

TEST_F(WholeScan, SaysWhichFrameIsDamagedInItsResultAndToItsObserver) {
  damage_frame_3();
  Witness witness;
  const ScanResult result = scan_recording(job(), witness);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  EXPECT_EQ(result.frames.fused, kFrames - 1);
  EXPECT_EQ(result.frames.dropped, 1u);
  ASSERT_EQ(result.frames.drop_messages.size(), 1u);
  EXPECT_NE(result.frames.drop_messages[0].find("000003.png"), std::string::npos);
  EXPECT_NE(find_warning(result, WarningCode::kFramesDropped), nullptr);
  EXPECT_EQ(texts_of(result.warnings), witness.warnings);
}

TEST_F(WholeScan, SaysEachWarningOnceThoughTheFramesAreReadTwice) {
  ASSERT_NO_FATAL_FAILURE(record(10 * kFrames));  // slowly enough to be tracked
  damage_frame_3();
  ScanJob twice = job();
  twice.config.acquire.to = kFrames - 1;
  twice.config.acquire.poses = PoseMode::kTrack;
  twice.config.fusion.loop_closure = true;
  twice.config.turntable.is_enabled = true;  // there is none: the frames are read again, as a walk that may have loops
  Witness witness;
  const ScanResult result = scan_recording(twice, witness);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  EXPECT_EQ(std::count(witness.events.begin(), witness.events.end(), "begin"), 2);
  EXPECT_NE(find_warning(result, WarningCode::kNoTurntable), nullptr);
  EXPECT_NE(find_warning(result, WarningCode::kFramesDropped), nullptr);
  std::vector<std::string> texts = texts_of(result.warnings);
  std::sort(texts.begin(), texts.end());
  EXPECT_EQ(std::adjacent_find(texts.begin(), texts.end()), texts.end());
}

TEST_F(WholeScan, WritesTheMeshOfAClosedWalkTwiceOnlyIfTwoVolumesDoNotFitIntoTheBudget) {
  constexpr std::size_t kRound = 10 * kFrames;
  ASSERT_NO_FATAL_FAILURE(record(kRound));
  ScanJob walk = job();
  walk.config.acquire.poses = PoseMode::kTrack;
  Witness roomy(kRound + 1), tight(kRound + 1);
  const ScanResult once = scan_recording(walk, roomy);
  ASSERT_TRUE(once.outcome) << once.outcome.error().text();
  ASSERT_EQ(roomy.refined, 1u) << "no loop was closed";
  EXPECT_EQ(roomy.tracked_meshes, 0u);
  const std::string mesh_of_once = bytes_of_mesh();

  walk.config.fusion.memory_budget_mib = kProgramMib + static_cast<std::size_t>(1.5 * once.volume.memory_mib);
  const ScanResult twice = scan_recording(walk, tight);
  ASSERT_TRUE(twice.outcome) << twice.outcome.error().text();
  EXPECT_EQ(tight.refined, 1u);
  EXPECT_EQ(tight.tracked_meshes, 1u);
  EXPECT_EQ(bytes_of_mesh(), mesh_of_once);
}

std::size_t files_in(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST_F(WholeScan, InBricksIsTheSameMesh) {
  ScanJob whole = job();
  whole.config.fusion.bricks = BrickSize::kOff;
  whole.config.extract.min_component_triangles = 50;
  Witness witness;
  ASSERT_TRUE(scan_recording(whole, witness).outcome);
  const std::string mesh_of_whole = bytes_of_mesh();
  for (const BrickSize size : {BrickSize::k64, BrickSize::k128}) {
    fs::remove(mesh());
    ScanJob in_bricks = whole;
    in_bricks.config.fusion.bricks = size;
    const ScanResult result = scan_recording(in_bricks, witness);
    ASSERT_TRUE(result.outcome) << result.outcome.error().text();
    EXPECT_EQ(result.frames.fused, kFrames);
    EXPECT_EQ(bytes_of_mesh(), mesh_of_whole);
    EXPECT_EQ(files_in(mesh().parent_path()), 1u) << "parts of the volume are left";
  }
}

TEST_F(WholeScan, LargerThanItsBudgetIsFusedInBricks) {
  ScanJob roomy = job();
  roomy.config.fusion.voxel_size_m = 0.006;
  Witness witness;
  const ScanResult whole = scan_recording(roomy, witness);
  ASSERT_TRUE(whole.outcome) << whole.outcome.error().text();
  const std::string mesh_of_whole = bytes_of_mesh();
  fs::remove(mesh());

  ScanJob tight = roomy;
  const auto volume_mib = static_cast<std::size_t>(0.7 * whole.volume.memory_mib);
  ASSERT_GE(volume_mib, kLeastMemoryBudgetMib);
  while (volume_budget_mib(tight.config.fusion.memory_budget_mib) > volume_mib) --tight.config.fusion.memory_budget_mib;
  tight.config.fusion.bricks = BrickSize::kOff;
  const ScanResult refused = scan_recording(tight, witness);
  ASSERT_FALSE(refused.outcome);
  EXPECT_EQ(refused.outcome.error().code, ErrorCode::kBudget);
  EXPECT_FALSE(fs::exists(mesh()));

  tight.config.fusion.bricks = BrickSize::kAuto;
  const ScanResult in_bricks = scan_recording(tight, witness);
  ASSERT_TRUE(in_bricks.outcome) << in_bricks.outcome.error().text();
  EXPECT_EQ(bytes_of_mesh(), mesh_of_whole);
  EXPECT_EQ(files_in(mesh().parent_path()), 1u) << "parts of the volume are left";
}

TEST_F(WholeScan, InBricksNeedsKnownPoses) {
  ScanJob tracked = job();
  tracked.config.acquire.poses = PoseMode::kTrack;
  tracked.config.fusion.bricks = BrickSize::k128;
  Witness witness;
  const ScanResult result = scan_recording(tracked, witness);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  EXPECT_NE(find_warning(result, WarningCode::kNoEffect), nullptr);
}

TEST_F(WholeScan, OfSeveralRecordingsKeepsWhatEachSaysOfItsFrames) {
  damage_frame_3();
  Witness witness;
  const ScanResult result = align_and_mesh(job(), {.inputs = {recording(), recording()}, .known = {}}, witness);
  ASSERT_TRUE(result.outcome) << result.outcome.error().text();
  EXPECT_EQ(result.frames.dropped, 2u);
  std::size_t with_reason = 0;
  for (const auto& [reason, count] : result.frames.dropped_by_reason) with_reason += count;
  EXPECT_EQ(with_reason, 2u);
  EXPECT_EQ(result.frames.drop_messages.size(), 2u);
  EXPECT_NE(find_warning(result, WarningCode::kFramesDropped), nullptr);
  EXPECT_EQ(texts_of(result.warnings), witness.warnings);
}

}  // namespace
}  // namespace scanknit
