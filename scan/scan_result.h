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
#include "fusion/track/tracker.h"
#include "scan/scan_config.h"
#include "scan/scan_warning.h"
#include "scan/trajectory.h"

namespace scanknit {

/// Path as written, by its kind: "glb", "preview", "trajectory" ...
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
  std::string reason;  ///< why not ok, in a few words of docs/report.md; empty when ok
  double overlap = 0, inlier_share = 0, rms_sigma = 0;
  std::size_t points = 0;
  int weak_directions = 0;
};

struct TrackingResult {
  PosePrior prior = PosePrior::kIgnore;
  std::vector<TrackedFrame> frames;
};

/// What came of looking for places that the walk came back to.
struct LoopResult {
  /// Two frames that show the same place.
  struct Pair {
    std::uint64_t from, to;  ///< sequence numbers
    double shift_m = 0, overlap = 0, inlier_share = 0;
    std::string refused;  ///< why it was not believed; empty when it was
  };
  bool is_corrected = false;
  double drift_m = 0, largest_correction_m = 0;
  std::vector<Pair> pairs;
};

/// Where the angles of a turntable were known from beside the pictures.
enum class AngleSource { kNone, kRpm, kStep, kFile, kRecording };

struct TurntableResult {
  bool is_refined = false;  ///< false: it was none, or too little of one; the mesh is the tracked one
  std::string reason;       ///< why not refined; empty otherwise
  Eigen::Vector3d axis_direction = Eigen::Vector3d::Zero();  ///< unit, upwards, the camera's frame
  Eigen::Vector3d axis_point = Eigen::Vector3d::Zero();      ///< metres, the camera's frame
  double turns = 0;
  bool is_closed = false;      ///< the turn is whole, and its ends were registered with each other
  double rms_m = 0;            ///< of what remains between pairs of frames
  double rms_rad = 0;          ///< likewise
  double angle_sigma_rad = 0;  ///< how well the scene holds the angle between two frames
  bool is_angle_held = false;  ///< false: the object looks alike from all sides; angles are the prior's
  AngleSource prior = AngleSource::kNone;
  std::size_t key_frames = 0, pairs = 0, loops = 0, across = 0;  ///< and pairs that were found
  bool has_still_scene = false;                                  ///< something stands still, and was cut away
  std::optional<double> disc_m;                                  ///< height of the disc along the axis, from axis_point
  double radius_m = 0;                                           ///< of the space that was kept
  std::size_t pixels_looked_through = 0;                     ///< of a hand, or anything that other frames look through
  bool has_base = false;                                     ///< closed by a plane where it stood
  std::vector<std::pair<std::uint64_t, double>> angles_rad;  ///< frame, angle
};

struct VolumeResult {
  std::size_t active_voxels = 0, blocks = 0;
  double memory_mib = 0, voxel_size_m = 0;
  bool is_budget_reached = false;
  std::string format = {};               ///< of a volume's file; empty for a volume that was fused
  std::array<int, 3> dims = {};          ///< samples along each axis; 0 for a sparse volume
  std::array<double, 3> spacing_m = {};  ///< with `dims` only
  bool is_streamed = false;              ///< it never was in memory as a whole
};

/// Where the isovalue came from.
enum class IsovalueSource { kConfig, kSignedDistance, kOtsu };

/// What was done between fusing and writing (`finish:`).
struct FinishResult {
  struct Step {
    std::string name;                       ///< "crop", "ground", "watertight", "pieces", "smooth", "simplify", "place"
    std::string refused;                    ///< why it was not done; empty when it was
    std::map<std::string, double> figures;  ///< how much it changed; units in the names
  };
  std::vector<Step> steps;  ///< in their order
  Pose T_mesh_world = Pose::Identity();
};

/// Loops of a mesh's boundary.
struct HolesResult {
  std::size_t count = 0;
  double total_length_m = 0;      ///< of their rims
  std::vector<double> longest_m;  ///< of the longest rims, longest first
};

