#include "app/scan/extract_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "app/config/config_print.h"
#include "app/config/quantity.h"
#include "app/scan/finish_surface.h"
#include "app/scan/mesh_output.h"
#include "app/scan/stage_timer.h"
#include "app/scan/vdb_grids.h"
#include "app/scan/volume_values.h"
#include "export/picture/preview.h"
#include "export/spill/mesh_spill.h"
#include "extract/extract_surface.h"
#include "extract/stream_surface.h"
#include "fusion/volume/tsdf_volume.h"

namespace scanknit {
namespace {

constexpr std::int64_t kMebibyte = 1 << 20;
constexpr std::size_t kPictureVertices = 500'000;    // more than a picture shows
constexpr std::size_t kBytesPerPictureVertex = 256;  // with its triangles, and what finds it

Error which_isovalue(const ValueCensus& census, const Job& job) {
  if (census.count() == 0) return {ErrorCode::kInput, kNoFiniteSample, job.input.string()};
  return {ErrorCode::kUsage,
          fmt::format("which isovalue? Its values lie {}: give --isovalue X, or --auto-isovalue to have one proposed",
                      range_text(census)),
          job.input.string()};
}

/// Sets job.config.extract.isovalue as `wish` says.
Result<void> choose_isovalue(IsovalueWish wish, const ValueSource& values, bool is_signed_distance, Job& job,
                             Console& console, RunReport& report) {
  double& isovalue = job.config.extract.isovalue;
  std::string& source = report.extract.isovalue_source;
  if (wish == IsovalueWish::kGiven) {
    source = "config";
  } else if (is_signed_distance) {
    isovalue = 0;
    source = "signed_distance";
    if (wish == IsovalueWish::kAuto) console.info("isovalue 0: the volume holds signed distances");
  } else if (wish == IsovalueWish::kAuto) {
    const auto proposed = timed(report, "read", [&] { return propose_isovalue(values); });
    if (!proposed) return Error{proposed.error().code, proposed.error().message, job.input.string()};
    isovalue = *proposed;
    source = "otsu";
    console.info(fmt::format("isovalue {}, proposed by Otsu's method (1979); --isovalue X gives another",
                             format_number(isovalue)));
  } else {
    const auto census = timed(report, "read", [&] { return take_census(values); });
    return census ? which_isovalue(*census, job) : census.error();
  }
  report.extract.isovalue = isovalue;
  report.config_json = config_to_json(job.config);
  return {};
}

/// An empty mesh most often is an isovalue beyond the values: says where they lie.
Result<void> with_values(Result<void> result, const ValueSource& values) {
  if (result || result.error().code != ErrorCode::kMesh) return result;
  const auto census = take_census(values);
  if (!census) return result;
  const std::string where_they_lie =
      census->count() == 0 ? kNoFiniteSample : "the volume's values lie " + range_text(*census);
  return Error{ErrorCode::kMesh, fmt::format("{}; {}", result.error().message, where_they_lie), result.error().where};
}

/// The grids of floats in the file that were not taken.
void warn_of_other_grids(const std::filesystem::path& path, const LoadedVolume& volume, Console& console) {
  std::string others;
  for (const std::string& name : other_float_grids(path, volume)) {
    others += (others.empty() ? "'" : ", '") + name + "'";
  }
  if (others.empty()) return;
  console.warn(fmt::format("the file has several grids of floats: '{}' is meshed; left out: {}",
                           volume.field->getName(), others));
}

Result<void> extract_vdb(Job job, const VolumeRequest& request, const std::stop_token& stop, Console& console,
                         RunReport& report) {
  if (auto known = refuse_options_for_vdb(job.input, request.options); !known) return known;
  const auto volume = timed(report, "read", [&] { return load_volume(job.input); });
  if (!volume) return volume.error();
  warn_of_other_grids(job.input, *volume, console);
  describe_volume(*volume, report);
  const ValueSource values = values_of(*volume->field);
  if (auto chosen = choose_isovalue(request.isovalue, values, volume->is_signed_distance, job, console, report);
      !chosen) {
    return chosen;
  }
  // Volumes of ours lie in a camera's world, y down; elsewhere z is up (Blender) more often than not.
  const UpAxis world_up = volume->weight ? UpAxis::kMinusY : UpAxis::kZ;
  const std::size_t told = report.warnings.size();
  const auto finished = finished_surface(volume->field_view(), job.config, world_up, report, stop);
  say_warnings(report, told, console);
  if (!finished) return finished.error();
  return with_values(write_surface(finished->surface, {world_up, std::nullopt, std::nullopt}, job, report), values);
}

std::size_t budget_bytes(const ExtractConfig& config) {
  return static_cast<std::size_t>(config.memory_budget_mib * kMebibyte);
}

/// The readers do not know what their options are called here.
Error naming_options(Error error, const std::filesystem::path& path) {
  if (error.code == ErrorCode::kUsage) error.message += " (see --dims, --type and --spacing)";
  if (error.code == ErrorCode::kBudget) error.message += " (--set extract.memory_budget=SIZE)";
  if (error.where.empty()) error.where = path.string();
  return error;
}

double sample_bytes(const VolumeHeader& header) {
  return sizeof(float) * header.dims.cast<double>().prod();
}

/// The mesh is taken to need as much as the samples. A volume that could not be read in parts already is in memory.
bool needs_streaming(const SliceReader& reader, const ExtractConfig& config) {
  return reader.is_streamed() &&
         2 * sample_bytes(reader.header()) > static_cast<double>(config.memory_budget_mib * kMebibyte);
}

Error needs_whole_mesh(const std::filesystem::path& path, const VolumeHeader& header, const ExtractConfig& config) {
  const auto needed_mib = static_cast<std::int64_t>(std::ceil(2 * sample_bytes(header) / kMebibyte));
  return {ErrorCode::kBudget,
          fmt::format("the volume and its mesh need about {} MiB, more than extract.memory_budget ({}); within it the "
                      "mesh can be written as .ply or .stl only: name one with -o, or raise the budget: "
                      "--set extract.memory_budget={}MiB",
                      needed_mib, format_memory_mib(config.memory_budget_mib), needed_mib),
          path.string()};
}

Result<void> write_spilled(const MeshSpill& mesh, const MeshFrame& frame, const Job& job, RunReport& report) {
  for (const std::filesystem::path& path : job.outputs.meshes) {
    const auto written =
        timed(report, "export", [&] { return mesh.write(path, job.config.output, frame.world_up, frame.file_unit_m); });
    if (!written) return written.error();
    report.files[path.extension().string().substr(1)] = path.string();
  }
  return {};
}

/// Of the mesh made so coarse that it fits into memory.
Result<void> draw_spilled(const MeshSpill& mesh, const MeshFrame& frame, const Job& job, RunReport& report) {
  if (!job.outputs.preview) return {};
  const std::size_t vertices = std::min(kPictureVertices, budget_bytes(job.config.extract) / kBytesPerPictureVertex);
  const auto coarse = timed(report, "export", [&] { return mesh.coarse(vertices); });
  if (!coarse) return coarse.error();
  const UpAxis up = job.config.output.world_up.value_or(frame.world_up);
  const ColourImage picture = timed(report, "export", [&] { return render_preview(*coarse, up); });
  report.files["preview"] = job.outputs.preview->string();
  return timed(report, "write", [&] { return write_png(picture, *job.outputs.preview); });
}

Result<void> stream_volume(SliceReader& reader, const MeshFrame& frame, const Job& job, Console& console,
                           RunReport& report) {
  const ExtractConfig& config = job.config.extract;
  if (auto nothing = refuse_to_finish_streamed(job.config.finish); !nothing) return nothing;
  for (const std::filesystem::path& path : job.outputs.meshes) {
    if (!can_be_written_in_parts(path)) return needs_whole_mesh(path, reader.header(), config);
  }
  if (config.min_component_triangles > 1) {
    console.warn("extract.min_component_triangles: small pieces stay in a mesh that is streamed");
  }
  const auto first = job.outputs.meshes.begin();
  auto mesh = MeshSpill::create(first == job.outputs.meshes.end() ? std::filesystem::temp_directory_path()
                                                                  : std::filesystem::absolute(*first).parent_path());
  if (!mesh) return mesh.error();
  const auto add = [&mesh](const Mesh& part) { return mesh->add(part); };
  const auto streamed =
      timed(report, "extract", [&] { return stream_surface(reader, reader.header().T_file_index, config, add); });
  if (!streamed) return streamed.error();

  describe_cases(streamed->cases, report);
  report.is_mesh_checked = false;
  report.mesh.emplace();
  report.mesh->vertices = mesh->vertices();
  report.mesh->triangles = mesh->triangles();
  if (mesh->triangles() == 0) return empty_mesh_error(job);
  report.mesh->min_m = mesh->bounds().min() * static_cast<float>(reader.header().metres_per_unit);
  report.mesh->max_m = mesh->bounds().max() * static_cast<float>(reader.header().metres_per_unit);
  if (auto written = write_spilled(*mesh, frame, job, report); !written) return written;
  return draw_spilled(*mesh, frame, job, report);
}

Result<void> extract_whole(const DenseVolume& volume, const MeshFrame& frame, const Job& job,
                           const std::stop_token& stop, Console& console, RunReport& report) {
  const DenseView view{volume.samples.data(), volume.header.dims, volume.header.T_file_index};
  auto surface = timed(report, "extract", [&] { return extract_surface(view, job.config.extract); });
  if (!surface) return surface.error();
  const std::size_t told = report.warnings.size();
  const auto finished =
      finished_mesh(*std::move(surface), volume.header.metres_per_unit, job.config, frame.world_up, report, stop);
  say_warnings(report, told, console);
  if (!finished) return finished.error();
  return write_surface(finished->surface, frame, job, report);
}

Result<void> extract_file(Job job, const VolumeRequest& request, const std::stop_token& stop, Console& console,
                          RunReport& report) {
  auto reader = timed(report, "read", [&] { return open_volume_file(job.input, request.options, job.config.extract); });
  if (!reader) return reader.error();
  const VolumeHeader header = (*reader)->header();
  for (const std::string& warning : header.warnings) console.warn(warning);
  const bool is_streamed = needs_streaming(**reader, job.config.extract);
  describe_volume(header, is_streamed, report);
  const MeshFrame frame{UpAxis::kZ, std::nullopt, header.metres_per_unit};  // up in LPS and in RAS

  if (is_streamed) {
    const ValueSource values = values_of(**reader);
    if (auto chosen = choose_isovalue(request.isovalue, values, false, job, console, report); !chosen) return chosen;
    return with_values(stream_volume(**reader, frame, job, console, report), values);
  }
  const auto volume = timed(report, "read", [&] { return read_volume(**reader, budget_bytes(job.config.extract)); });
  if (!volume) return naming_options(volume.error(), job.input);
  reader->reset();  // a format that is decoded whole would else be in memory twice
  const ValueSource values = values_of(*volume);
  if (auto chosen = choose_isovalue(request.isovalue, values, false, job, console, report); !chosen) return chosen;
  return with_values(extract_whole(*volume, frame, job, stop, console, report), values);
}

}  // namespace

Result<void> extract_volume(Job job, const VolumeRequest& request, const std::stop_token& stop, Console& console,
                            RunReport& report) {
  if (auto writable = check_outputs(job.outputs); !writable) return writable;
  warn_of_holes(job.config.extract, console);
  return is_vdb(job.input) ? extract_vdb(std::move(job), request, stop, console, report)
                           : extract_file(std::move(job), request, stop, console, report);
}

Result<std::unique_ptr<SliceReader>> open_volume_file(const std::filesystem::path& path, VolumeOptions options,
                                                      const ExtractConfig& config) {
  options.memory_budget_bytes = budget_bytes(config);
  auto reader = open_volume(path, options);
  if (!reader) return naming_options(reader.error(), path);
  return reader;
}

bool is_vdb(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".vdb";
}

Result<void> refuse_options_for_vdb(const std::filesystem::path& path, const VolumeOptions& options) {
  if (!options.dims && !options.type && !options.spacing) return {};
  return Error{ErrorCode::kUsage, "--dims, --type and --spacing are for raw samples and stacks of images, not for .vdb",
               path.string()};
}

}  // namespace scanknit
