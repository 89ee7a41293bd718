#include "scan/mesh/finish_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "core/files/quantity.h"
#include "core/mesh/mesh_area.h"
#include "export/mesh/up_rotation.h"
#include "finish/close_volume.h"
#include "finish/coarse_volume.h"
#include "finish/invented.h"
#include "finish/mesh_steps.h"
#include "scan/mesh/drop_crumbs.h"
#include "scan/mesh/fit_band.h"
#include "scan/mesh/memory_left.h"
#include "scan/mesh/vertex_uncertainty.h"
#include "scan/stage_times.h"

namespace scanknit {
namespace {

using Figures = std::map<std::string, double>;

constexpr double kSquareMillimetres = 1e6;  // a square metre
constexpr double kMillimetres = 1e3;
constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kGroundVoxels = 2;  // voxels: the tolerance of points on the ground, and the clearance above it
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::AlignedBox3d crop_box(const CropLimits& limits) {
  Eigen::AlignedBox3d box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    box.min()[static_cast<int>(axis)] = limits.low_m[axis].value_or(-kInfinity);
    box.max()[static_cast<int>(axis)] = limits.high_m[axis].value_or(kInfinity);
  }
  return box;
}

Eigen::AlignedBox3d bounds_of(const Mesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : mesh.positions_m) box.extend(p.cast<double>());
  return box;
}

/// The volume's samples within the box; nothing when the axes of volume and world are not parallel.
std::optional<openvdb::CoordBBox> samples_within(const Eigen::AlignedBox3d& box, const openvdb::FloatGrid& field) {
  constexpr double kFarthest = 1e9;  // the box may be unbounded
  constexpr double kAcross = 1e-6;   // of a voxel
  const openvdb::Vec3d origin = field.indexToWorld(openvdb::Vec3d(0, 0, 0));
  openvdb::CoordBBox samples;
  for (int axis = 0; axis < 3; ++axis) {
    openvdb::Vec3d one(0, 0, 0);
    one[axis] = 1;
    openvdb::Vec3d step = field.indexToWorld(one) - origin;
    const double along = step[axis];  // negative in a mirrored volume
    step[axis] = 0;
    if (step.length() > kAcross * std::abs(along)) return std::nullopt;
    const auto index = [&](double metres) {
      return std::clamp((metres - origin[axis]) / along, -kFarthest, kFarthest);
    };
    const auto [least, most] = std::minmax({index(box.min()[axis]), index(box.max()[axis])});
    samples.min()[axis] = static_cast<int>(std::ceil(least));
    samples.max()[axis] = static_cast<int>(std::floor(most));
  }
  return samples;
}

/// Signed distance to the box, positive outside.
double beyond_m(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& p) {
  return std::max((box.min() - p).maxCoeff(), (p - box.max()).maxCoeff());
}

class SurfaceFinisher {
 public:
  SurfaceFinisher(const FinishRequest& request, ScanSession& session)
      : config_(request.config),
        settings_(request.config.finish),
        up_(request.config.output.world_up.value_or(request.world_up)),
        metres_per_unit_(request.metres_per_unit),
        session_(session),
        frames_(request.frames),
        on_volume_read_(request.on_volume_read),
        view_sigma_m_(request.view_sigma_m),
        coarseness_(request.coarseness) {
    if (!request.stop.stop_requested()) stop_ = request.stop;
    if (settings_.is_anything()) made_.steps.emplace();
  }

  /// To be called once, as from_mesh().
  [[nodiscard]] FinishedSurface from_volume(const FieldView& whole) {
    held_bytes_ = bytes_of(whole);
    made_.outcome = extract_and_close(whole);
    if (made_.outcome && needs_coarser_ > 1) finish_coarser(whole);
    if (!made_.outcome) return std::move(made_);
    coarse_.reset();
    held_bytes_ -= std::exchange(coarse_bytes_, 0);
    if (!view_sigma_m_ && !made_.surface.mesh.empty()) let_go_of_volume();
    finish(made_.surface.mesh);
    if (view_sigma_m_) session_.timed("finish", [&] { estimate_uncertainty(whole); });
    return std::move(made_);
  }

  [[nodiscard]] FinishedSurface from_mesh(Surface surface) {
    made_.surface = std::move(surface);
    finish(made_.surface.mesh);
    return std::move(made_);
  }