/// A mesh against some of its depth frames: how far what they saw lies from it.
struct FitResult {
  std::size_t frames = 0;
  double seen_share = 0, median_m = 0, p95_m = 0;
  double error_map_end_m = 0;        ///< the error that has the last colour in error.png
  std::size_t coverage_map_end = 0;  ///< the count of frames that has the last colour in coverage.png
};

/// A mesh that was written, or why there is none.
struct MeshResult {
  std::optional<double> isovalue;  ///< nothing before it is known
  IsovalueSource isovalue_source = IsovalueSource::kConfig;
  std::optional<CaseCounts> cases;     ///< nothing before the surface is extracted
  std::optional<FinishResult> finish;  ///< nothing unless something was asked for
  std::optional<MeshCheck> check;      ///< nothing before the surface is finished
  bool is_checked = true;            ///< false: it was streamed; `check` has counts of vertices, triangles, bounds only
  std::optional<HolesResult> holes;  ///< nothing for an empty or a streamed mesh
  std::optional<FitResult> fit;      ///< nothing where there were no depth frames
  FilesByKind files;                 ///< meshes and pictures
};

/// The texture of the GLB.
struct TextureResult {
  std::string refused;  ///< why there is none; empty when there is
  int width = 0, height = 0;
  double texel_m = 0;  ///< side of a texel on the surface
  std::size_t charts = 0;
  std::size_t texels = 0;  ///< that triangles cover
  double seen_share = 0;   ///< of those, that a frame saw; the others have the colours of the vertices
  std::size_t frames = 0;  ///< that it was baked from
  std::size_t bytes = 0;   ///< of the picture's file
};

/// Scans that were brought together.
struct AlignmentResult {
  struct Scan {
    std::string name, kind;  ///< "range scan", "recording", "mesh" or "point cloud"
    std::size_t points = 0;
    bool is_placed = false;
    Pose T_world_scan = Pose::Identity();
  };
  struct Pair {
    std::size_t from = 0, to = 0;        ///< numbers of scans, from 1
    std::string verdict, reason, start;  ///< "good", "acceptable", "unacceptable"; why; how its pose was found
    double residual_m = 0, overlap = 0, off_m = 0, least_strength = 0;
    std::optional<double> contradicted, missing;  ///< nothing: nobody knows from where the scans were seen
    std::string picture;                          ///< path; empty: none
  };
  double spacing_m = 0;  ///< of the points that are compared
  std::vector<Scan> scans;
  std::vector<Pair> pairs;
};

/// How long a stage took, each time that it ran.
struct StageTimes {
  std::vector<double> samples_ms;
  [[nodiscard]] double total_ms() const;
  [[nodiscard]] double median_ms() const;  ///< 0 without samples
  [[nodiscard]] double p95_ms() const;     ///< nearest rank; 0 without samples
};

/// By the stage's name: acquire, filter, track, raycast, integrate, extract, export ... (docs/report.md).
using StageTimesByName = std::map<std::string, StageTimes>;

struct ScanResult {
  Result<void> outcome;  ///< the error that ended the scan; what was found out until then is in the other members
  std::string input;     ///< the recording, the volume's file, or the scanner that was found
  ScanConfig config;     ///< in force, with the values that were chosen on the way
  FrameCounts frames;
  std::optional<LossCounters> losses;        ///< of a scanner: pictures that never arrived
  std::optional<TrackingResult> tracking;    ///< nothing unless poses were tracked
  std::optional<LoopResult> loops;           ///< nothing unless they were looked for
  std::optional<TurntableResult> turntable;  ///< nothing unless one was asked for
  std::optional<AlignmentResult> alignment;  ///< nothing unless scans were brought together
  VolumeResult volume;
  MeshResult mesh;
  std::optional<TextureResult> texture;  ///< nothing unless one was asked for
  Trajectory trajectory;                 ///< of the frames that are in the volume
  FilesByKind files;
  std::vector<ScanWarning> warnings;  ///< in the order in which they came
  StageTimesByName stages;
};

/// The first warning with this code, or null.
[[nodiscard]] const ScanWarning* find_warning(const ScanResult& result, WarningCode code);

}  // namespace scanknit
