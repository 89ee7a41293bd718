#include "scan/volume/extract_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/files/quantity.h"
#include "export/picture/preview.h"
#include "export/spill/mesh_spill.h"
#include "extract/extract_surface.h"
#include "extract/stream_surface.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/checks/settings_check.h"
#include "scan/mesh/finish_surface.h"
#include "scan/mesh/write_surface.h"
#include "scan/volume/open_volume_file.h"
#include "scan/volume/vdb_grids.h"
#include "scan/volume/volume_values.h"

namespace scanknit {
namespace {

constexpr std::int64_t kMebibyte = 1 << 20;
constexpr std::size_t kPictureVertices = 500'000;    // a picture cannot show more
constexpr std::size_t kBytesPerPictureVertex = 256;  // with its triangles and the index of vertices

/// Describes the volume of a VDB file.
VolumeResult described(const LoadedVolume& volume) {
  const openvdb::FloatGrid& field = *volume.field;
  std::size_t bytes = field.memUsage();
  if (volume.weight) bytes += volume.weight->memUsage();
  if (volume.colour) bytes += volume.colour->memUsage();
  VolumeResult result;
  result.active_voxels = field.activeVoxelCount();
  result.blocks = field.tree().leafCount();
  result.memory_mib = static_cast<double>(bytes) / kMebibyte;
  result.voxel_size_m = field.voxelSize().x();
  result.format = "OpenVDB";
  return result;
}

/// Describes the volume of any other file.
VolumeResult described(const VolumeHeader& header, bool is_streamed) {
  VolumeResult result;
  const auto blocks = [](int samples) { return static_cast<std::size_t>((samples + 7) / 8); };
  result.active_voxels = 1;
  result.blocks = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto column = static_cast<Eigen::Index>(axis);
    result.dims[axis] = header.dims[column];
    result.spacing_m[axis] = header.T_file_index.linear().col(column).norm() * header.metres_per_unit;
    result.active_voxels *= static_cast<std::size_t>(header.dims[column]);
    result.blocks *= blocks(header.dims[column]);
  }
  result.format = header.format;
  result.voxel_size_m = *std::min_element(result.spacing_m.begin(), result.spacing_m.end());
  result.is_streamed = is_streamed;
  result.memory_mib = is_streamed ? 0 : static_cast<double>(result.active_voxels * sizeof(float)) / kMebibyte;
  return result;
}

/// Adds the range of the values to the error of an empty mesh, which is most often due to an isovalue outside of it.
Result<void> with_values(Result<void> result, const ValueSource& values) {
  if (result || result.error().code != ErrorCode::kMesh) return result;
  const auto census = take_census(values);
  if (!census) return result;
  const std::string where_they_lie =
      census->count() == 0 ? kNoFiniteSample : "the volume's values lie " + range_text(*census);
  return Error{ErrorCode::kMesh, fmt::format("{}; {}", result.error().message, where_they_lie), result.error().where};
}

std::size_t budget_bytes(const ExtractConfig& config) {
  return static_cast<std::size_t>(config.memory_budget_mib * kMebibyte);
}

double sample_bytes(const VolumeHeader& header) {
  return sizeof(float) * header.dims.cast<double>().prod();
}

/// True when the volume must be read in parts. Assumes that the mesh needs as much memory as the samples. A file that
/// cannot be read in parts is in memory already.
bool needs_streaming(const SliceReader& reader, const ExtractConfig& config) {
  return reader.is_streamed() &&
         2 * sample_bytes(reader.header()) > static_cast<double>(config.memory_budget_mib * kMebibyte);
}

Error needs_whole_mesh(const std::filesystem::path& path, const VolumeHeader& header, const ExtractConfig& config) {
  const auto needed_mib = static_cast<std::int64_t>(std::ceil(2 * sample_bytes(header) / kMebibyte));
  return {ErrorCode::kBudget,
          fmt::format("the volume and its mesh need about {} MiB, more than extract.memory_budget ({}). A .ply or .stl "
                      "file alone can be written within it; for other files set extract.memory_budget={}MiB",
                      needed_mib, format_memory_mib(config.memory_budget_mib), needed_mib),
          path.string()};
}

/// One volume file on its way to a mesh.
class VolumeExtraction {
 public:
  VolumeExtraction(const ScanJob& job, const VolumeRequest& request, ScanObserver& observer,
                   const std::stop_token& stop)
      : job_(job), request_(request), session_(observer, stop) {}

  [[nodiscard]] ScanResult run() {
    Result<void> outcome = extract();
    return session_.conclude(std::move(outcome), job_, std::move(result_));
  }

 private:
  [[nodiscard]] Result<void> extract() {
    warn_of_settings(job_, session_);
    if (auto writable = check_files(job_); !writable) return writable;
    return is_vdb(job_.input) ? extract_vdb() : extract_file();
  }

