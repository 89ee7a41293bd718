// Which settings are warned of because they change none of the files.
#include "scan/checks/settings_check.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace scanknit {
namespace {

using Texts = std::vector<std::string>;

Texts warnings_of(const ScanJob& job) {
  ScanObserver observer;
  ScanSession session(observer, {});
  warn_of_settings(job, session);
  Texts texts;
  for (const ScanWarning& warning : session.warnings()) {
    EXPECT_EQ(warning.code, WarningCode::kNoEffect);
    texts.push_back(warning.text);
  }
  return texts;
}

ScanJob job_with(Watertight watertight) {
  ScanJob job;
  job.files.meshes = {"model.glb"};
  job.config.finish.watertight = watertight;
  return job;
}

TEST(SettingsCheck, AMaxHoleThatIsAskedForIsWarnedOfWhateverItsValue) {
  for (const double max_hole_m : {FinishConfig{}.max_hole_m, 0.021}) {
    ScanJob job = job_with(Watertight::kFull);
    job.config.finish.max_hole_m = max_hole_m;
    job.asked_keys = {"finish.max_hole", "finish.watertight"};
    EXPECT_EQ(warnings_of(job),
              Texts{"finish.max_hole has no effect because finish.watertight: full closes every hole"});
    job.config.finish.watertight = Watertight::kOff;
    EXPECT_EQ(warnings_of(job), Texts{"finish.max_hole has no effect because finish.watertight is off"});
    job.config.finish.watertight = Watertight::kSmall;
    EXPECT_EQ(warnings_of(job), Texts{});
  }
}

TEST(SettingsCheck, AMaxHoleThatIsNotAskedForIsNotWarnedOf) {
  for (const Watertight watertight : {Watertight::kOff, Watertight::kFull}) {
    EXPECT_EQ(warnings_of(job_with(watertight)), Texts{});
  }
}

TEST(SettingsCheck, AMaterialThatIsAskedForIsWarnedOfWithoutAGlb) {
  ScanJob job = job_with(Watertight::kOff);
  job.asked_keys = {"export.material"};
  EXPECT_EQ(warnings_of(job), Texts{});
  job.files.meshes = {"model.ply"};
  EXPECT_EQ(warnings_of(job), Texts{"export.material has no effect because no GLB file is written"});
}

TEST(SettingsCheck, SettingsWithTheSameReasonShareASentence) {
  ScanJob job = job_with(Watertight::kOff);
  job.files.meshes = {"model.stl"};
  job.config.output.quantize = true;
  job.config.output.compress = true;
  job.config.output.texture = TextureFormat::kPng;
  job.config.finish.ground_clearance_m = 0.01;
  job.config.finish.invented_colour = Rgb8{255, 0, 0};
  job.asked_keys = {"finish.max_hole"};
  EXPECT_EQ(warnings_of(job),
            (Texts{"export.quantize, export.compress and export.texture have no effect because no GLB file is written",
                   "finish.ground_clearance has no effect because finish.ground is keep",
                   "finish.max_hole and finish.mark_invented have no effect because finish.watertight is off"}));
}

}  // namespace
}  // namespace scanknit
