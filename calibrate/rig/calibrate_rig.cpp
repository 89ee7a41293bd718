#include "calibrate/rig/calibrate_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "calibrate/lens/first_guess.h"
#include "calibrate/rig/rig_bundle.h"
#include "calibrate/rig/rig_guess.h"
#include "core/median.h"

namespace scanknit {
namespace {

constexpr double kHuber_px = 1;

/// A camera as it is known so far.
struct PlacedCamera {
  Pose T_rig_camera = Pose::Identity();
  double clock_offset_s = 0;
};

Error too_little_of_rig(std::string message) {
  return {ErrorCode::kTooLittle, std::move(message)};
}

/// Why a camera cannot be joined to the others; `best` is the most that it shares with one of them.
Error not_joined(const RigRecording& lone, const BoardTrack& track, const RigRecording& other,
                 const BoardTrack& other_track, std::size_t best) {
  const double from_s = track.views().front().time_s, to_s = track.views().back().time_s;
  const double other_from_s = other_track.views().front().time_s, other_to_s = other_track.views().back().time_s;
  if (best == 0 && (from_s > other_to_s || to_s < other_from_s)) {
    return {ErrorCode::kInput,
            fmt::format("{}: its clock and that of {} do not overlap (the board is seen from {:.1f} to {:.1f} s and "
                        "from {:.1f} to {:.1f} s), and no motion of the board tells how they differ; expected "
                        "recordings of one time, in which the board is turned before both cameras",
                        lone.name, other.name, from_s, to_s, other_from_s, other_to_s)};
  }
  return too_little_of_rig(
      fmt::format("{}: in {} pictures another camera sees the board at the same time and from a place that fits; "
                  "expected at least {}; move the board slowly through the part of the room that both see",
                  lone.name, best, kFewestShared));
}

/// Joins the cameras one by one to those that are placed: each time the one that shares most views with one of them.
Result<std::vector<PlacedCamera>> place_cameras(const std::vector<RigRecording>& recordings,
                                                const std::vector<BoardTrack>& tracks) {
  struct Joint {
    PairGuess guess;
    std::size_t to = 0;
  };
  const Clocks clocks = recordings.front().has_clock ? Clocks::kFree : Clocks::kShared;
  std::vector<PlacedCamera> placed(tracks.size());
  std::vector<bool> is_placed(tracks.size(), false);
  std::vector<Joint> best(tracks.size());
  is_placed.front() = true;
  std::size_t newest = 0;
  for (std::size_t count = 1; count < tracks.size(); ++count) {
    std::optional<std::size_t> next;
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      if (is_placed[i]) continue;
      PairGuess guess = guess_pair(tracks[newest], tracks[i], clocks);
      if (guess.agreeing > best[i].guess.agreeing) best[i] = {std::move(guess), newest};
      if (!next || best[i].guess.agreeing > best[*next].guess.agreeing) next = i;
    }
    const Joint& joint = best[*next];
    if (joint.guess.agreeing < kFewestShared) {
      return not_joined(recordings[*next], tracks[*next], recordings[joint.to], tracks[joint.to], joint.guess.agreeing);
    }
    placed[*next].T_rig_camera = placed[joint.to].T_rig_camera * joint.guess.T_a_b;
    placed[*next].clock_offset_s = placed[joint.to].clock_offset_s + joint.guess.lag_s;
    is_placed[*next] = true;
    newest = *next;
  }
  return placed;
}

/// What is seen of the board at a time of the rig. Its pose is that by the camera that sees most of it.
RigMoment moment_at(double time_s, const std::vector<BoardTrack>& tracks, const RigBundle& bundle,
                    const std::vector<double>& clocks_s, const std::vector<Eigen::Vector2d>& corners_m) {
  RigMoment moment;
  for (std::size_t camera = 0; camera < tracks.size(); ++camera) {
    RigSighting sighting{.camera = camera};
    for (const MovingCorner& corner : tracks[camera].corners_at(time_s - clocks_s[camera])) {
      sighting.board_m.push_back(corners_m[static_cast<std::size_t>(corner.corner.number)]);
      sighting.pixels.push_back(corner.corner.pixel);
      sighting.pixels_per_s.push_back(corner.pixels_per_s);
    }
    if (sighting.pixels.size() >= kFewestCorners) moment.sightings.push_back(std::move(sighting));
  }
  if (moment.sightings.empty()) return moment;
  const auto& most =
      *std::ranges::max_element(moment.sightings, {}, [](const RigSighting& s) { return s.pixels.size(); });
  const RigBundleCamera& camera = bundle.cameras[most.camera];
  moment.T_rig_board = camera.T_camera_rig.inverse() * guess_pose(camera.lens, {most.board_m, most.pixels});
  return moment;
}

/// Moments at which a picture was taken, no two closer than the usual time between pictures, so that none counts twice;
/// at most kMost, evenly spread. Views of one camera tell of a lens that is not known.
std::vector<RigMoment> moments_of(const std::vector<BoardTrack>& tracks, const RigBundle& bundle,
                                  const std::vector<double>& clocks_s, const CalibrationTarget& target) {
  constexpr std::size_t kMost = 300;
  constexpr double kJitter = 0.9;  // of the usual time
  const std::vector<Eigen::Vector2d> corners_m = target_corners(target);
  std::vector<double> times_s;
  double period_s = 0;
  for (std::size_t camera = 0; camera < tracks.size(); ++camera) {
    for (const TimedView& view : tracks[camera].views()) times_s.push_back(view.time_s + clocks_s[camera]);
    period_s = std::max(period_s, std::min(tracks[camera].period_s(), BoardTrack::kLongestGap_s));
  }
  std::ranges::sort(times_s);
  std::vector<double> chosen_s;
  for (const double time_s : times_s) {
    if (chosen_s.empty() || time_s >= chosen_s.back() + kJitter * period_s) chosen_s.push_back(time_s);
  }
  const bool has_free_lens =
      std::ranges::any_of(bundle.cameras, [](const RigBundleCamera& camera) { return camera.free != FreeLens::kNone; });
  std::vector<RigMoment> moments;
  for (const double time_s : chosen_s) {
    RigMoment moment = moment_at(time_s, tracks, bundle, clocks_s, corners_m);
    if (moment.sightings.size() >= (has_free_lens ? 1 : 2)) moments.push_back(std::move(moment));
  }
  const std::size_t step = (moments.size() + kMost - 1) / kMost;
  std::vector<RigMoment> result;
  for (std::size_t i = 0; i < moments.size(); i += step) result.push_back(std::move(moments[i]));
  return result;
}

/// Takes out corners that are far from where they should be, and sightings of which most are. Returns their number.
std::size_t drop_outliers(RigBundle& bundle) {
  // As in calibrate_camera.cpp: the median of the lengths of two normal coordinates is 1.1774 deviations (Rayleigh).
  constexpr double kMedianInDeviations = 1.1774, kMostDeviations = 5, kMostOfAView = 3;
  constexpr double kExact_px = 1e-3;
  std::vector<double> lengths;
  for (const RigMoment& moment : bundle.moments) {
    for (const RigSighting& sighting : moment.sightings) {
      for (const Eigen::Vector2d& residual : residuals(bundle, moment, sighting)) lengths.push_back(residual.norm());
    }
  }
  const double usual_px = std::max(median(lengths) / kMedianInDeviations, kExact_px);
  std::size_t dropped = 0;
  for (RigMoment& moment : bundle.moments) {
    std::vector<RigSighting> kept;
    for (const RigSighting& sighting : moment.sightings) {
      const auto errors = residuals(bundle, moment, sighting);
      RigSighting fitting{.camera = sighting.camera};
      std::vector<double> of_sighting;
      for (std::size_t i = 0; i < errors.size(); ++i) {
        of_sighting.push_back(errors[i].norm());
        if (!(errors[i].norm() <= kMostDeviations * usual_px)) continue;
        fitting.board_m.push_back(sighting.board_m[i]);
        fitting.pixels.push_back(sighting.pixels[i]);
        fitting.pixels_per_s.push_back(sighting.pixels_per_s[i]);
      }
      const bool fits = median(of_sighting) <= kMostOfAView * kMedianInDeviations * usual_px &&
                        fitting.pixels.size() >= kFewestCorners;
      dropped += errors.size() - (fits ? fitting.pixels.size() : 0);
      if (fits) kept.push_back(std::move(fitting));
    }
    moment.sightings = std::move(kept);
  }
  std::erase_if(bundle.moments, [](const RigMoment& moment) { return moment.sightings.empty(); });
  return dropped;
}

/// The residuals of all corners, as sums.
struct Squares {
  double sum = 0;
  std::size_t corners = 0;

