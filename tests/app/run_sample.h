// A run whose report has every part.
#pragma once

#include "app/report/run.h"
#include "tests/export/export_samples.h"

namespace scanknit::test {

inline CommandRun sample_run() {
  CommandRun run;
  run.status = "ok";
  run.total_ms = 125'000;
  run.peak_rss_mib = 300;
  ScanResult& scan = run.scan;
  scan.input = "recordings/desk";
  scan.frames = {1234, 1200, 30, 4, {{"no_pose", 30}}, {"frame-000003.pose.txt: no such file"}};
  scan.losses = LossCounters{.device = 7};
  scan.warnings = {{WarningCode::kScanner, "no data for 333 ms"}, {WarningCode::kFramesDropped, "30 frames dropped"}};
  scan.tracking = TrackingResult{PosePrior::kIgnore,
                                 {{0, TrackState::kOk, TrackReason::kNone, 0, 0, 0, 900, 0},
                                  {1, TrackState::kOk, TrackReason::kNone, 0.9, 0.8, 1, 900, 0},
                                  {2, TrackState::kLost, TrackReason::kTooFast, 0.2, 0.1, 3, 900, 0}}};
  scan.loops = LoopResult{true, 0.2, 0.1, {{4, 90, 0.2, 0.5, 0.9, ""}}};
  TurntableResult& table = scan.turntable.emplace();
  table.is_refined = true;
  table.axis_direction = {0, -1, 0};
  table.turns = 1.02;
  table.disc_m = -0.12;
  table.angles_rad = {{0, 0.0}, {1, 0.05}};
  scan.stages["integrate"].samples_ms = {2000, 500};
  scan.volume = {1000, 20, 1.5, 0.004, false};
  scan.mesh.isovalue = 300;
  scan.mesh.isovalue_source = IsovalueSource::kOtsu;
  scan.mesh.cases = CaseCounts{.sub_cases = {{0, "0", 90}, {3, "3A", 2}}, .ambiguous_faces_joined = 3};
  scan.mesh.finish = FinishResult{{{FinishStep::kPieces, "", {{"pieces_removed", 3}, {"area_removed_mm2", 12.5}}},
                                   {FinishStep::kGround, "no plane was found", {}}},
                                  Pose::Identity()};
  scan.mesh.check = check_mesh(cube());
  scan.mesh.holes = HolesResult{2, 0.3, {0.2, 0.1}};
  scan.mesh.fit = FitResult{24, 0.9, 0.0011, 0.004, 0.005, 20};
  scan.texture = TextureResult{"", 1924, 1020, 0.0008, 31, 600'000, 0.993, 120, 1'500'000};
  scan.files = {{"glb", "out/model.glb"}};
  scan.config.fusion.voxel_size_m = 0.004;
  return run;
}

}  // namespace scanknit::test
