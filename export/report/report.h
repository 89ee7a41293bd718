// RunReport: what a run did, in numbers. Its JSON is published in docs/report.md and tested.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// Times of one stage, a sample per call.
struct StageTimes {
  std::vector<double> samples_ms;
  [[nodiscard]] double total_ms() const;
  [[nodiscard]] double median_ms() const;  ///< 0 without samples
  [[nodiscard]] double p95_ms() const;     ///< nearest rank; 0 without samples
};

struct RunReport {
  std::string version;
  std::string input;   ///< as given on the command line
  std::string status;  ///< "ok", or the error's text
  int exit_code = 0;

  struct Frames {
    std::size_t read = 0, fused = 0, dropped = 0, lost = 0;
    std::map<std::string, std::size_t> dropped_by_reason;
    std::vector<std::string> drop_messages;  ///< the first 100
  } frames;

  /// Pictures of a scanner that never arrived, by where they were lost; nothing unless one was listened to.
  std::optional<std::map<std::string, std::uint64_t>> losses;

  /// What was said of the scanner while it was listened to: what it does not tell, and what happened to it.
  std::vector<std::string> warnings;

  /// How well one frame's pose was found.
  struct TrackedFrame {
    std::uint64_t sequence = 0;
    std::string state, reason;  ///< "ok", "weak", "lost" or "recovered"; why, unless ok
    double overlap = 0, inlier_share = 0, rms_sigma = 0;
    std::size_t points = 0;
    int weak_directions = 0;
  };
  /// Two frames that show the same place.
  struct LoopPair {
    std::uint64_t from, to;  ///< sequence numbers
    double shift_m = 0, overlap = 0, inlier_share = 0;
    std::string refused;  ///< why it was not believed; empty when it was
  };
  /// What came of looking for places that the walk came back to.
  struct Loops {
    bool is_corrected = false;
    double drift_m = 0, largest_correction_m = 0;
    std::vector<LoopPair> pairs;
  };
  /// Nothing unless poses were tracked.
  struct Tracking {
    std::string mode;  ///< "track" or "refine"
    std::map<std::string, std::size_t> states;
    std::vector<TrackedFrame> frames;
    std::optional<Loops> loops;  ///< nothing unless they were looked for
  };
  std::optional<Tracking> tracking;

  /// Nothing unless scans were brought together (`align`).
  struct Aligned {
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
  std::optional<Aligned> alignment;
  /// What became of a turntable; nothing unless one was asked for.
  struct Turntable {
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
    std::string prior = "none";  ///< of the angles: "none", "rpm", "step", "file"
    std::size_t key_frames = 0, pairs = 0, loops = 0, across = 0;  ///< and pairs that were found
    bool has_still_scene = false;                                  ///< something stands still, and was cut away
    std::optional<double> disc_m;           ///< height of the disc along the axis, from axis_point
    double radius_m = 0;                    ///< of the space that was kept
    std::size_t pixels_looked_through = 0;  ///< of a hand, or anything that other frames look through
    bool has_base = false;                  ///< closed by a plane where it stood
    std::vector<std::pair<std::uint64_t, double>> angles_rad;  ///< frame, angle
  };
  std::optional<Turntable> turntable;

  /// acquire filter track raycast integrate extract export: always all of them, and read and write for the files.
  std::map<std::string, StageTimes> stages;
  double total_ms = 0;
  double peak_rss_mib = 0;

  struct Volume {
    std::size_t active_voxels = 0, blocks = 0;
    double memory_mib = 0, voxel_size_m = 0;
    bool is_budget_reached = false;
    std::string format = {};               ///< of a volume's file; empty for a volume that was fused
    std::array<int, 3> dims = {};          ///< samples along each axis; 0 for a sparse volume
    std::array<double, 3> spacing_m = {};  ///< with `dims` only
    bool is_streamed = false;              ///< it never was in memory as a whole
  } volume;

  std::optional<MeshCheck> mesh;
  /// False: the mesh was streamed, and of `mesh` only the counts of vertices and triangles and the bounds are known.
  bool is_mesh_checked = true;

  /// Loops of the mesh's boundary; nothing for a mesh that is not there, or was streamed.
  struct Holes {
    std::size_t count = 0;
    double total_length_m = 0;      ///< of their rims
    std::vector<double> longest_m;  ///< of the longest rims, longest first
  };
  std::optional<Holes> holes;

  /// The mesh against some of its depth frames, see SurfaceFit; nothing where there were none.
  struct Fit {
    std::size_t frames = 0;
    double seen_share = 0, median_m = 0, p95_m = 0;
    double error_map_end_m = 0;        ///< the error that has the last colour in error.png
    std::size_t coverage_map_end = 0;  ///< the count of frames that has the last colour in coverage.png
  };
  std::optional<Fit> fit;

  struct Extract {
    std::optional<double> isovalue;                              ///< nothing before it is known
    std::string isovalue_source;                                 ///< "config", "signed_distance" or "otsu"
    std::map<std::string, std::size_t> cases;                    ///< kind of cell -> count
    std::vector<std::pair<std::string, std::size_t>> sub_cases;  ///< sub-case -> cells, by configuration
  } extract;

  /// What was done between fusing and writing (`finish:`).
  struct Finish {
    struct Step {
      std::string name;     ///< "crop", "ground", "watertight", "pieces", "smooth", "simplify", "place"
      std::string refused;  ///< why it was not done; empty when it was
      std::map<std::string, double> figures;  ///< how much it changed; units in the names
    };
    std::vector<Step> steps;  ///< in their order
    Pose T_mesh_world = Pose::Identity();
  };
  std::optional<Finish> finish;  ///< nothing unless something was asked for
  /// The texture of the GLB; nothing unless one was asked for.
  struct Texture {
    std::string refused;  ///< why there is none; empty when there is
    int width = 0, height = 0;
    double texel_m = 0;  ///< side of a texel on the surface
    std::size_t charts = 0;
    std::size_t texels = 0;  ///< that triangles cover
    double seen_share = 0;   ///< of those, that a frame saw; the others have the colours of the vertices
    std::size_t frames = 0;  ///< that it was baked from
    std::size_t bytes = 0;   ///< of the picture's file
  };
  std::optional<Texture> texture;
  std::map<std::string, std::string> files;  ///< kind ("glb", "preview" ...) -> path as written
  std::string config_json;                   ///< the effective configuration as a JSON object
};

/// One JSON document, keys as in the schema, ending in a newline. Numbers are numbers; bounds_m is [[x,y,z],[x,y,z]].
[[nodiscard]] std::string to_json(const RunReport& report);

struct StampedPose {
  double stamp;  ///< seconds of the recording's clock, or the frame's number where it has none
  Pose T_world_camera;
};

/// TUM format: "stamp tx ty tz qx qy qz qw", one line a pose, enough digits to give the pose back within 1e-9.
[[nodiscard]] std::string to_tum_trajectory(const std::vector<StampedPose>& poses);

}  // namespace scanknit