  [[nodiscard]] double error() const { return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, corners))); }
};

/// The estimate's variance of a corner's coordinate.
double variance_of_rig(const RigBundle& bundle, const Squares& all) {
  double estimated = 6 * static_cast<double>(bundle.moments.size()) - 7;
  for (const RigBundleCamera& camera : bundle.cameras) estimated += 7 + static_cast<double>(camera.free);
  return all.sum / std::max(1.0, 2 * static_cast<double>(all.corners) - estimated);
}

FoundCamera found_camera(const RigBundle& bundle, std::size_t camera, const CameraModel& before,
                         const Eigen::VectorXd& deviations) {
  const auto own = deviations.segment<kRigNumbers>(kRigNumbers * static_cast<Eigen::Index>(camera));
  FoundCamera found;
  found.lens = model_of(bundle.cameras[camera].lens, before.intrinsics.width, before.intrinsics.height);
  found.T_rig_camera = bundle.cameras[camera].T_camera_rig.inverse();
  found.position_deviation_m = own.segment<3>(9).norm();
  found.turn_deviation_rad = own.segment<3>(12).norm();
  found.clock_deviation_s = own[15];
  return found;
}

RigCalibration describe(const RigBundle& bundle, const std::vector<RigRecording>& recordings,
                        const std::vector<double>& clocks_s) {
  std::vector<Squares> squares(recordings.size());
  Squares all;
  std::vector<std::size_t> shared(recordings.size(), 0);
  RigCalibration result;
  for (const RigMoment& moment : bundle.moments) {
    const bool is_shared = moment.sightings.size() > 1;
    result.moments += is_shared ? 1 : 0;
    for (const RigSighting& sighting : moment.sightings) {
      shared[sighting.camera] += is_shared ? 1 : 0;
      for (const Eigen::Vector2d& residual : residuals(bundle, moment, sighting)) {
        for (Squares* sum : {&squares[sighting.camera], &all}) sum->sum += residual.squaredNorm(), ++sum->corners;
      }
    }
  }
  const Eigen::VectorXd deviations =
      (variance_of_rig(bundle, all) * covariance(bundle).diagonal()).cwiseMax(0.0).cwiseSqrt();
  for (std::size_t camera = 0; camera < recordings.size(); ++camera) {
    FoundCamera found = found_camera(bundle, camera, recordings[camera].lens, deviations);
    found.clock_offset_s = clocks_s[camera] - bundle.cameras[camera].late_s;
    found.shared_moments = shared[camera];
    found.error_px = squares[camera].error();
    result.cameras.push_back(found);
  }
  result.error_px = all.error();
  return result;
}

