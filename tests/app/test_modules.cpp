// A module that a command needs and does not find is named, with what to install.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/app/module_folder.h"
#include "tests/app/program.h"
#include "tests/app/range_grids.h"
#include "tests/app/volume_files.h"
#include "tests/support/text.h"

namespace scanknit {
namespace {

using test::contains;

/// No module is found.
class MissingModule : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!modules_.is_used()) GTEST_SKIP() << "SKIPPED: the program of a static build finds its modules beside itself";
  }
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  void make_recording() const {
    const Outcome made = scanknit_command(
        {"synth", "desk", "--frames", "3", "--width", "160", "--height", "120", "-o", path("recording"), "--quiet"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
  }
  static void expect_told(const Outcome& outcome, const std::string& file, const std::string& package) {
    EXPECT_EQ(outcome.exit_code, 1);
    for (const std::string& part : {file, std::string("No such file or directory. Install scanknit again"), package}) {
      EXPECT_TRUE(contains(outcome.err, part)) << "no '" << part << "' in\n" << outcome.err;
    }
  }

  TempFolder folder_;
  ModuleFolder modules_;
};

TEST_F(MissingModule, OfVolumeFilesIsTold) {
  write_nrrd({}, folder_ / "ball.nrrd");
  write_meta_image({}, folder_ / "ball.mha");
  write_nifti({}, folder_ / "ball.nii");
  write_dicom_series({}, folder_ / "series");
  for (const char* volume : {"ball.nrrd", "ball.mha", "ball.nii", "series"}) {
    expect_told(modules_.run({"extract", path(volume), "-o", path("ball.ply")}), "libscanknit_volume_files.so",
                "libgdcm3.0");
  }
  write_tiff_stack({}, folder_ / "stack");
  expect_told(modules_.run({"info", path("stack"), "--spacing", "1x1x1"}), "libscanknit_volume_files.so",
              "libopencv-imgcodecs406");
}

TEST_F(MissingModule, OfBoardsIsTold) {
  expect_told(modules_.run({"calibrate", "target", "-o", path("board.pdf")}), "libscanknit_calibrate_opencv.so",
              "libopencv-contrib406");
}

TEST_F(MissingModule, IsNotAskedForByRawSamples) {
  const Ball ball;
  write_raw(ball, folder_ / "ball.raw");
  const Outcome outcome =
      modules_.run({"extract", path("ball.raw"), "--dims", ball.dims_option(), "--type", "uint16", "--spacing",
                    ball.spacing_option(), "--isovalue", kBallIsovalue, "-o", path("ball.ply")});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

TEST_F(MissingModule, OfPcdRecordingsIsToldOnceAndNotForEachFrame) {
  std::filesystem::create_directory(folder_ / "clouds");
  std::ofstream(folder_ / "clouds" / "a.pcd") << "# .PCD v0.7\n";
  expect_told(modules_.run({"run", path("clouds"), "-o", path("out")}), "libscanknit_acquire_pcl.so", "libpcl-io1.13");
}

TEST_F(MissingModule, OfStereoPairsIsTold) {
  make_recording();
  std::filesystem::create_directory(folder_ / "pairs");
  for (const char* side : {"left", "right"}) {
    std::filesystem::copy(folder_ / "recording" / "color", folder_ / "pairs" / side,
                          std::filesystem::copy_options::recursive);
  }
  std::ofstream(folder_ / "pairs" / "stereo.yaml") << "left: {fx: 131, fy: 131, cx: 79.5, cy: 59.5}\nbaseline: 0.06\n";
  expect_told(modules_.run({"run", path("pairs"), "--geometry", "stereo", "-o", path("out")}),
              "libscanknit_stereo_opencv.so", "libopencv-calib3d406");
}

TEST_F(MissingModule, OfTheOutlierFilterIsTold) {
  make_recording();
  expect_told(modules_.run({"run", path("recording"), "-o", path("out"), "--set", "acquire.outlier_neighbours=8"}),
              "libscanknit_acquire_pcl.so", "libpcl-filters1.13");
}

TEST_F(MissingModule, OfAligningIsTold) {
  write_hills(folder_ / "a.ply", 0, Pose::Identity());
  write_hills(folder_ / "b.ply", 0.05, Pose(Eigen::Translation3d(0.3, -0.1, 0.05)));
  expect_told(modules_.run({"align", path("a.ply"), path("b.ply"), "-o", path("out")}), "libscanknit_align_pcl.so",
              "libpcl-features1.13");
}

TEST_F(MissingModule, OfTrackingIsTold) {
  make_recording();
  expect_told(modules_.run({"run", path("recording"), "-o", path("out"), "--poses", "track"}),
              "libscanknit_features_opencv.so", "libopencv-calib3d406");
}

TEST_F(MissingModule, OfGlbFilesIsTold) {
  std::ofstream(folder_ / "a.glb") << "glTF";
  expect_told(modules_.run({"info", path("a.glb")}), "libscanknit_glb_reader.so", "libtinygltf2d");
}

TEST_F(MissingModule, OfTheGroundLeavesThatStepOutAndTheScanIsKept) {
  make_recording();
  const Outcome outcome = modules_.run(
      {"run", path("recording"), "-o", path("out"), "--set", "fusion.voxel_size=8mm", "--set", "finish.ground=remove"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "libscanknit_finish_pcl.so")) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "libpcl-sample-consensus1.13")) << outcome.err;
  const auto report = nlohmann::json::parse(read_text(folder_ / "out" / "report.json"), nullptr, false);
  EXPECT_TRUE(contains(report["finish"]["steps"].dump(), "libscanknit_finish_pcl.so")) << report["finish"];
  EXPECT_TRUE(std::filesystem::is_regular_file(folder_ / "out" / "model.glb"));
}

TEST_F(MissingModule, ThatIsNoLibraryIsToldToo) {
  std::ofstream(modules_ / "libscanknit_volume_files.so") << "no library";
  write_nrrd({}, folder_ / "ball.nrrd");
  const Outcome outcome = modules_.run({"info", path("ball.nrrd")});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_TRUE(contains(outcome.err, "libscanknit_volume_files.so: ")) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "Install scanknit again")) << outcome.err;
}

}  // namespace
}  // namespace scanknit
