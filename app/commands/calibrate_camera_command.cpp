#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "app/calibrate/calibrate_arguments.h"
#include "app/calibrate/camera_file.h"
#include "app/calibrate/found_views.h"
#include "app/calibrate/target_file.h"
#include "app/exit_codes.h"
#include "app/terminal/signals.h"
#include "calibrate/board/board_pictures.h"
#include "calibrate/calibrate_camera.h"
#include "calibrate/depth/measure_depth.h"
#include "core/files/atomic_file.h"
#include "core/rotation.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

Json model_json(const CameraModel& model) {
  const CameraIntrinsics& k = model.intrinsics;
  return {{"width", k.width},
          {"height", k.height},
          {"fx", k.fx},
          {"fy", k.fy},
          {"cx", k.cx},
          {"cy", k.cy},
          {"distortion", model.distortion}};
}

/// What was measured and is in the file; null for what is not.
Json depth_json(const MeasuredDepth& measured, const ScannerCamera& cameras) {
  const DepthCalibration& fit = measured.fit;
  Json deviations = Json::array();
  for (const DepthDeviation& at : fit.deviations) {
    deviations.push_back({{"distance_m", at.distance_m}, {"deviation_m", at.deviation_m}});
  }
  Json json = {{"views", fit.views},
               {"nearest_m", fit.nearest_m},
               {"farthest_m", fit.farthest_m},
               {"error_before_m", fit.before_m},
               {"error_after_m", fit.after_m},
               {"depth_bias", nullptr},
               {"time_offset_ms", nullptr},
               {"T_colour_depth", nullptr},
               {"not_measured", measured.unknown}};
  if (cameras.depth_bias) json["depth_bias"] = {{"standard_deviations", deviations}};
  if (cameras.colour_later_s) {
    json["time_offset_ms"] = {{"value", 1000 * *cameras.colour_later_s},
                              {"standard_deviation", 1000 * fit.colour_later_deviation_s}};
  }
  if (cameras.T_colour_depth) {
    const Eigen::Vector3d& t = cameras.T_colour_depth->translation();
    const Eigen::Quaterniond q(cameras.T_colour_depth->linear());
    json["T_colour_depth"] = {{"value", {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}},
                              {"standard_deviation_m", fit.correction_deviation.head<3>().norm()},
                              {"standard_deviation_rad", fit.correction_deviation.tail<3>().norm()}};
  }
  return json;
}

std::string depth_text(const MeasuredDepth& measured, const ScannerCamera& cameras) {
  const DepthCalibration& fit = measured.fit;
  std::string text;
  if (cameras.depth_bias) {
    text += fmt::format("Depth    {:.2f} mm from the board before, {:.2f} mm after (median; {:.2f} to {:.2f} m);",
                        1000 * fit.before_m, 1000 * fit.after_m, fit.nearest_m, fit.farthest_m);
    for (const DepthDeviation& at : fit.deviations) {
      text += fmt::format(" +- {:.1f} mm at {:.0f} m", 1000 * at.deviation_m, at.distance_m);
    }
    text += "\n";
  }
  if (cameras.colour_later_s) {
    text += fmt::format("Time     colour is taken {:.1f} +- {:.2g} ms after depth\n", 1000 * *cameras.colour_later_s,
                        1000 * fit.colour_later_deviation_s);
  }
  if (cameras.T_colour_depth) {
    const Eigen::Vector3d t_mm = 1000 * cameras.T_colour_depth->translation();
    text +=
        fmt::format("Pose     depth is at {:.1f} {:.1f} {:.1f} mm in the colour camera, +- {:.2g} mm, {:.2g} degrees\n",
                    t_mm.x(), t_mm.y(), t_mm.z(), 1000 * fit.correction_deviation.head<3>().norm(),
                    fit.correction_deviation.tail<3>().norm() / kDegree);
  }
  return text;
}

Json summary_json(const CameraCalibration& calibration, const ScannerCamera& cameras, const FoundViews& found,
                  const std::string& output) {
  Json views = Json::array();
  for (const UsedView& view : calibration.views) {
    views.push_back({{"picture", view.picture}, {"corners", view.corners}, {"error_px", view.error_px}});
  }
  Json deviation = model_json(calibration.deviation);
  deviation.erase("width");
  deviation.erase("height");
  const auto camera = [](const std::optional<CameraModel>& model) {
    return model ? model_json(*model) : Json(nullptr);
  };
  return {
      {"output", output},
      {"colour", camera(cameras.colour)},
      {"depth", camera(cameras.depth)},
      {"standard_deviation", deviation},
      {"error_px", calibration.error_px},
      {"noise_px", calibration.noise_px},
      {"covered_share", calibration.covered},
      {"views_with_board", found.views.size()},
      {"views_left_out",
       {{"blurred", calibration.blurred}, {"outlying", calibration.outlying}, {"redundant", calibration.redundant}}},
      {"outlying_corners", calibration.outlying_corners},
      {"views", views}};
}