 private:
  [[nodiscard]] Result<void> extract_and_close(const FieldView& whole) {
    if (auto sound = check(whole); !sound) return sound;
    FieldView view = whole;
    auto extracted = cropped(view);
    if (!extracted) return extracted.error();
    Surface& surface = made_.surface = *std::move(extracted);
    if (surface.mesh.empty() || !settings_.is_anything()) return {};
    find_ground_of(surface.mesh, view.field->voxelSize().x());
    if (auto cut = cut_ground(view, surface); !cut) return cut;
    if (auto closed = close(view, surface); !closed || needs_coarser_ > 1) return closed;
    choose_coarser_to_simplify(view, surface.mesh);
    return {};
  }

  [[nodiscard]] bool frees_volume() const { return on_volume_read_ != nullptr && !view_sigma_m_; }

  /// Whether volume and meshes leave `bytes_at(n)` for a step that works on n times larger voxels, or on their mesh;
  /// the least n for which they do, if the band of known distances allows any.
  template <typename BytesAt>
  [[nodiscard]] std::optional<int> fitting_coarseness(const Mesh& mesh, const BytesAt& bytes_at) const {
    for (int n = 2; n * coarseness_ <= config_.fusion.truncation_voxels; ++n) {
      const auto of = [n](std::size_t bytes, int power) { return static_cast<double>(bytes) / std::pow(n, power); };
      const double held = (frees_volume() ? 0 : static_cast<double>(held_bytes_)) + of(held_bytes_, 3);
      const double left = static_cast<double>(memory_left_bytes(config_.fusion.memory_budget_mib, 0));
      if (held + 2 * of(bytes_of(mesh), 2) + bytes_at(n) <= left) return n;
    }
    return std::nullopt;
  }

  /// The mesh is made again of n times larger voxels, for a step that the memory does not allow otherwise.
  void take_coarser(FinishStep step, const std::string& reason, int n, const FieldView& view) {
    needs_coarser_ = n;
    warn(step, fmt::format("finish: {}. The mesh is made of voxels of {} instead", reason,
                           format_length(n * view.field->voxelSize().x())));
  }

  void choose_coarser_to_simplify(const FieldView& view, const Mesh& mesh) {
    constexpr double kLeastToSimplify = 2;  // times the triangles that are asked for
    const auto refused = too_large_to_simplify(mesh, config_, frees_volume() ? 0 : held_bytes_);
    if (!refused || coarseness_ > 1) return;
    const auto n = fitting_coarseness(
        mesh, [&](int step) { return static_cast<double>(simplify_bytes(mesh)) / std::pow(step, 2); });
    const double least = kLeastToSimplify * static_cast<double>(settings_.triangles.value_or(0));
    if (n && static_cast<double>(mesh.triangles.size()) / std::pow(*n, 2) >= least) {
      take_coarser(FinishStep::kSimplify, *refused, *n, view);
    }
  }

  /// Begins again with a volume of larger voxels.
  void finish_coarser(const FieldView& whole) {
    coarse_.emplace(whole, needs_coarser_);
    coarse_->add(whole, config_.extract.min_weight);
    coarseness_ *= std::exchange(needs_coarser_, 1);
    made_.surface = {};
    made_.steps.emplace();
    ground_.reset();
    if (!view_sigma_m_) let_go_of_volume();
    const FieldView view = coarse_->finish();
    held_bytes_ += coarse_bytes_ = bytes_of(view);
    made_.outcome = extract_and_close(view);
  }

  /// The steps that follow take memory of their own.
  void let_go_of_volume() {
    seen_.reset();
    without_ground_.reset();
    const auto on_volume_read = std::exchange(on_volume_read_, nullptr);
    if (!on_volume_read) return;
    on_volume_read();
    held_bytes_ = 0;
  }

  void finish(Mesh& mesh) {
    if (mesh.empty()) return;
    if (settings_.drops_crumbs) session_.timed("finish", [&] { remove_crumbs(mesh); });
    if (!settings_.is_anything()) return;
    session_.timed("finish", [&] {
      drop_pieces(mesh);
      smooth(mesh);
      simplify(mesh);
      place(mesh);
    });
  }

