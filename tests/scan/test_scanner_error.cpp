// acquire.camera over a whole scan: a sensor with a systematic error, calibrated in one place, scans another.
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Dense>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "acquire/sensor/depth_bias.h"
#include "export/mesh/read_mesh.h"
#include "scan/scan.h"
#include "synth/surface_error.h"
#include "synth/synthetic_source.h"
#include "synth/write_recording.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// 3 % too far or too near at 4 m, growing with the square of the distance, in waves over the picture.
SynthConfig biased_scanner(double share = 0.03) {
  SynthConfig config;
  config.intrinsics = {160, 120, 131.25, 131.25, 79.5, 59.5};
  config.sensor = make_sensor("ideal").value();
  config.sensor->bias = {.share = share, .cells = 3};
  config.truth_points = 1000;
  return config;
}

/// Least squares of a field over the picture: numbers of B-splines from what single pixels say of it.
class FieldFit {
 public:
  static constexpr int kColumns = 15, kRows = 12, kNumbers = kColumns * kRows;

  void add(double across, double down, double value) {
    const SplineWeights x = spline_weights(across, kColumns);
    const SplineWeights y = spline_weights(down, kRows);
    Eigen::VectorXd row = Eigen::VectorXd::Zero(kNumbers);
    for (int k = 0; k < 16; ++k) {
      row[(y.first + k / 4) * kColumns + x.first + k % 4] =
          y.weights[static_cast<std::size_t>(k / 4)] * x.weights[static_cast<std::size_t>(k % 4)];
    }
    normal_.selfadjointView<Eigen::Lower>().rankUpdate(row);
    right_ += value * row;
  }
  [[nodiscard]] std::vector<double> numbers() const {
    const Eigen::VectorXd solved = normal_.selfadjointView<Eigen::Lower>().ldlt().solve(right_);
    return {solved.begin(), solved.end()};
  }

 private:
  Eigen::MatrixXd normal_ = 1e-6 * Eigen::MatrixXd::Identity(kNumbers, kNumbers);  // for numbers that no pixel tells
  Eigen::VectorXd right_ = Eigen::VectorXd::Zero(kNumbers);
};

/// The shift by which the depth of a room differs from the true one: a calibration from known surfaces.
DepthBias shift_seen_in_room(SynthConfig config) {
  config.frames = 60;
  const auto room = make_scene("room");
  EXPECT_TRUE(room);
  const SyntheticScanner scanner(**room, config);
  FieldFit fit;
  for (const std::size_t picture : {0u, 20u, 40u}) {
    const Shot shot = scanner.shoot(picture);
    const DepthImage& found_m = shot.depth_m;
    for (int i = 0; i < found_m.width() * found_m.height(); i += 7) {
      const int x = i % found_m.width(), y = i / found_m.width();
      const auto z = static_cast<double>(shot.exact.depth_m.at(x, y));
      const auto measured = static_cast<double>(found_m.at(x, y));
      if (!(z > 0) || !(measured > 0)) continue;
      fit.add(spline_position(x, found_m.width()), spline_position(y, found_m.height()), 1 / z - 1 / measured);
    }
  }
  return {FieldFit::kColumns, FieldFit::kRows, std::vector<double>(FieldFit::kNumbers, 0), fit.numbers()};
}

class ScannerError : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("scanknit_scanner_error_" + std::to_string(::getpid()));
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Scans the desk and measures its mesh: the mean distance of its vertices from the surface.
  [[nodiscard]] double error_m(SynthConfig scanner, std::shared_ptr<const ScannerCamera> camera) const {
    scanner.frames = 20;
    const auto desk = make_scene("desk");
    EXPECT_TRUE(desk && write_synthetic_recording(**desk, scanner, folder_ / "desk"));
    ScanJob job;
    job.input = folder_ / "desk";
    job.config.acquire.camera = std::move(camera);
    job.config.acquire.max_depth_m = 3;
    job.config.fusion.voxel_size_m = 0.01;
    job.files.meshes = {folder_ / "model.ply"};
    ScanObserver nobody;
    const ScanResult result = scan_recording(job, nobody);
    EXPECT_TRUE(result.outcome) << result.outcome.error().text();
    const auto mesh = read_mesh(folder_ / "model.ply");
    EXPECT_TRUE(mesh);
    if (!mesh) return 0;
    const auto error = measure_surface(*mesh, folder_ / "desk");
    EXPECT_TRUE(error);
    return error ? error->vertices.mean_m : 0;
  }

 private:
  fs::path folder_;
};

TEST_F(ScannerError, IsTakenOutOfTheMesh) {
  const double without_m = error_m(biased_scanner(), nullptr);
  ScannerCamera camera;
  camera.depth = CameraModel{biased_scanner().intrinsics, {}};
  camera.depth_bias = shift_seen_in_room(biased_scanner());
  const double with_m = error_m(biased_scanner(), std::make_shared<const ScannerCamera>(camera));
  const double faultless_m = error_m(biased_scanner(0), nullptr);
  RecordProperty("without_mm", std::to_string(1000 * without_m));
  RecordProperty("with_mm", std::to_string(1000 * with_m));
  RecordProperty("faultless_mm", std::to_string(1000 * faultless_m));
  EXPECT_LT(with_m, without_m / 5);
  EXPECT_LT(with_m, 1.5 * faultless_m) << "what is left is that of the voxels";
}

}  // namespace
}  // namespace scanknit
