#include "app/cli/cli_measure.h"

#include <CLI/CLI.hpp>
#include <cmath>
#include <numbers>

#include "app/cli/cli_options.h"
#include "core/files/quantity.h"

namespace scanknit {
namespace {

constexpr const char* kUnitWords = "mm, cm, inch, m; default: STL mm, all others m";

CLI::Option* add_unit(CLI::App& command, CommandLine& line, const std::string& name, const std::string& help,
                      std::optional<MeshUnit>& place) {
  std::vector<std::pair<std::string, std::optional<MeshUnit>>> choices;
  for (const NamedMeshUnit& named : kMeshUnits) choices.emplace_back(std::string(named.name), named.unit);
  return add_choice(command, line, {name, help + kUnitWords}, place, choices)->type_name("UNIT");
}

std::optional<GivenLength> parse_given_length(const std::string& text) {
  const auto length = parse_length(text);
  if (!length) return std::nullopt;
  return GivenLength{length->metres, length->has_unit};
}

GivenLength positive_length(const std::string& option, const std::string& text) {
  const auto length = parse_given_length(text);
  if (!length || !(length->value > 0)) {
    throw CLI::ValidationError(option, "expected a length above 0 such as 2mm, got '" + text + "'");
  }
  return *length;
}

/// Parts of a text between commas.
std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ',') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

GivenPoint given_point(const std::string& option, const std::vector<std::string>& parts, std::size_t first) {
  GivenPoint point;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto length = first + i < parts.size() ? parse_given_length(parts[first + i]) : std::nullopt;
    if (!length) throw CLI::ValidationError(option, "expected X,Y,Z such as 1,2.5,0 or 1mm,2mm,0");
    point[i] = *length;
  }
  return point;
}

/// "z=12mm", or "X,Y,Z,NX,NY,NZ": a point and a direction.
GivenPlane given_plane(const std::string& text) {
  const std::string name = "--section";
  if (text.size() > 2 && text[1] == '=' && text[0] >= 'x' && text[0] <= 'z') {
    const auto offset = parse_given_length(text.substr(2));
    if (!offset) throw CLI::ValidationError(name, "expected a length after '" + text.substr(0, 2) + "'");
    return {Eigen::Vector3d::Unit(text[0] - 'x'), *offset, std::nullopt};
  }
  const std::vector<std::string> parts = parts_of(text);
  if (parts.size() != 6) throw CLI::ValidationError(name, "expected z=12mm or X,Y,Z,NX,NY,NZ, got '" + text + "'");
  GivenPlane plane;
  plane.point = given_point(name, parts, 0);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto number = parse_finite(parts[3 + i]);
    if (!number) throw CLI::ValidationError(name, "'" + parts[3 + i] + "' is no number");
    plane.normal[static_cast<Eigen::Index>(i)] = *number;
  }
  const double length = plane.normal.stableNorm();
  if (!(length > 0) || !std::isfinite(length)) throw CLI::ValidationError(name, "the direction has no length");
  plane.normal /= length;
  return plane;
}

void add_given_point(CLI::App& command, const std::string& name, const std::string& help,
                     std::optional<GivenPoint>& place, CLI::Option* needed) {
  command
      .add_option_function<std::string>(
          name, [&place, name](const std::string& text) { place = given_point(name, parts_of(text), 0); }, help)
      ->needs(needed)
      ->type_name("X,Y,Z");
}

}  // namespace

void add_distance_options(CLI::App& command, CommandLine& line) {
  DistanceArguments& distance = line.distance;
  ComparisonArguments& comparison = distance.comparison;
  command.add_option("mesh", distance.mesh, "The mesh")->required()->type_name("MESH");
  command.add_option("truth", distance.truth, "The reference: a mesh, or a folder that `synth` wrote")
      ->required()
      ->type_name("MESH|DIR");
  command.add_option("--trajectory", distance.trajectory, "The run's trajectory.txt, where it has a world of its own")
      ->type_name("FILE");
  add_choice(command, line, {"--align", "given: as they lie (the default); near: best fit from there; shape: anywhere"},
             comparison.alignment,
             {{"given", MeshAlignment::kGiven}, {"near", MeshAlignment::kNear}, {"shape", MeshAlignment::kShape}})
      ->type_name("HOW");
  auto* pairs = command
                    .add_option("--pairs", comparison.pairs,
                                "Three or more lines of x y z on the mesh, x y z of the same point on the reference")
                    ->type_name("FILE");
  command.add_option("--matrix", comparison.matrix, "The 4x4 matrix that takes the mesh onto the reference")
      ->excludes(pairs)
      ->type_name("FILE");
  add_unit(command, line, "--mesh-unit", "Unit of the mesh's numbers: ", comparison.mesh_unit);
  add_unit(command, line, "--reference-unit", "Unit of the reference's numbers: ", comparison.reference_unit);
  const auto set_tolerance = [&comparison](const std::string& text) {
    comparison.tolerance = positive_length("--tolerance", text);
  };
  auto* tolerance = command
                        .add_option_function<std::string>("--tolerance", set_tolerance,
                                                          "Exit with 7 if a part of the mesh deviates by more: 0.2mm")
                        ->type_name("LENGTH");
  command
      .add_option_function<double>(
          "--allowed", [&comparison](double percent) { comparison.allowed_share = percent / 100; },
          "Share of the mesh that may lie beyond the tolerance, percent; default 0")
      ->check(CLI::Range(0.0, 100.0))
      ->needs(tolerance)
      ->type_name("PERCENT");
  command
      .add_option("-o,--output", comparison.output,
                  "Write a coloured mesh, pictures with a scale, a histogram and distance.json into this folder")
      ->type_name("DIR");
}

void add_measure_options(CLI::App& command, CommandLine& line) {
  MeasureArguments& measure = line.measure;
  command.add_option("mesh", measure.mesh, "The mesh")->required()->type_name("MESH");
  add_unit(command, line, "--unit", "Unit of the mesh's numbers: ", measure.unit);
  command
      .add_option_function<std::string>(
          "--thin", [&measure](const std::string& text) { measure.thin = positive_length("--thin", text); },
          "Say how much of the surface has walls thinner than this: 1.2mm")
      ->type_name("LENGTH");
  const auto add_sections = [&measure](const std::vector<std::string>& texts) {
    for (const std::string& text : texts) measure.sections.push_back(given_plane(text));
  };
  command
      .add_option_function<std::vector<std::string>>(
          "--section", add_sections,
          "Cut by a plane: z=12mm, or X,Y,Z,NX,NY,NZ (a point and a direction); may be repeated")
      ->type_name("PLANE");
  auto* radius =
      command
          .add_option_function<std::string>(
              "--radius", [&measure](const std::string& text) { measure.radius = positive_length("--radius", text); },
              "The surface within this of a point belongs to it")
          ->type_name("LENGTH");
  add_given_point(command, "--plane-at", "Fit a plane to the surface near this point", measure.plane_at, radius);
  add_given_point(command, "--circle-at", "Fit a circle to the hole or the rod near this point", measure.circle_at,
                  radius);
  command.add_option("-o,--output", measure.output, "Write the sections (SVG, DXF) and measure.json into this folder")
      ->type_name("DIR");
}

}  // namespace scanknit