  [[nodiscard]] Result<void> extract_vdb() {
    if (auto known = refuse_options_for_vdb(job_.input, request_.options); !known) return known;
    const auto volume = session_.timed("read", [&] { return load_volume(job_.input); });
    if (!volume) return volume.error();
    warn_of_other_grids(*volume);
    result_.volume = described(*volume);
    const ValueSource values = values_of(*volume->field);
    if (auto chosen = choose_isovalue(values, volume->is_signed_distance); !chosen) return chosen;
    // ScanKnit's volumes are in a camera's world, y down. In other VDB files z is up more often than not (Blender).
    const UpAxis world_up = volume->weight ? UpAxis::kMinusY : UpAxis::kZ;
    FinishRequest finish{job_.config, world_up, 1, session_.stop()};
    finish.view_sigma_m = view_sigma_m(*volume);
    const FinishedSurface finished = finished_surface(volume->field_view(), finish, session_);
    const Result<void> written = write(finished, {world_up, std::nullopt, std::nullopt, {}, finished.uncertainty_m});
    return finished.outcome ? with_values(written, values) : written;
  }

  [[nodiscard]] Result<void> extract_file() {
    auto reader =
        session_.timed("read", [&] { return open_volume_file(job_.input, request_.options, job_.config.extract); });
    if (!reader) return reader.error();
    const VolumeHeader header = (*reader)->header();
    for (const std::string& warning : header.warnings) session_.warn(WarningCode::kVolumeFile, warning);
    const bool is_streamed = needs_streaming(**reader, job_.config.extract);
    result_.volume = described(header, is_streamed);
    const MeshFrame frame{UpAxis::kZ, std::nullopt, header.metres_per_unit};  // z is up in LPS and in RAS

    if (is_streamed) {
      const ValueSource values = values_of(**reader);
      if (auto chosen = choose_isovalue(values, false); !chosen) return chosen;
      return with_values(stream_volume(**reader, frame), values);
    }
    const auto volume =
        session_.timed("read", [&] { return read_volume(**reader, budget_bytes(job_.config.extract)); });
    if (!volume) return naming_options(volume.error(), job_.input);
    reader->reset();  // else a format that is decoded as a whole would be in memory twice
    const ValueSource values = values_of(*volume);
    if (auto chosen = choose_isovalue(values, false); !chosen) return chosen;
    return with_values(extract_whole(*volume, frame), values);
  }

  [[nodiscard]] Result<void> extract_whole(const DenseVolume& volume, const MeshFrame& frame) {
    const DenseView view{volume.samples.data(), volume.header.dims, volume.header.T_file_index};
    auto surface = session_.timed("extract", [&] { return extract_surface(view, job_.config.extract); });
    if (!surface) return surface.error();
    const FinishRequest finish{job_.config, frame.world_up, volume.header.metres_per_unit, session_.stop()};
    return write(finished_mesh(*std::move(surface), finish, session_), frame);
  }

  [[nodiscard]] Result<void> stream_volume(SliceReader& reader, const MeshFrame& frame) {
    const ExtractConfig& config = job_.config.extract;
    if (auto nothing = refuse_to_finish_streamed(job_.config.finish); !nothing) return nothing;
    for (const std::filesystem::path& path : job_.files.meshes) {
      if (!can_be_written_in_parts(path)) return needs_whole_mesh(path, reader.header(), config);
    }
    if (config.min_component_triangles > 1) {
      session_.warn(WarningCode::kVolumeFile,
                    "extract.min_component_triangles: small pieces stay in a mesh that is streamed");
    }
    const auto& meshes = job_.files.meshes;
    auto mesh = MeshSpill::create(meshes.empty() ? std::filesystem::temp_directory_path()
                                                 : std::filesystem::absolute(meshes.front()).parent_path());
    if (!mesh) return mesh.error();
    const auto add = [&mesh](const Mesh& part) { return mesh->add(part); };
    const auto streamed =
        session_.timed("extract", [&] { return stream_surface(reader, reader.header().T_file_index, config, add); });
    if (!streamed) return streamed.error();
    result_.mesh.cases = streamed->cases;
    if (auto checked = describe_spilled(*mesh, reader.header().metres_per_unit); !checked) return checked;
    if (auto written = write_spilled(*mesh, frame); !written) return written;
    return draw_spilled(*mesh, frame);
  }

  /// Describes a mesh that was never in memory as a whole.
  [[nodiscard]] Result<void> describe_spilled(const MeshSpill& mesh, double metres_per_unit) {
    result_.mesh.is_checked = false;
    MeshCheck& check = result_.mesh.check.emplace();
    check.vertices = mesh.vertices();
    check.triangles = mesh.triangles();
    if (mesh.triangles() == 0) return empty_mesh_error(job_);
    check.min_m = mesh.bounds().min() * static_cast<float>(metres_per_unit);
    check.max_m = mesh.bounds().max() * static_cast<float>(metres_per_unit);
    return {};
  }