  /// The finished mesh's: what moved a vertex has not moved what is known of the place.
  void estimate_uncertainty(const FieldView& view) {
    if (!config_.output.uncertainty || !view_sigma_m_ || (view.weight == nullptr && view.weight_codes == nullptr))
      return;
    const Mesh& mesh = made_.surface.mesh;
    VertexEvidence evidence(mesh.positions_m.size());
    add_evidence(mesh, made_.T_mesh_world().inverse(), view, evidence);
    made_.uncertainty_m = uncertainties_m(evidence, {*view_sigma_m_, view.field->voxelSize().x()});
  }

  void note(FinishStep step, Figures figures) {
    if (!made_.steps) made_.steps.emplace();
    made_.steps->steps.push_back({step, "", std::move(figures)});
  }

  void warn(FinishStep step, std::string text) {
    made_.warnings.push_back(session_.warn_of_mesh(WarningCode::kFinishStep, to_string(step), std::move(text)));
  }

  void refuse(FinishStep step, const std::string& reason) {
    made_.steps->steps.push_back({step, reason, {}});
    warn(step, fmt::format("finish: {} was not done: {}", to_string(step), reason));
  }

  /// When a stop is requested, notes `step` as not done.
  [[nodiscard]] bool is_stopped(FinishStep step) {
    if (!stop_.stop_requested()) return false;
    refuse(step, "interrupted");
    return true;
  }

  [[nodiscard]] Result<void> check(const FieldView& view) const {
    const bool needs_distances = settings_.watertight != Watertight::kOff || settings_.ground != GroundMode::kKeep;
    const bool is_matter_low = !is_inside_high(config_.extract.inside, view.is_signed_distance);
    if (!needs_distances || (view.is_signed_distance && is_matter_low)) return {};
    return Error{ErrorCode::kConfig,
                 "finish.watertight and finish.ground work on signed distances, with matter below the isovalue "
                 "(scans, VDB level sets); leave them out for this volume",
                 "finish"};
  }

  [[nodiscard]] Result<Surface> extract(const FieldView& view) {
    return session_.timed("extract", [&] { return extract_surface(view, config_.extract); });
  }

  /// Narrows the view to the crop box.
  [[nodiscard]] Result<Surface> cropped(FieldView& view) {
    if (!settings_.crop.is_set()) return extract(view);
    auto whole = extract(view);
    if (!whole || whole->mesh.empty()) return whole;
    const auto region_before = view.region;
    auto region = samples_within(crop_box(settings_.crop), *view.field);
    if (!region) {
      refuse(FinishStep::kCrop,
             "finish.crop lies along the axes of the world, and those of this volume are turned against them");
      return whole;
    }
    if (view.region) region->intersect(*view.region);
    view.region = region;
    auto part = extract(view);
    if (!part) return part;
    if (part->mesh.empty()) {
      refuse(FinishStep::kCrop,
             "nothing of the scan lies within finish.crop, whose limits are metres in the recording's world");
      view.region = region_before;
      return whole;
    }
    note(FinishStep::kCrop, {{"triangles_before", static_cast<double>(whole->mesh.triangles.size())},
                             {"triangles", static_cast<double>(part->mesh.triangles.size())},
                             {"area_removed_mm2", (area_m2(whole->mesh) - area_m2(part->mesh)) * kSquareMillimetres}});
    return part;
  }

  void find_ground_of(const Mesh& mesh, double voxel_m) {
    if (!settings_.needs_plane() || is_stopped(FinishStep::kGround)) return;
    GroundSearch search;
    search.expected_up = direction(up_).cast<double>();
    search.tolerance_m = kGroundVoxels * voxel_m;
    const auto found = session_.timed("finish", [&] { return find_ground(mesh, search); });
    if (!found) return refuse(FinishStep::kGround, found.error().text());
    ground_ = *found;
    clearance_m_ = settings_.ground_clearance_m.value_or(kGroundVoxels * voxel_m);
    if (!ground_) {
      refuse(FinishStep::kGround,
             "no plane that could be a table or a floor was found: it must face the world's up within 45 "
             "degrees (export.world_up), be a twentieth of the surface, and reach beyond what stands on it");
    }
  }

  /// Signed distance to the ground's cut, metres; positive below, where matter is cut away.
  [[nodiscard]] double below_ground_m(const Eigen::Vector3d& p) const {
    return ground_ && settings_.ground != GroundMode::kKeep ? clearance_m_ - ground_->height_m(p) : -kInfinity;
  }

