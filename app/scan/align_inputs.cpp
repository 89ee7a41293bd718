#include "app/scan/align_inputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "acquire/frame_source.h"
#include "acquire/range/range_files.h"
#include "acquire/replay/text_numbers.h"
#include "app/scan/frame_count.h"
#include "app/scan/frame_intake.h"
#include "app/scan/reconstruction.h"
#include "app/scan/stage_timer.h"
#include "core/files/read_file.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/write_mesh.h"
#include "extract/extract_surface.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// Frames of a recording that tell of free space, and how wide their pictures are for that.
constexpr std::size_t kSightFrames = 10;
constexpr int kSightWidth = 160;

/// A frame as a scan from one centre, every few pixels.
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
  InputLoader(const Config& config, std::stop_token stop, Console& console, RunReport& report)
      : config_(config), stop_(std::move(stop)), console_(console), report_(report) {}

  [[nodiscard]] Result<void> load(const fs::path& path) {
    if (path.extension() == ".conf") return load_conf(path);
    if (is_range_path(path)) return load_range(path, std::nullopt);
    if (is_mesh_path(path)) return load_mesh(path);
    return load_recording(path);
  }

  [[nodiscard]] AlignInputs take() { return std::move(loaded_); }

 private:
  void warn(const std::string& message) {
    console_.warn(message);
    report_.warnings.push_back(message);
  }

  [[nodiscard]] Result<void> load_conf(const fs::path& path) {
    const auto text = read_text_file(path, config_.acquire.limits.max_text_bytes);
    if (!text) return text.error();
    const auto scans = parse_conf(*text, config_.acquire.limits);
    if (!scans) return Error{scans.error().code, scans.error().message, path.string()};
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
    auto file = timed(report_, "read", [&] { return read_range_file(path, config_.acquire.limits); });
    if (!file) return file.error();
    if (file->scans.empty() && file->clouds.empty()) return load_mesh(path);
    const bool is_ptx = path.string().find(".ptx") != std::string::npos;
    const bool is_pcd = path.string().find(".pcd") != std::string::npos;
    for (RangeScan& scan : file->scans) {
      const RangeSurface surface = timed(report_, "filter", [&] { return find_surface(scan); });
      if (surface.triangles.empty()) {
        return Error{ErrorCode::kInput, "no surface in it: no three neighbours in its grid have a return",
                     path.string()};
      }
      AlignInput input{.name = scan.name, .path = path, .noise_m = surface.noise_m};
      input.world_up = is_ptx ? UpAxis::kZ : is_pcd ? UpAxis::kMinusY : UpAxis::kY;
      input.T_world_scan = T_world_scan;
      if (!T_world_scan && is_ptx) input.T_world_scan = scan.T_world_scan;
      add_colours(scan, surface, input);
      loaded_.models.push_back(model_of(scan, surface));
      loaded_.inputs.push_back(std::move(input));
      ++report_.frames.read;
    }
    for (PointCloud& cloud : file->clouds) {
      Mesh points{std::move(cloud.points_m), std::move(cloud.normals), std::move(cloud.colours), {}};
      if (auto added = add_mesh(path, std::move(points)); !added) return added;
    }
    return {};
  }

  static void add_colours(const RangeScan& scan, const RangeSurface& surface, AlignInput& input) {
    if (scan.colours.empty()) return;
    for (std::size_t i = 0; i < scan.colours.size(); ++i) {
      if (surface.inset.pixels()[i] > 0) input.colours.push_back(scan.colours.pixels()[i]);
    }
  }

  [[nodiscard]] Result<void> load_mesh(const fs::path& path) {
    MeshNotes notes;
    auto mesh = timed(report_, "read", [&] { return read_mesh(path, config_.acquire.limits, &notes); });
    if (!mesh) return mesh.error();
    for (const std::string& warning : notes.warnings) warn(fmt::format("{}: {}", path.string(), warning));
    return add_mesh(path, *std::move(mesh));
  }

  [[nodiscard]] Result<void> add_mesh(const fs::path& path, Mesh mesh) {
    const bool is_cloud = mesh.triangles.empty();
    if (is_cloud && mesh.normals.empty()) {
      return Error{ErrorCode::kInput,
                   "points without normals: nobody knows which side of them is outside; write them with normals, or "
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

  /// Fused by itself first: the model is the surface, the sights are some of its frames.
  [[nodiscard]] Result<void> load_recording(const fs::path& path) {
    auto source = open_recording(path, config_.acquire);
    if (!source) return source.error();
    for (const std::string& warning : (*source)->info().warnings) warn(warning);
    const Job job{path, config_, {}, Pace::kFast};
    RunReport own;
    FrameIntake intake(**source, config_.acquire, stop_, console_, own);
    auto scan = Reconstruction::create(job, (*source)->info(), intake, own);
    if (!scan) return scan.error();
    AlignInput input{.name = path.filename().string(),
                     .path = path,
                     .kind = AlignKind::kRecording,
                     .world_up = (*source)->info().world_up};
    if (input.name.empty()) input.name = path.parent_path().filename().string();
    std::vector<ModelSight> sights;
    const std::size_t frames = selected_frames((*source)->info(), config_.acquire);
    const std::size_t every = std::max<std::size_t>(1, frames / kSightFrames);
    while (!intake.is_over()) {
      auto frame = intake.next();
      if (!frame) continue;
      const auto pose = scan->add(*frame);
      if (!pose) return pose.error();
      if (!*pose) continue;
      if (input.T_scan_camera.size() % every == 0) {
        const RangeScan view = coarse_scan_of(*frame);
        sights.push_back({RangeView(view, find_surface(view)), **pose});
      }
      input.T_scan_camera[frame->sequence] = **pose;
    }
    if (auto usable = intake.result(); !usable)
      return Error{usable.error().code, usable.error().message, path.string()};
    if (auto tracked = check_tracking(own); !tracked)
      return Error{tracked.error().code, tracked.error().message, path.string()};
    const auto surface = extract_surface(scan->volume().field_view().without_colours(), config_.extract);
    if (!surface) return surface.error();
    if (surface->mesh.empty()) return Error{ErrorCode::kMesh, "no surface comes of it", path.string()};
    ScanModel model = model_of(surface->mesh, input.name);
    model.sights = std::move(sights);
    report_.frames.read += own.frames.read;
    report_.frames.dropped += own.frames.dropped;
    report_.frames.lost += own.frames.lost;
    for (const auto& [stage, times] : own.stages) {
      auto& samples = report_.stages[stage].samples_ms;
      samples.insert(samples.end(), times.samples_ms.begin(), times.samples_ms.end());
    }
    loaded_.models.push_back(std::move(model));
    loaded_.inputs.push_back(std::move(input));
    return {};
  }

  const Config& config_;
  std::stop_token stop_;
  Console& console_;
  RunReport& report_;
  AlignInputs loaded_;
};

}  // namespace

const char* to_string(AlignKind kind) {
  switch (kind) {
    case AlignKind::kRange: return "range scan";
    case AlignKind::kRecording: return "recording";
    case AlignKind::kMesh: return "mesh";
    case AlignKind::kCloud: return "point cloud";
  }
  return "";
}

Result<AlignInputs> load_align_inputs(const std::vector<fs::path>& paths, const Config& config, std::stop_token stop,
                                      Console& console, RunReport& report) {
  InputLoader loader(config, stop, console, report);
  for (const fs::path& path : paths) {
    if (auto loaded = loader.load(path); !loaded) return loaded.error();
  }
  AlignInputs inputs = loader.take();
  if (inputs.inputs.size() > config.acquire.limits.max_scans) {
    return Error{ErrorCode::kInput, fmt::format("{} scans, more than the limit of {}", inputs.inputs.size(),
                                                config.acquire.limits.max_scans)};
  }
  return inputs;
}

}  // namespace scanknit
