// ScanResult: what a scan made and how it went, stage by stage.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/frame.h"
#include "core/mesh.h"
#include "core/pose.h"
#include "core/result.h"
#include "extract/cell/case_counts.h"
#include "fusion/align/pair_verdict.h"
#include "fusion/track/tracker.h"
#include "scan/scan_config.h"

namespace scanknit {

enum class WarningCode {
  kNoEffect,          ///< a setting that changes none of the files
  kRecording,         ///< a fault of the recording as a whole
  kScanner,           ///< unknown properties of the scanner, and its failures
  kRecorder,          ///< the recorder stopped; the scan went on
  kReset,             ///< the user reset the scan
  kTrackingLost,      ///< in more than a tenth of the frames
  kLostNotSearched,   ///< frames that were lost could not be looked for again
  kLoopNotClosed,     ///< the walk came back to a place, but the mesh has the tracked poses
  kNoTurntable,       ///< no turntable was found, or none was looked for: the mesh has the tracked poses
  kTurntable,         ///< frames or known angles that were not used
  kCropBoxIgnored,    ///< nothing lay within the live view's box
  kCropBoxDropped,    ///< the live view's box does not apply to the world of a refined turntable
  kFinishStep,        ///< a finishing step was not done, or only in part
  kNoTexture,         ///< the GLB has colours at its vertices
  kAlignment,         ///< about scans, given poses, and how they agree
  kAlignInterrupted,  ///< the mesh holds only the scans that were fused so far
  // The next ones repeat what the result has in numbers, or what the files show.
  kFramesDropped,
  kRecordingEndsEarly,
  kStoppedEarly,
  kBudgetReached,
  kPicturesLost,
  kTurntableNotTried,
  kMeshHasHoles,  ///< because of the chosen decider
  kVolumeFile,    ///< parts of a volume file were not used
  kSilhouettes,   ///< a silhouette that the hull does not fill
  kPointsOnly,    ///< aligning only meshes and points makes no mesh
  kClasses,       ///< a class of the masks without a mesh
};

struct ScanWarning {
  WarningCode code;
  std::string text;  ///< for the user
};

/// "no_effect" for kNoEffect, and so on.
[[nodiscard]] const char* to_string(WarningCode code);

/// A frame that was fused.
struct PosedFrame {
  std::uint64_t sequence = 0;  ///< Frame::sequence
  double stamp = 0;            ///< seconds of the recording's clock; the frame's number if it has no clock
  Pose T_world_camera = Pose::Identity();
  FrameMotion motion = {};
};

/// In the order of the scan.
using Trajectory = std::vector<PosedFrame>;

struct StampedPose;
/// For a file (export/trajectory.h).
[[nodiscard]] std::vector<StampedPose> stamped_poses(const Trajectory& trajectory);

/// T_world_camera by Frame::sequence.
using PosesBySequence = std::map<std::uint64_t, Pose>;

[[nodiscard]] inline PosesBySequence poses_of(const Trajectory& trajectory) {
  PosesBySequence poses;
  for (const PosedFrame& frame : trajectory) poses[frame.sequence] = frame.T_world_camera;
  return poses;
}

/// The frame's PosedFrame::stamp.
[[nodiscard]] inline double stamp_of(const Frame& frame) {
  return frame.has_clock ? static_cast<double>(frame.timestamp_ns) * 1e-9 : static_cast<double>(frame.sequence);
}

/// The path of each written file, by its kind: "glb", "preview", "trajectory" ...
using FilesByKind = std::map<std::string, std::string>;

struct FrameCounts {
  std::size_t read = 0, fused = 0, dropped = 0, lost = 0;
  /// The words of DropReason, "paused" and "reset".
  std::map<std::string, std::size_t> dropped_by_reason;
  std::vector<std::string> drop_messages;  ///< the first 100
};

/// How well one frame's pose was found.
struct TrackedFrame {
  std::uint64_t sequence = 0;
  TrackState state = TrackState::kLost;
  TrackReason reason = TrackReason::kNone;  ///< why not ok
  double overlap = 0, inlier_share = 0, rms_sigma = 0;
  std::size_t points = 0;
  int weak_directions = 0;
};

struct TrackingResult {
  PosePrior prior = PosePrior::kIgnore;
  std::vector<TrackedFrame> frames;
  std::size_t found_later = 0;  ///< of `frames`: lost during the scan, found when all of it was known; kRecovered
};

/// The result of the search for places that the walk came back to.
struct LoopResult {
  /// Two frames that show the same place.
  struct Pair {
    std::uint64_t from, to;  ///< sequence numbers
    double shift_m = 0, overlap = 0, inlier_share = 0;
    std::string refused;  ///< why the pair was rejected; empty when it was accepted
  };
  bool is_corrected = false;
  double drift_m = 0, largest_correction_m = 0;
  std::vector<Pair> pairs;
};

/// The source of a turntable's known angles, apart from the pictures.
enum class AngleSource { kNone, kRpm, kStep, kFile, kRecording };

struct TurntableResult {
  bool is_refined = false;  ///< false: the mesh has the tracked poses, for the reason below
  std::string reason;       ///< why not refined; empty otherwise
  Eigen::Vector3d axis_direction = Eigen::Vector3d::Zero();  ///< unit, upwards, the camera's frame
  Eigen::Vector3d axis_point = Eigen::Vector3d::Zero();      ///< metres, the camera's frame
  double turns = 0;
  bool is_closed = false;      ///< the turn is whole, and its ends were registered with each other
  double rms_m = 0;            ///< root mean square of what remains between pairs of frames
  double rms_rad = 0;          ///< likewise
  double angle_sigma_rad = 0;  ///< how well the scene determines the angle between two frames
  bool is_angle_held = false;  ///< false: the object looks the same from all sides; the angles are those of the prior
  AngleSource prior = AngleSource::kNone;
  std::size_t key_frames = 0, pairs = 0, loops = 0, across = 0;  ///< also counts of pairs
  bool has_still_scene = false;                                  ///< something that stands still was found and cut away
  std::optional<double> disc_m;                                  ///< height of the disc along the axis, from axis_point
  double radius_m = 0;                                           ///< radius of the space that was kept
  std::size_t pixels_looked_through = 0;                         ///< pixels that other frames see through, as of a hand
  bool has_base = false;                                         ///< the object was closed by a plane where it stood
  std::vector<std::pair<std::uint64_t, double>> angles_rad;      ///< frame, angle
};

struct VolumeResult {
  std::size_t active_voxels = 0, blocks = 0;
  double memory_mib = 0, voxel_size_m = 0;
  bool is_budget_reached = false;
  std::string format = {};               ///< format of the volume file; empty for a volume that was fused
  std::array<int, 3> dims = {};          ///< samples along each axis; 0 for a sparse volume
  std::array<double, 3> spacing_m = {};  ///< with `dims` only
  bool is_streamed = false;              ///< it was never in memory as a whole
};

/// Where the isovalue came from.
enum class IsovalueSource { kConfig, kSignedDistance, kOtsu };

enum class FinishStep { kCrop, kGround, kWatertight, kPieces, kCrumbs, kSmooth, kSimplify, kPlace };

/// "crop" for kCrop, and so on.
[[nodiscard]] const char* to_string(FinishStep step);

/// The steps that were done between fusing and writing (`finish:`).
struct FinishResult {
  struct Step {
    FinishStep step;
    std::string refused;                    ///< why the step was not done; empty when it was done
    std::map<std::string, double> figures;  ///< how much it changed; units in the names
  };
  std::vector<Step> steps;  ///< in the order in which they were done
  Pose T_mesh_world = Pose::Identity();
};

/// The loops of a mesh's boundary.
struct HolesResult {
  std::size_t count = 0;
  double total_length_m = 0;      ///< total length of the rims
  std::vector<double> longest_m;  ///< of the longest rims, longest first
};

/// Surface that is there twice, in two sheets that face the same way: a wall that was fused at two places.
struct DoubledResult {
  double area_m2 = 0;
  double share = 0;  ///< of the mesh's area
};

/// How well the mesh fits some of its depth frames.
struct FitResult {
  std::size_t frames = 0;
  double seen_share = 0, median_m = 0, p95_m = 0;
  double error_map_end_m = 0;        ///< error that error.png draws in the last colour
  std::size_t coverage_map_end = 0;  ///< count of frames that coverage.png draws in the last colour
};

/// A mesh that was written, or why there is none.
struct MeshResult {
  std::optional<double> isovalue;  ///< nothing before it is known
  IsovalueSource isovalue_source = IsovalueSource::kConfig;
  std::optional<CaseCounts> cases;       ///< nothing before the surface is extracted
  std::optional<FinishResult> finish;    ///< nothing unless `finish:` asks for a step
  std::optional<MeshCheck> check;        ///< nothing before the surface is finished
  bool is_checked = true;                ///< false: it was streamed; `check` has only two counts and the bounds
  std::optional<HolesResult> holes;      ///< nothing for an empty or a streamed mesh
  std::optional<DoubledResult> doubled;  ///< nothing unless frames were fused, and the mesh not simplified
  std::optional<FitResult> fit;          ///< nothing when there were no depth frames
  FilesByKind files;                     ///< meshes and pictures
  std::vector<ScanWarning> warnings;     ///< of finishing; ScanResult::warnings has them, too
};

/// The texture of the GLB.
struct TextureResult {
  std::string refused;  ///< why there is no texture; empty when there is one
  int width = 0, height = 0;
  double texel_m = 0;  ///< side of a texel on the surface
  std::size_t charts = 0;
  std::size_t texels = 0;  ///< texels that triangles cover
  double seen_share = 0;   ///< share of those that a frame saw; the others have the colours of the vertices
  std::size_t frames = 0;  ///< frames that it was baked from
  std::size_t bytes = 0;   ///< size of the picture's file
};

enum class AlignKind { kRange, kRecording, kMesh, kCloud };

/// "range scan", "recording", "mesh", "point cloud".
[[nodiscard]] const char* to_string(AlignKind kind);

/// The result of aligning several scans.
struct AlignmentResult {
  struct Scan {
    std::string name;
    AlignKind kind = AlignKind::kRange;
    std::size_t points = 0;
    bool is_placed = false;
    Pose T_world_scan = Pose::Identity();
  };
  struct Pair {
    std::size_t from = 0, to = 0;  ///< numbers of scans, from 1
    PairVerdict verdict = PairVerdict::kUnacceptable;
    std::string reason;  ///< of the verdict; empty when good
    PairStart start = PairStart::kSearch;
    double residual_m = 0, overlap = 0, off_m = 0, least_strength = 0;
    std::optional<double> contradicted, missing;  ///< nothing: the scanners' positions are unknown
    std::string picture;                          ///< path; empty: none
  };
  double spacing_m = 0;  ///< spacing of the points that are compared
  std::vector<Scan> scans;
  std::vector<Pair> pairs;
};

/// How well a visual hull fills the silhouettes that carved it.
struct SilhouetteResult {
  std::size_t pictures = 0;
  double agreement = 1;      ///< share of the pixels in which mesh and mask agree, mean of the pictures
  double worst_overlap = 1;  ///< pixels of both over pixels of either, in the picture in which that is least
  std::string worst_picture = {};
};

/// One class of the masks.
struct ClassResult {
  int label = 0;  ///< the value of its pixels
  VolumeResult volume;
  MeshResult mesh;
  std::optional<double> area_m2;  ///< of the mesh as it was written; nothing: there is none
};

/// How long a stage took, each time that it ran, and the largest memory while it did.
struct StageTimes {
  std::vector<double> samples_ms;
  double peak_rss_mib = 0;  ///< resident memory of the whole process: PeakMemoryWatch
  [[nodiscard]] double total_ms() const;
  [[nodiscard]] double median_ms() const;  ///< 0 without samples
  [[nodiscard]] double p95_ms() const;     ///< nearest rank; 0 without samples
};

/// By the stage's name: acquire, filter, track, raycast, integrate, extract, export ... (docs/report.md).
using StageTimesByName = std::map<std::string, StageTimes>;

struct ScanResult {
  Result<void> outcome;  ///< the error that ended the scan; the other members have everything up to it
  std::string input;     ///< the recording, the volume's file, or the scanner that was found
  ScanConfig config;     ///< the configuration in force, with all values that were chosen on the way
  FrameCounts frames;
  std::optional<LossCounters> losses;           ///< of a scanner: pictures that never arrived
  std::optional<TrackingResult> tracking;       ///< nothing unless poses were tracked
  std::optional<LoopResult> loops;              ///< nothing unless the scan looked for loops
  std::optional<TurntableResult> turntable;     ///< nothing unless the job asks for one
  std::optional<AlignmentResult> alignment;     ///< nothing unless scans were aligned
  std::optional<SilhouetteResult> silhouettes;  ///< nothing unless they carved the volume
  VolumeResult volume;
  MeshResult mesh;
  std::optional<TextureResult> texture;  ///< nothing unless the job asks for one
  Trajectory trajectory;                 ///< poses of the frames that are in the volume
  FilesByKind files;
  std::vector<ScanWarning> warnings;  ///< in the order in which they came; those of the mesh at the end
  StageTimesByName stages;
  std::vector<ClassResult> classes;  ///< by label; empty unless each had to get a mesh: `mesh` is none then
};

/// The first warning with this code, or null.
[[nodiscard]] const ScanWarning* find_warning(const ScanResult& result, WarningCode code);

}  // namespace scanknit