  [[nodiscard]] std::string why_nothing_is_above() const {
    const std::size_t least = config_.extract.min_component_triangles;
    return fmt::format(
        "the cut would leave nothing: no {} lies more than {:.4g} mm (finish.ground_clearance) above the plane that "
        "was found; finish.ground cuts nothing away{}",
        least > 1 ? fmt::format("piece of {} triangles (extract.min_component_triangles) or more", least) : "surface",
        clearance_m_ * kMillimetres,
        settings_.up == UpMode::kGround ? ", and finish.up: ground does not turn the mesh" : "");
  }

  /// Replaces the view by one of a volume without the ground. If that has no surface, keeps the view and warns.
  [[nodiscard]] Result<void> cut_ground(FieldView& view, Surface& surface) {
    if (!ground_) return {};
    Figures figures = {{"plane_area_mm2", ground_->area_m2 * kSquareMillimetres},
                       {"plane_rms_mm", ground_->rms_m * kMillimetres},
                       {"tilt_degrees", ground_->tilt_rad * kDegrees}};
    if (settings_.ground != GroundMode::kKeep) {
      without_ground_ = session_.timed("finish", [&] {
        return cut_open(view, config_.extract.min_weight,
                        [this](const Eigen::Vector3d& p) { return below_ground_m(p); });
      });
      const FieldView cut = view.with_field(*without_ground_);
      auto above = extract(cut);
      if (!above) return above.error();
      if (above->mesh.empty()) {
        refuse(FinishStep::kGround, why_nothing_is_above());
        ground_.reset();
        return {};
      }
      seen_ = std::exchange(view, cut);
      figures["area_removed_mm2"] = (area_m2(surface.mesh) - area_m2(above->mesh)) * kSquareMillimetres;
      surface = *std::move(above);
    }
    note(FinishStep::kGround, std::move(figures));
    return {};
  }

  [[nodiscard]] CloseRequest close_request(const FieldView& view, const Mesh& open) const {
    CloseRequest request;
    request.min_weight = config_.extract.min_weight;
    request.isovalue_m = config_.extract.isovalue;
    request.band_voxels = config_.fusion.truncation_voxels / coarseness_;
    request.is_outside_free = settings_.watertight == Watertight::kFull;
    request.memory_bytes = memory_left_bytes(config_.fusion.memory_budget_mib, held_bytes_ + bytes_of(open));
    Mesh pieces = open;  // the box need not hold pieces that will be removed
    (void)remove_small_pieces(settings_.min_piece_share, settings_.min_piece_size_m, pieces);
    request.surface = bounds_of(pieces);
    if (!request.is_outside_free) return request;
    const bool is_cut = ground_ && settings_.ground != GroundMode::kKeep;
    if (!is_cut && !view.region) return request;
    Eigen::AlignedBox3d box = crop_box(settings_.crop);
    if (view.region) {  // the region may be the live view's crop box
      const openvdb::Vec3d low = view.field->indexToWorld(view.region->min());
      const openvdb::Vec3d high = view.field->indexToWorld(view.region->max());
      box = Eigen::AlignedBox3d(Eigen::Vector3d(low.x(), low.y(), low.z()),
                                Eigen::Vector3d(high.x(), high.y(), high.z()));
    }
    request.cut_m = [this, box](const Eigen::Vector3d& p) { return std::max(beyond_m(box, p), below_ground_m(p)); };
    return request;
  }

  /// Of n times larger voxels: about what close_volume() takes.
  [[nodiscard]] static double bytes_to_close(const FieldView& view, const CloseRequest& request, int n) {
    constexpr double kBytesPerVoxel = 30;  // all of them near the surface
    const double rim = request.band_voxels / n + 8;
    const Eigen::Array3d voxels = request.surface.sizes().array() / (n * view.field->voxelSize().x()) + 2 * rim;
    return kBytesPerVoxel * voxels.prod();
  }

