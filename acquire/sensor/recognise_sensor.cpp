#include "acquire/sensor/recognise_sensor.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/median.h"

namespace scanknit {
namespace {

struct NamedModel {
  std::string_view name;
  SensorModel model;
};

constexpr std::array kDevices = {NamedModel{"RealSense D41", SensorModel::kRealsenseD400},
                                 NamedModel{"RealSense D43", SensorModel::kRealsenseD400},
                                 NamedModel{"RealSense D45", SensorModel::kRealsenseD400},
                                 NamedModel{"Kinect for Xbox 360", SensorModel::kKinectV1},
                                 NamedModel{"Kinect for Windows v1", SensorModel::kKinectV1},
                                 NamedModel{"Xtion", SensorModel::kKinectV1},
                                 NamedModel{"Carmine", SensorModel::kKinectV1},
                                 NamedModel{"PS1080", SensorModel::kKinectV1}};

constexpr std::array kDataSets = {
    NamedModel{"freiburg1", SensorModel::kTumFreiburg1}, NamedModel{"fr1", SensorModel::kTumFreiburg1},
    NamedModel{"freiburg2", SensorModel::kTumFreiburg2}, NamedModel{"fr2", SensorModel::kTumFreiburg2},
    NamedModel{"freiburg3", SensorModel::kTumFreiburg3}, NamedModel{"fr3", SensorModel::kTumFreiburg3}};

constexpr std::array<std::string_view, 4> kPhoneFormats = {"phone-lidar", "stray-scanner", "arkitscenes", "polycam"};

/// "rgbd_dataset_freiburg1_desk": rgbd, dataset, freiburg1, desk.
std::vector<std::string> words_of(const std::string& name) {
  std::vector<std::string> words(1);
  for (const char c : name) {
    const auto letter = static_cast<unsigned char>(c);
    if (std::isalnum(letter) != 0) {
      words.back() += static_cast<char>(std::tolower(letter));
    } else if (!words.back().empty()) {
      words.emplace_back();
    }
  }
  return words;
}

std::optional<RecognisedSensor> tum_camera(const std::filesystem::path& folder) {
  std::error_code code;
  std::filesystem::path place = std::filesystem::absolute(folder, code).lexically_normal();
  constexpr int kLevels = 3;  // the folder, and two above: data sets are unpacked into folders of their name
  for (int level = 0; level < kLevels; place = place.parent_path()) {
    if (!place.has_filename() && place != place.root_path()) continue;  // "folder/"
    ++level;
    for (const std::string& word : words_of(place.filename().string())) {
      for (const NamedModel& set : kDataSets) {
        if (word == set.name) return RecognisedSensor{set.model, fmt::format("its folder's name has '{}'", set.name)};
      }
    }
  }
  return std::nullopt;
}

/// The whole millimetres that occur, ascending: drivers deliver those, even where files have finer units.
std::vector<int> occurring_mm(const DepthImage& depth_m) {
  constexpr int kMost_mm = 1 << 16;
  std::vector<std::uint8_t> occurs(kMost_mm);
  for (const float z : depth_m.pixels()) {
    const float mm = std::round(z * 1000);
    if (mm > 0 && mm < kMost_mm) occurs[static_cast<std::size_t>(mm)] = 1;
  }
  std::vector<int> depths_mm;
  for (int mm = 0; mm < kMost_mm; ++mm) {
    if (occurs[static_cast<std::size_t>(mm)] != 0) depths_mm.push_back(mm);
  }
  return depths_mm;
}

/// Two depths that occur, and none between them.
struct Gap {
  double near_m, far_m;