std::string summary_text(const CameraCalibration& calibration, const FoundViews& found, std::size_t pictures) {
  const CameraIntrinsics& k = calibration.camera.intrinsics;
  const CameraIntrinsics& sigma = calibration.deviation.intrinsics;
  return fmt::format(
      "Board    seen in {} of {} pictures; {} used, {} blurred, {} outlying, {} that tell nothing new\n"
      "Camera   {} x {}: fx {:.2f} +- {:.2f}, fy {:.2f} +- {:.2f}, cx {:.2f} +- {:.2f}, cy {:.2f} +- {:.2f}\n"
      "Lens     k1 k2 p1 p2 k3: {:.4f} +- {:.2g}\n"
      "Error    {:.3f} pixels from {} corners (root mean square); they cover {:.0f} % of the picture\n",
      found.views.size(), pictures, calibration.views.size(), calibration.blurred, calibration.outlying,
      calibration.redundant, k.width, k.height, k.fx, sigma.fx, k.fy, sigma.fy, k.cx, sigma.cx, k.cy, sigma.cy,
      fmt::join(calibration.camera.distortion, " "), fmt::join(calibration.deviation.distortion, " "),
      calibration.error_px, calibration.corners, 100 * calibration.covered);
}

void warn_of_gaps(const CameraCalibration& calibration, const BoardPictures& pictures, Console& console) {
  constexpr double kEnoughCovered = 0.8;
  if (calibration.covered < kEnoughCovered) {
    console.warn(
        fmt::format("no corner was seen in {:.0f} % of the picture, where the lens is guessed; move the board "
                    "into the picture's corners",
                    100 * (1 - calibration.covered)));
  }
  if (pictures.is_recording && !pictures.registered_depth) {
    console.warn(
        "depth has a view of its own, whose lens these pictures do not show, and colour was straightened as the "
        "recording says; to calibrate depth's lens, give a folder of its infrared pictures with --depth");
  }
}

}  // namespace

int calibrate_camera_command(const CalibrateCameraArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto loaded = load_config(common.config);
  if (!loaded) return fail(loaded.error(), common);
  const auto target = read_target_file(arguments.target);
  if (!target) return fail(target.error(), common);
  if (auto ready = check_writable(arguments.output); !ready) return fail(ready.error(), common);
  Console console(common.verbosity);
  FoundViews found;
  std::size_t looked_at = 0;
  const auto take = [&](const BoardPicture& picture) {
    console.progress("looking for the board", ++looked_at, std::max(looked_at, picture.expected));
    return look_at(picture, *target, found);
  };
  const auto pictures = read_board_pictures(arguments.pictures, loaded->config.acquire, take, stop_on_signal.token());
  if (!pictures) return fail(pictures.error(), common);
  if (pictures->was_stopped) return kExitInterrupted;
  if (const auto fault = why_unseen(found, pictures->read, arguments.pictures.string())) return fail(*fault, common);
  auto calibration = calibrate_camera(found.views, *target, found.size);
  if (!calibration) {
    return fail({calibration.error().code, calibration.error().message, arguments.pictures.string()}, common);
  }
  ScannerCamera cameras = cameras_of(calibration->camera, *pictures, arguments.is_depth);
  std::optional<MeasuredDepth> depth;
  if (pictures->is_recording && !arguments.is_depth) {
    auto measured = measure_depth(arguments.pictures, loaded->config.acquire, *pictures, found.views, *calibration,
                                  *target, stop_on_signal.token(), cameras);
    if (!measured && measured.error().code != ErrorCode::kTooLittle) return fail(measured.error(), common);
    if (measured) {
      depth = std::move(*measured);
      for (const std::string& what : depth->unknown) console.warn(what);
    } else {
      console.warn("the error of depth is not measured: " + measured.error().message);
    }
  }
  const DepthCalibration* const fit = depth ? &depth->fit : nullptr;
  if (auto done = write_file_atomically(arguments.output, camera_file_text(cameras, *calibration, fit)); !done) {
    return fail(done.error(), common);
  }
  warn_of_gaps(*calibration, *pictures, console);
  const std::string output = arguments.output.string();
  std::string text;
  if (common.is_json) {
    Json json = summary_json(*calibration, cameras, found, output);
    json["measured_depth"] = depth ? depth_json(*depth, cameras) : Json(nullptr);
    text = json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  } else if (common.verbosity != Verbosity::kQuiet) {
    text = summary_text(*calibration, found, pictures->read) + (depth ? depth_text(*depth, cameras) : "") +
           fmt::format("Written  {0}\nNext     scanknit run RECORDING --set acquire.camera={0} -o OUT\n", output);
  }
  const int printed = text.empty() ? kExitOk : print_result(text, common);
  return stop_on_signal.token().stop_requested() && printed == kExitOk ? kExitInterrupted : printed;
}

}  // namespace scanknit