  [[nodiscard]] Result<void> close(const FieldView& view, Surface& surface) {
    if (settings_.watertight == Watertight::kOff || is_stopped(FinishStep::kWatertight)) return {};
    const bool is_full = settings_.watertight == Watertight::kFull;
    // The ground is cut by a plane. Extraction needs the distances below that plane.
    const FieldView& source = is_full && seen_ ? *seen_ : view;
    const CloseRequest request = close_request(view, surface.mesh);
    const auto closed = session_.timed("finish", [&] { return close_volume(source, request); });
    if (!closed) {
      const auto n = fitting_coarseness(surface.mesh, [&](int step) { return bytes_to_close(view, request, step); });
      const bool is_too_large = closed.error().code == ErrorCode::kBudget;
      if (is_too_large && n)
        return take_coarser(FinishStep::kWatertight, closed.error().message, *n, view), Result<void>();
      return refuse(FinishStep::kWatertight, closed.error().message), Result<void>();
    }
    FieldView closed_view = view.with_field(*closed->field);
    if (is_full) closed_view.region.reset();
    auto meshed = extract(closed_view);
    if (!meshed) return meshed.error();
    const StageTimer timer(session_.times()["finish"]);
    const std::size_t open_edges = check_mesh(surface.mesh).boundary_edges;
    std::vector<std::uint8_t> invented = invented_triangles(meshed->mesh, *closed);
    Figures figures;
    if (!is_full) {
      const PatchCount patches = keep_small_patches(settings_.max_hole_m, meshed->mesh, invented);
      figures["holes_closed"] = static_cast<double>(patches.kept);
      figures["holes_left"] = static_cast<double>(patches.left_open);
    }
    drop_invented_pieces(config_.extract.min_component_triangles, meshed->mesh, invented);
    if (meshed->mesh.empty()) {
      refuse(FinishStep::kWatertight,
             "the closed mesh would have no surface that a frame saw; the mesh stays as it was");
      return {};
    }
    const double invented_m2 = area_m2(meshed->mesh, invented);
    figures["invented_area_mm2"] = invented_m2 * kSquareMillimetres;
    figures["invented_share"] = invented_m2 / std::max(area_m2(meshed->mesh), 1e-30);
    figures["boundary_edges_before"] = static_cast<double>(open_edges);
    figures["boundary_edges"] = static_cast<double>(check_mesh(meshed->mesh).boundary_edges);
    note(FinishStep::kWatertight, std::move(figures));
    left_out_ = count_removed(surface.mesh, triangles_left_out(surface.mesh, meshed->mesh, *closed));
    if (settings_.invented_colour) paint_invented(invented, *settings_.invented_colour, meshed->mesh);
    surface = *std::move(meshed);
    return {};
  }

  void note_removed(FinishStep step, const PiecesRemoved& removed) {
    note(step, {{"pieces_removed", static_cast<double>(removed.pieces)},
                {"triangles_removed", static_cast<double>(removed.triangles)},
                {"area_removed_mm2", removed.area_m2 * metres_per_unit_ * metres_per_unit_ * kSquareMillimetres}});
  }

  /// Is on by default: notes nothing when there are no crumbs.
  void remove_crumbs(Mesh& mesh) {
    if (stop_.stop_requested()) return;
    const PiecesRemoved removed = drop_crumbs(frames_, fit_band_of(config_.fusion), mesh);
    if (removed.pieces > 0) note_removed(FinishStep::kCrumbs, removed);
  }

  void drop_pieces(Mesh& mesh) {
    if (!(settings_.min_piece_share > 0) && !(settings_.min_piece_size_m > 0)) return;
    if (is_stopped(FinishStep::kPieces)) return;
    PiecesRemoved removed =
        remove_small_pieces(settings_.min_piece_share, settings_.min_piece_size_m / metres_per_unit_, mesh);
    removed.pieces += left_out_.pieces;
    removed.triangles += left_out_.triangles;
    removed.area_m2 += left_out_.area_m2;
    note_removed(FinishStep::kPieces, removed);
  }

  void smooth(Mesh& mesh) {
    if (settings_.smooth_steps == 0 || is_stopped(FinishStep::kSmooth)) return;
    const double before = signed_volume_m3(mesh);
    const MeshMoved moved = smooth_mesh(settings_.smooth_steps, mesh, stop_);
    if (moved.is_stopped && is_stopped(FinishStep::kSmooth)) return;
    const double change = before == 0 ? 0 : signed_volume_m3(mesh) / before - 1;
    note(FinishStep::kSmooth, {{"mean_moved_mm", moved.mean_m * metres_per_unit_ * kMillimetres},
                               {"max_moved_mm", moved.max_m * metres_per_unit_ * kMillimetres},
                               {"volume_change_share", change}});
  }