Result<void> check_rig(const RigCalibration& found, const std::vector<RigRecording>& recordings) {
  constexpr double kMostError = 0.01;  // of the picture's width
  for (std::size_t camera = 0; camera < recordings.size(); ++camera) {
    if (found.cameras[camera].shared_moments < kFewestShared) {
      return too_little_of_rig(
          fmt::format("{}: only {} of its pictures fit to one place of the camera, expected at least {}; the cameras "
                      "must not move against each other, nor the board bend",
                      recordings[camera].name, found.cameras[camera].shared_moments, kFewestShared));
    }
    if (!(found.cameras[camera].error_px <= kMostError * recordings[camera].lens.intrinsics.width)) {
      return too_little_of_rig(
          fmt::format("{}: no place of the camera explains its pictures: the corners are {:.1f} pixels from where it "
                      "puts them; the cameras must not move against each other",
                      recordings[camera].name, found.cameras[camera].error_px));
    }
  }
  return {};
}

RigBundle begin_bundle(const std::vector<RigRecording>& recordings, const std::vector<PlacedCamera>& placed) {
  RigBundle bundle;
  for (std::size_t camera = 0; camera < recordings.size(); ++camera) {
    const RigRecording& recording = recordings[camera];
    const FreeLens free = recording.lens.distortion[4] != 0 ? FreeLens::kAll : FreeLens::kWithoutK3;
    bundle.cameras.push_back({lens_of(recording.lens), recording.is_lens_known ? FreeLens::kNone : free,
                              placed[camera].T_rig_camera.inverse()});
  }
  return bundle;
}

}  // namespace

Result<RigCalibration> calibrate_rig(const std::vector<RigRecording>& recordings, const CalibrationTarget& target) {
  std::vector<BoardTrack> tracks;
  for (const RigRecording& recording : recordings) {
    if (recording.has_clock != recordings.front().has_clock) {
      return Error{ErrorCode::kInput, fmt::format("{} has {}time stamps, {} has {}; expected recordings of one kind",
                                                  recordings.front().name, recordings.front().has_clock ? "" : "no ",
                                                  recording.name, recording.has_clock ? "some" : "none")};
    }
    tracks.emplace_back(recording.views, lens_of(recording.lens), target);
  }
  const auto placed = place_cameras(recordings, tracks);
  if (!placed) return placed.error();
  RigBundle bundle = begin_bundle(recordings, *placed);
  std::vector<double> clocks_s;
  for (const PlacedCamera& camera : *placed) clocks_s.push_back(camera.clock_offset_s);
  std::size_t outlying = 0;
  for (int round = 0; round < 2; ++round) {  // corners move on lines for a small error of the clocks only
    bundle.moments = moments_of(tracks, bundle, clocks_s, target);
    optimise(bundle, kHuber_px);
    outlying = drop_outliers(bundle);
    optimise(bundle, kHuber_px);
    if (round > 0) break;
    for (std::size_t camera = 0; camera < clocks_s.size(); ++camera) {
      clocks_s[camera] -= std::exchange(bundle.cameras[camera].late_s, 0);
    }
  }
  RigCalibration found = describe(bundle, recordings, clocks_s);
  found.outlying_corners = outlying;
  if (auto good = check_rig(found, recordings); !good) return good.error();
  return found;
}

}  // namespace scanknit
