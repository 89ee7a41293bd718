#include "scan/align/align_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "acquire/frame_source.h"
#include "acquire/range/range_files.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/located.h"
#include "core/files/read_file.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/write_mesh.h"
#include "extract/extract_surface.h"
#include "scan/checks/tracking_verdict.h"
#include "scan/frames/apply_sensor.h"
#include "scan/frames/frame_count.h"
#include "scan/frames/frame_intake.h"
#include "scan/reconstruction.h"
#include "scan/stage_times.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// Free space is measured with this many frames of a recording, each reduced to about this width in pixels.
constexpr std::size_t kSightFrames = 10;
constexpr int kSightWidth = 160;

/// The colours of the points that are in the surface.
std::vector<Rgb8> colours_of(const RangeScan& scan, const RangeSurface& surface) {
  std::vector<Rgb8> colours;
  for (std::size_t i = 0; i < scan.colours.size(); ++i) {
    if (surface.inset.pixels()[i] > 0) colours.push_back(scan.colours.pixels()[i]);
  }
  return colours;
}

/// A range scan from one centre, with every few pixels of the frame.
RangeScan coarse_scan_of(const Frame& frame) {
  const int stride = std::max(1, frame.depth_m.width() / kSightWidth);
  RangeScan scan;
  scan.points_m = Image<Eigen::Vector3f>(frame.depth_m.width() / stride, frame.depth_m.height() / stride, kNoReturn);
  for (int y = 0; y < scan.points_m.height(); ++y) {
    for (int x = 0; x < scan.points_m.width(); ++x) {
      const float z = frame.depth_m.at(x * stride, y * stride);
      if (z > 0) scan.points_m.at(x, y) = frame.intrinsics.unproject(x * stride, y * stride, z).cast<float>();
    }
  }
  scan.sight = {.kind = SightLines::Kind::kSphere, .pole = 1};
  return scan;
}

class InputLoader {
 public:
  InputLoader(const ScanConfig& config, ScanSession& session) : config_(config), session_(session) {}

  /// To be called once.
  [[nodiscard]] AlignInputs load_all(const std::vector<fs::path>& paths) {
    for (const fs::path& path : paths) {
      loaded_.outcome = load(path);
      if (!loaded_.outcome) return std::move(loaded_);
    }
    const std::size_t most = config_.acquire.limits.max_scans;
    if (loaded_.inputs.size() > most) {
      loaded_.outcome =
          Error{ErrorCode::kInput, fmt::format("{} scans, more than the limit of {}", loaded_.inputs.size(), most)};
    }
    return std::move(loaded_);
  }

 private:
  [[nodiscard]] Result<void> load(const fs::path& path) {
    if (path.extension() == ".conf") return load_conf(path);
    if (is_range_path(path)) return load_range(path, std::nullopt);
    if (is_mesh_path(path)) return load_mesh(path);
    return load_recording(path);
  }

  void warn(const std::string& message) { session_.warn(WarningCode::kAlignment, message); }

  [[nodiscard]] Result<void> load_conf(const fs::path& path) {
    const auto text = read_text_file(path, config_.acquire.limits.max_text_bytes);
    if (!text) return text.error();
    const auto scans = parse_conf(*text, config_.acquire.limits);
    if (!scans) return located(scans.error(), path);
    for (const TextLine& line : text_lines(*text)) {
      if (line.words[0] != "mesh") continue;  // an older form, whose poses are not those of bmesh
      warn(fmt::format(
          "{}:{}: a line 'mesh' is not read, its scan is left out; expected bmesh FILE tx ty tz qx qy qz qw",
          path.string(), line.number));
    }
    const std::size_t before = loaded_.inputs.size();
    for (const NamedScan& scan : *scans) {
      const fs::path named(scan.file);
      const bool leaves = named.is_absolute() ||
                          std::any_of(named.begin(), named.end(), [](const fs::path& part) { return part == ".."; });
      if (leaves) {
        return Error{ErrorCode::kInput, fmt::format("line {}: '{}' lies outside of its folder", scan.line, scan.file),
                     path.string()};
      }
      fs::path file = path.parent_path() / named;
      if (!fs::exists(file)) file += ".gz";
      if (!fs::exists(file)) {
        warn(fmt::format("{}:{}: {} is named, but is not there: left out", path.string(), scan.line, scan.file));
        continue;
      }
      if (auto loaded = load_range(file, scan.T_world_scan); !loaded) return loaded;
    }
    if (loaded_.inputs.size() == before) {
      return Error{ErrorCode::kInput, "none of the scans that it names is there", path.string()};
    }
    return {};
  }

  [[nodiscard]] Result<void> load_range(const fs::path& path, const std::optional<Pose>& T_world_scan) {
    auto file = session_.timed("read", [&] { return read_range_file(path, config_.acquire.limits); });
    if (!file) return file.error();
    if (file->scans.empty() && file->clouds.empty()) return load_mesh(path);
    const bool is_ptx = path.string().find(".ptx") != std::string::npos;
    const bool is_pcd = path.string().find(".pcd") != std::string::npos;
    for (RangeScan& scan : file->scans) {
      const RangeSurface surface = session_.timed("filter", [&] { return find_surface(scan); });
      if (surface.triangles.empty()) {
        return Error{ErrorCode::kInput, "no surface in it: no three neighbours in its grid have a return",
                     path.string()};
      }
      AlignInput input{.name = scan.name, .path = path, .noise_m = surface.noise_m};
      input.world_up = is_ptx ? UpAxis::kZ : is_pcd ? UpAxis::kMinusY : UpAxis::kY;
      input.T_world_scan = T_world_scan;
      if (!T_world_scan && is_ptx) input.T_world_scan = scan.T_world_scan;
      input.colours = colours_of(scan, surface);
      loaded_.models.push_back(model_of(scan, surface));
      loaded_.inputs.push_back(std::move(input));
      ++loaded_.frames.read;
    }
    for (PointCloud& cloud : file->clouds) {
      Mesh points{std::move(cloud.points_m), std::move(cloud.normals), std::move(cloud.colours), {}};
      if (auto added = add_mesh(path, std::move(points)); !added) return added;
    }
    return {};
  }