  [[nodiscard]] double step_per_m() const { return 1 / near_m - 1 / far_m; }
  /// Both ends were rounded, some files' twice.
  [[nodiscard]] bool is_of(double step_per_m, int steps) const {
    constexpr double kRounding_m = 0.00125;
    constexpr double kTolerance = 0.05;  // of the step, which is a median
    const double expected_m = steps * step_per_m * near_m * far_m;
    return std::abs(far_m - near_m - expected_m) <= kRounding_m + kTolerance * expected_m;
  }
};

/// The gaps that the rounding to millimetres leaves recognisable.
std::vector<Gap> clear_gaps(const DepthImage& depth_m) {
  constexpr int kLeast_mm = 4;
  const std::vector<int> depths_mm = occurring_mm(depth_m);
  std::vector<Gap> gaps;
  for (std::size_t i = 1; i < depths_mm.size(); ++i) {
    if (depths_mm[i] - depths_mm[i - 1] >= kLeast_mm) gaps.push_back({depths_mm[i - 1] / 1e3, depths_mm[i] / 1e3});
  }
  return gaps;
}

double median_step_per_m(const std::vector<Gap>& gaps) {
  std::vector<double> steps;
  for (const Gap& gap : gaps) steps.push_back(gap.step_per_m());
  return median(std::move(steps));
}

/// A sensor by the size of its steps and by its focal length in heights of the picture.
struct StepModel {
  SensorModel model;
  double least_step, most_step;    ///< 1/m
  double least_focal, most_focal;  ///< in heights of the picture
  const char* steps;
};

// Kinect v1: 1/8 pixel of a camera of 580 pixels with a baseline of 75 mm is 0.00287; its colour camera, to which depth
// may be registered, has 517 to 535 pixels at 640 x 480, the infrared one 570 to 595. D400: 1/32 pixel of 380 (640 x
// 480) to 945 pixels (D415, 1280 x 720) with 50 to 95 mm is 0.0005 to 0.0017; depth registered to colour has colour's
// camera.
constexpr std::array kStepModels = {
    StepModel{SensorModel::kKinectV1, 0.0027, 0.0032, 1.0, 1.3, "1/8 pixel of a Kinect's disparity"},
    StepModel{SensorModel::kRealsenseD400, 0.00045, 0.0021, 0.75, 1.4, "1/32 pixel of a RealSense's disparity"}};

}  // namespace

std::optional<RecognisedSensor> sensor_by_name(const RecordingNames& names) {
  for (const NamedModel& device : kDevices) {
    if (names.device.find(device.name) == std::string_view::npos) continue;
    return RecognisedSensor{device.model, fmt::format("it calls itself '{}'", names.device)};
  }
  if (std::find(kPhoneFormats.begin(), kPhoneFormats.end(), names.format) != kPhoneFormats.end()) {
    return RecognisedSensor{SensorModel::kPhoneLidar, "it is a phone's export"};
  }
  if (names.format == "tum") return tum_camera(names.folder);
  return std::nullopt;
}

std::optional<RecognisedSensor> sensor_by_depth(const DepthImage& depth_m, const CameraIntrinsics& camera) {
  const auto step = disparity_step_per_m(depth_m);
  if (!step || camera.height <= 0) return std::nullopt;
  const double focal = std::abs(camera.fy) / camera.height;
  for (const StepModel& known : kStepModels) {
    const bool fits = *step >= known.least_step && *step <= known.most_step && focal >= known.least_focal &&
                      focal <= known.most_focal;
    if (fits) return RecognisedSensor{known.model, fmt::format("its depth lies on steps of {}", known.steps), true};
  }
  return std::nullopt;
}

std::optional<double> disparity_step_per_m(const DepthImage& depth_m) {
  constexpr std::size_t kFewestGaps = 16;
  constexpr double kLeastSpan = 1.4;  // over it a step in 1/z doubles in z: constant steps in z are told apart
  constexpr int kMostSteps = 4;       // depths in between did not happen to occur
  // Kinects show 1.00 of both, a D435i 0.88 and 0.95, half floats of a phone 0.67 and 0.82.
  constexpr double kSingleShare = 0.75, kExplainedShare = 0.9;

  const std::vector<Gap> gaps = clear_gaps(depth_m);
  if (gaps.size() < kFewestGaps) return std::nullopt;
  const double step_per_m = median_step_per_m(gaps);
  std::vector<Gap> single;
  std::size_t explained = 0;
  for (const Gap& gap : gaps) {
    int steps = 1;
    while (steps <= kMostSteps && !gap.is_of(step_per_m, steps)) ++steps;
    if (steps == 1) single.push_back(gap);
    if (steps <= kMostSteps) ++explained;
  }
  const auto share = [&](std::size_t part) { return static_cast<double>(part) / static_cast<double>(gaps.size()); };
  if (share(single.size()) < kSingleShare || share(explained) < kExplainedShare) return std::nullopt;
  if (single.back().near_m < kLeastSpan * single.front().near_m) return std::nullopt;
  return step_per_m;
}

}  // namespace scanknit