  [[nodiscard]] Result<void> write_spilled(const MeshSpill& mesh, const MeshFrame& frame) {
    for (const std::filesystem::path& path : job_.files.meshes) {
      const auto written = session_.timed(
          "export", [&] { return mesh.write(path, job_.config.output, frame.world_up, frame.file_unit_m); });
      if (!written) return written.error();
      result_.mesh.files[path.extension().string().substr(1)] = path.string();
    }
    return {};
  }

  /// Draws a picture of the mesh, simplified until it fits into memory.
  [[nodiscard]] Result<void> draw_spilled(const MeshSpill& mesh, const MeshFrame& frame) {
    if (!job_.files.preview) return {};
    const std::size_t vertices = std::min(kPictureVertices, budget_bytes(job_.config.extract) / kBytesPerPictureVertex);
    const auto coarse = session_.timed("export", [&] { return mesh.coarse(vertices); });
    if (!coarse) return coarse.error();
    const UpAxis up = job_.config.output.world_up.value_or(frame.world_up);
    const ColourImage picture = session_.timed("export", [&] { return render_preview(*coarse, up); });
    result_.mesh.files["preview"] = job_.files.preview->string();
    return session_.timed("write", [&] { return write_png(picture, *job_.files.preview); });
  }

  [[nodiscard]] Result<void> write(const FinishedSurface& finished, const MeshFrame& frame) {
    add_to(result_.mesh, finished);
    if (!finished.outcome) return finished.outcome;
    WrittenSurface written = write_surface(finished.surface.mesh, frame, job_, session_);
    const Result<void> outcome = written.outcome;
    add_to(result_.mesh, std::move(written));
    return outcome;
  }

  /// Sets the isovalue that the request asks for.
  [[nodiscard]] Result<void> choose_isovalue(const ValueSource& values, bool is_signed_distance) {
    double& isovalue = job_.config.extract.isovalue;
    IsovalueSource& source = result_.mesh.isovalue_source;
    if (request_.isovalue == IsovalueSetting::kGiven) {
      source = IsovalueSource::kConfig;
    } else if (is_signed_distance) {
      isovalue = 0;
      source = IsovalueSource::kSignedDistance;
      if (request_.isovalue == IsovalueSetting::kAuto) session_.info("isovalue 0: the volume holds signed distances");
    } else if (request_.isovalue == IsovalueSetting::kAuto) {
      const auto proposed = session_.timed("read", [&] { return propose_isovalue(values); });
      if (!proposed) return Error{proposed.error().code, proposed.error().message, job_.input.string()};
      isovalue = *proposed;
      source = IsovalueSource::kOtsu;
      session_.info(fmt::format("isovalue {}, proposed by Otsu's method (1979); extract.isovalue sets another",
                                format_number(isovalue)));
    } else {
      const auto census = session_.timed("read", [&] { return take_census(values); });
      return census ? which_isovalue(*census) : census.error();
    }
    result_.mesh.isovalue = isovalue;
    return {};
  }

  [[nodiscard]] Error which_isovalue(const ValueCensus& census) const {
    if (census.count() == 0) return {ErrorCode::kInput, kNoFiniteSample, job_.input.string()};
    return {ErrorCode::kUsage,
            fmt::format("which isovalue? Its values lie {}: set extract.isovalue, or have one proposed (auto-isovalue)",
                        range_text(census)),
            job_.input.string()};
  }

  /// What the weights of a volume of ScanKnit are worth. Says so when the file does not: it may be another sensor's.
  [[nodiscard]] std::optional<double> view_sigma_m(const LoadedVolume& volume) {
    if (!volume.weight) return std::nullopt;
    if (const auto stated = volume.view_sigma_m()) return stated;
    const double floor_m = job_.config.fusion.noise.floor_m;
    if (job_.config.output.uncertainty) {
      session_.warn(
          WarningCode::kVolumeFile,
          fmt::format("the volume does not say how noisy its sensor was: export.uncertainty assumes {:.4g} mm at "
                      "best (fusion.noise.floor); `run --save-volume` with export.uncertainty writes it down",
                      floor_m * 1000));
    }
    return floor_m;
  }

  /// Warns of the float grids in the file that are not meshed.
  void warn_of_other_grids(const LoadedVolume& volume) {
    std::string others;
    for (const std::string& name : other_float_grids(job_.input, volume)) {
      others += (others.empty() ? "'" : ", '") + name + "'";
    }
    if (others.empty()) return;
    session_.warn(WarningCode::kVolumeFile,
                  fmt::format("the file has several grids of floats: '{}' is meshed; left out: {}",
                              volume.field->getName(), others));
  }

  ScanJob job_;
  const VolumeRequest& request_;
  ScanSession session_;
  ScanResult result_;
};

}  // namespace

ScanResult extract_volume(const ScanJob& job, const VolumeRequest& request, ScanObserver& observer,
                          std::stop_token stop) {
  return VolumeExtraction(job, request, observer, stop).run();
}

}  // namespace scanknit