  [[nodiscard]] Result<void> load_mesh(const fs::path& path) {
    MeshNotes notes;
    auto mesh = session_.timed("read", [&] { return read_mesh(path, config_.acquire.limits, &notes); });
    if (!mesh) return mesh.error();
    for (const std::string& warning : notes.warnings) warn(fmt::format("{}: {}", path.string(), warning));
    return add_mesh(path, *std::move(mesh));
  }

  [[nodiscard]] Result<void> add_mesh(const fs::path& path, Mesh mesh) {
    const bool is_cloud = mesh.triangles.empty();
    if (is_cloud && mesh.normals.empty()) {
      return Error{
          ErrorCode::kInput,
          "points without normals, which do not say which side of them is outside; write them with normals, or "
          "give the organised grid that they come from",
          path.string()};
    }
    AlignInput input{
        .name = path.filename().string(), .path = path, .kind = is_cloud ? AlignKind::kCloud : AlignKind::kMesh};
    const bool has_colours = !mesh.colours.empty();
    ScanModel model = model_of(mesh, input.name);
    if (model.all.size() == 0) return Error{ErrorCode::kInput, "no point with a normal in it", path.string()};
    if (has_colours && model.all.size() == mesh.positions_m.size()) input.colours = std::move(mesh.colours);
    loaded_.models.push_back(std::move(model));
    loaded_.inputs.push_back(std::move(input));
    return {};
  }

  /// Fuses the recording by itself first: its surface becomes the model, some of its frames become the model's sights.
  [[nodiscard]] Result<void> load_recording(const fs::path& path) {
    auto source = open_recording(path, config_.acquire);
    if (!source) return source.error();
    for (const std::string& warning : (*source)->info().warnings) warn(warning);
    AlignInput input{.name = path.filename().string(),
                     .path = path,
                     .kind = AlignKind::kRecording,
                     .world_up = (*source)->info().world_up};
    if (input.name.empty()) input.name = path.parent_path().filename().string();
    input.config = config_;
    apply_sensor((*source)->info().sensor, input.config, session_);
    auto fused = fuse_recording(**source, input);
    if (!fused) return fused.error();
    loaded_.models.push_back(std::move(fused->model));
    input.trajectory = std::move(fused->trajectory);
    add_counts(fused->frames);
    loaded_.inputs.push_back(std::move(input));
    return {};
  }

  /// All but `fused`, which counts the frames of the aligned mesh.
  void add_counts(const FrameCounts& frames) {
    loaded_.frames.read += frames.read;
    loaded_.frames.dropped += frames.dropped;
    loaded_.frames.lost += frames.lost;
    for (const auto& [reason, count] : frames.dropped_by_reason) loaded_.frames.dropped_by_reason[reason] += count;
    for (const std::string& message : frames.drop_messages) {
      if (loaded_.frames.drop_messages.size() == FrameIntake::kMostDropMessages) break;
      loaded_.frames.drop_messages.push_back(message);
    }
  }

  struct FusedRecording {
    ScanModel model;
    Trajectory trajectory;
    FrameCounts frames;
  };

  /// Tracks and fuses all frames.
  [[nodiscard]] Result<FusedRecording> fuse_recording(FrameSource& source, const AlignInput& input) {
    FrameIntake intake(source, input.config.acquire, session_, {session_.stop(), {}, input.name});
    NoRefiner refiner;
    auto scan = Reconstruction::create(input.config, {source.info().poses}, refiner, session_);
    if (!scan) return scan.error();
    std::vector<ModelSight> sights;
    const std::size_t every = std::max<std::size_t>(1, selected_frames(source.info(), config_.acquire) / kSightFrames);
    while (!intake.is_over()) {
      auto frame = intake.next();
      if (!frame) continue;
      const auto added = scan->add(*frame);
      if (!added) return added.error();
      intake.count(*frame, *added);
      if (!added->T_world_camera) continue;
      if ((scan->trajectory().size() - 1) % every == 0) {
        const RangeScan view = coarse_scan_of(*frame);
        sights.push_back({RangeView(view, find_surface(view)), *added->T_world_camera});
      }
    }
    if (auto usable = intake.conclude(); !usable) return located(usable.error(), input.path);
    if (auto tracked = check_tracking({scan->tracking(), intake.counts(), scan->is_budget_reached()}); !tracked) {
      return located(tracked.error(), input.path);
    }
    const auto surface = extract_surface(scan->volume().field_view().without_colours(), config_.extract);
    if (!surface) return surface.error();
    if (surface->mesh.empty()) return Error{ErrorCode::kMesh, "no surface was extracted from it", input.path.string()};
    FusedRecording fused{model_of(surface->mesh, input.name), scan->trajectory(), intake.counts()};
    fused.model.sights = std::move(sights);
    return fused;
  }

  const ScanConfig& config_;
  ScanSession& session_;
  AlignInputs loaded_;
};

}  // namespace

AlignInputs load_align_inputs(const std::vector<fs::path>& paths, const ScanConfig& config, ScanSession& session) {
  return InputLoader(config, session).load_all(paths);
}

}  // namespace scanknit