  void simplify(Mesh& mesh) {
    if ((!settings_.triangles && !settings_.simplify_error_m) || is_stopped(FinishStep::kSimplify)) return;
    if (const auto refused = too_large_to_simplify(mesh, config_, held_bytes_)) {
      return refuse(FinishStep::kSimplify, *refused);
    }
    SimplifyTarget target{settings_.triangles, settings_.simplify_error_m};
    if (target.max_error_m) *target.max_error_m /= metres_per_unit_;
    const MeshSimplified done = simplify_mesh(target, mesh);
    note(FinishStep::kSimplify, {{"triangles_before", static_cast<double>(done.triangles_before)},
                                 {"triangles", static_cast<double>(done.triangles)},
                                 {"pieces_lost", static_cast<double>(done.pieces_lost)},
                                 {"error_mm", done.error_m * metres_per_unit_ * kMillimetres}});
    if (!done.is_held_back) return;
    warn(FinishStep::kSimplify,
         fmt::format("finish: the mesh was simplified to {} triangles only: with fewer it would no longer "
                     "be closed or manifold",
                     done.triangles));
  }

  void place(Mesh& mesh) {
    const bool turns = settings_.up == UpMode::kGround && ground_;
    const bool moves = settings_.origin == OriginMode::kGround;
    if ((!turns && !moves) || is_stopped(FinishStep::kPlace)) return;
    Pose T = Pose::Identity();
    const Eigen::Vector3d up = direction(up_).cast<double>();
    if (turns) T = turn_up(ground_->up, up);
    if (turns) transform_mesh(T, mesh);
    if (moves) {
      const Pose shift = stand_on_origin(mesh, up);
      transform_mesh(shift, mesh);
      T = shift * T;
    }
    made_.steps->T_mesh_world = T;
    note(FinishStep::kPlace, {{"turned_degrees", Eigen::AngleAxisd(T.linear()).angle() * kDegrees},
                              {"moved_mm", T.translation().norm() * metres_per_unit_ * kMillimetres}});
  }

  const ScanConfig& config_;
  const FinishConfig& settings_;
  UpAxis up_;
  double metres_per_unit_;
  ScanSession& session_;
  FinishedSurface made_;
  std::span<const PosedDepth> frames_;
  std::function<void()> on_volume_read_;
  std::optional<double> view_sigma_m_;
  std::stop_token stop_;        ///< empty when the stop was requested before the finishing
  std::size_t held_bytes_ = 0;  ///< of the volume
  int coarseness_ = 1;          ///< of the view: FinishRequest::coarseness
  int needs_coarser_ = 1;       ///< a step needs so many times larger voxels
  std::optional<CoarseVolume> coarse_;
  std::size_t coarse_bytes_ = 0;  ///< of held_bytes_
  std::optional<GroundPlane> ground_;
  double clearance_m_ = 0;
  openvdb::FloatGrid::Ptr without_ground_;  ///< the view refers to it
  std::optional<FieldView> seen_;           ///< the view before the ground was cut
  PiecesRemoved left_out_;                  ///< what closing left out of the mesh; metres, as only scans are closed
};

}  // namespace

FinishedSurface finished_surface(const FieldView& view, const FinishRequest& request, ScanSession& session) {
  return SurfaceFinisher(request, session).from_volume(view);
}

FinishedSurface finished_mesh(Surface surface, const FinishRequest& request, ScanSession& session) {
  const FinishConfig& config = request.config.finish;
  if (config.changes_volume() || config.needs_plane()) {
    const Error error{
        ErrorCode::kConfig,
        "finish.crop, finish.ground, finish.watertight and finish.up: ground work on scans and .vdb only; leave "
        "them out for this volume",
        "finish"};
    return {.outcome = error, .surface = {}, .steps = {}, .warnings = {}};
  }
  return SurfaceFinisher(request, session).from_mesh(std::move(surface));
}

Result<void> refuse_to_finish_streamed(const FinishConfig& config) {
  if (!config.is_anything()) return {};
  return Error{ErrorCode::kConfig,
               "the volume is read a few slices at a time, and its mesh goes to disk: no step of finish: is possible. "
               "Raise extract.memory_budget so that it is meshed whole, or leave finish: out",
               "finish"};
}

}  // namespace scanknit
