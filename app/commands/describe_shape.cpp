// describe_shape(): info of meshes and volumes.
#include <fmt/format.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Count.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "app/commands.h"
#include "core/mesh.h"
#include "export/measure/mesh_stats.h"
#include "export/mesh/read_mesh.h"
#include "export/mesh/write_mesh.h"
#include "export/spill/stitch_borders.h"
#include "fusion/volume/tsdf_volume.h"
#include "scan/volume/extract_volume.h"
#include "scan/volume/open_volume_file.h"
#include "scan/volume/volume_values.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

Json vector_json(const openvdb::Vec3d& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

Json volume_json(const LoadedVolume& volume) {
  const openvdb::FloatGrid& field = *volume.field;
  const openvdb::CoordBBox box = field.evalActiveVoxelBoundingBox();
  Json grids = Json::array({field.getName()});
  if (volume.weight) grids.push_back(volume.weight->getName());
  if (volume.colour) grids.push_back(volume.colour->getName());
  Json bounds = nullptr;
  if (!box.empty()) {
    bounds = Json::array({vector_json(field.indexToWorld(box.min())), vector_json(field.indexToWorld(box.max()))});
  }
  const openvdb::math::MinMax<float> values = openvdb::tools::minMax(field.tree());
  return {{"kind", "volume"},
          {"format", "OpenVDB"},
          {"grids", grids},
          {"voxel_size_m", field.voxelSize().x()},
          {"active_voxels", field.activeVoxelCount()},
          {"bounds_m", bounds},
          {"is_signed_distance", volume.is_signed_distance},
          {"value_range", box.empty() ? Json(nullptr) : Json::array({values.min(), values.max()})}};
}

Json vector_json(const Eigen::Vector3d& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

Result<Json> volume_json(SliceReader& reader) {
  const auto census = take_census(values_of(reader));
  if (!census) return census.error();
  const VolumeHeader& header = reader.header();
  const Eigen::Matrix3d& columns = header.T_file_index.linear();
  Json directions = Json::array();
  for (int axis = 0; axis < 3; ++axis) directions.push_back(vector_json(columns.col(axis).normalized()));
  const bool has_values = census->count() > 0;
  return Json{{"kind", "volume"},
              {"format", header.format},
              {"dims", Json::array({header.dims.x(), header.dims.y(), header.dims.z()})},
              {"sample_type", header.sample_type},
              {"spacing", vector_json(columns.colwise().norm().transpose())},
              {"origin", vector_json(header.T_file_index.translation())},
              {"directions", directions},
              {"metres_per_unit", header.metres_per_unit},
              {"value_range", has_values ? Json::array({census->min(), census->max()}) : Json(nullptr)},
              {"known_samples", census->count()},
              {"warnings", header.warnings}};
}

/// Describes the topology of the surface: joins the vertices that the seams of a texture have split.
Json mesh_json(Mesh mesh, const MeshNotes& notes) {
  const std::size_t vertices = mesh.positions_m.size();
  const StitchedSeams seams = notes.has_texture_coordinates ? stitch_seams(mesh) : StitchedSeams{};
  std::vector<std::string> warnings = notes.warnings;
  if (seams.guesses > 0) {
    warnings.push_back(
        fmt::format("{} edges of the texture's seams lie in the same place as others, so the program guesses which "
                    "belong together. A file that was written without --quantize needs no guess",
                    seams.guesses));
  }
  Json json = {{"kind", "mesh"},
               {"has_normals", !mesh.normals.empty()},
               {"has_colours", !mesh.colours.empty()},
               {"warnings", warnings}};
  json.update(Json::parse(mesh_check_json(check_mesh(mesh))));
  json["vertices"] = vertices;
  json["seam_vertices"] = seams.vertices;
  return json;
}

Result<Json> describe_volume(const InfoArguments& arguments, const ScanConfig& config) {
  const auto reader = open_volume_file(arguments.file, arguments.options, config.extract);
  return reader ? volume_json(**reader) : reader.error();
}

Result<Json> describe(const InfoArguments& arguments, const ScanConfig& config) {
  const std::filesystem::path& file = arguments.file;
  std::error_code ignored;
  const bool is_folder = std::filesystem::is_directory(file, ignored);
  if (!is_folder && is_mesh_path(file)) {
    MeshNotes notes;
    auto mesh = read_mesh(file, {}, &notes);
    return mesh ? Result<Json>(mesh_json(*std::move(mesh), notes)) : mesh.error();
  }
  if (!is_folder && is_vdb(file)) {
    if (auto known = refuse_options_for_vdb(file, arguments.options); !known) return known.error();
    const auto volume = load_volume(file);
    return volume ? Result<Json>(volume_json(*volume)) : volume.error();
  }
  return describe_volume(arguments, config);
}

}  // namespace

Result<std::string> describe_shape(const InfoArguments& arguments, const ScanConfig& config) {
  const auto json = describe(arguments, config);
  if (!json) return json.error();
  return json->dump(-1, ' ', false, Json::error_handler_t::replace);  // names of grids need not be UTF-8
}

}  // namespace scanknit
