#include "app/config/config_schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <optional>
#include <utility>

#include "acquire/sensor/sensor_profile.h"
#include "app/config/config_keys.h"
#include "app/config/suggestion.h"
#include "core/files/ascii_numbers.h"
#include "core/files/quantity.h"

namespace scanknit {
namespace {

using namespace config_keys;

Words<UpAxis> axis_words() {
  return {{"x", UpAxis::kX},       {"y", UpAxis::kY},       {"z", UpAxis::kZ},
          {"-x", UpAxis::kMinusX}, {"-y", UpAxis::kMinusY}, {"-z", UpAxis::kMinusZ}};
}

Words<SensorModel> sensor_words() {
  Words<SensorModel> words = {{"none", SensorModel::kNone}};
  for (const SensorProfile& profile : kSensorProfiles) words.emplace_back(profile.name, profile.model);
  return words;
}

/// A part of the noise model. A value that is given applies even before the sensor is known.
template <typename Part>
ConfigKey noise_key(ConfigKey key, std::optional<double> GivenNoise::*given, Part part) {
  bind_optional<double>(
      key, [given](auto& c) -> auto& { return c.noise.*given; });
  key.set = [given, part, set_given = key.set](ScanConfig& config, const ConfigValue& value) {
    set_given(config, value);
    config.fusion.noise.*part = (config.noise.*given).value_or(NoiseModel{}.*part);
  };
  return key;
}

std::vector<ConfigKey> noise_keys() {
  ConfigKey floor = describe(ConfigType::kLength,
                             {"fusion.noise.floor", "m",
                              "Depth noise of the sensor: sigma(z) = floor + growth (z - from)^2. This is its floor. "
                              "auto: the sensor's; of an unknown one, a Kinect's."},
                             {0, 1});
  ConfigKey growth =
      describe(ConfigType::kNumber,
               {"fusion.noise.growth", "1/m", "How the noise grows with the square of the distance."}, {0, 1});
  ConfigKey from = describe(ConfigType::kLength,
                            {"fusion.noise.from", "m", "The distance at which the noise is at its floor."}, {0, 100});
  return {noise_key(std::move(floor), &GivenNoise::floor_m, &NoiseModel::floor_m),
          noise_key(std::move(growth), &GivenNoise::growth_per_m, &NoiseModel::growth_per_m),
          noise_key(std::move(from), &GivenNoise::from_m, &NoiseModel::from_m)};
}

/// The sensor, and where its poses come from.
std::vector<ConfigKey> sensor_keys() {
  return {
      optional_choice<SensorModel>(
          {"acquire.sensor", "",
           "The sensor: it determines range, noise and timing (below), and for a data set the camera. none: another "
           "one. "
           "auto: recognised by what the recording says, or by the steps of its depth and its camera."},
          sensor_words(), [](auto& c) -> auto& { return c.acquire.sensor; }),
      choice<PoseMode>(
          {"acquire.poses", "",
           "Where poses come from. recording: from the recording, a frame without one is dropped; track: found from "
           "the frames themselves; refine: the recording's, each corrected a little, or left out where what was "
           "scanned before contradicts it; still: the scanner did not move. auto: recording if it has poses, else "
           "track."},
          {{"auto", PoseMode::kAuto},
           {"recording", PoseMode::kRecording},
           {"track", PoseMode::kTrack},
           {"refine", PoseMode::kRefine},
           {"still", PoseMode::kStill}},
          [](auto& c) -> auto& { return c.acquire.poses; }),
  };
}

/// How a scanner that is plugged in is set.
std::vector<ConfigKey> scanner_keys() {
  const Words<bool> on_off = {{"on", true}, {"off", false}};
  ConfigKey laser_power = describe(
      ConfigType::kInteger,
      {"acquire.laser_power", "mW", "Power of the scanner's projector. auto: as the camera has it."}, {0, 1000});
  bind_optional<std::int64_t>(
      laser_power, [](auto& c) -> auto& { return c.scanner.laser_power_mw; });
  ConfigKey preset = describe(ConfigType::kInteger,
                              {"acquire.preset", "",
                               "Visual preset of the scanner, by the camera's own numbering (RealSense: 1 default, 2 "
                               "hand, 3 high accuracy, 4 high density, 5 medium density). auto: as the camera has it."},
                              {0, 255});
  bind_optional<std::int64_t>(
      preset, [](auto& c) -> auto& { return c.scanner.preset; });

  return {
      choice<ScannerColour>(
          {"acquire.colour", "",
           "Colour of a scanner that is plugged in. auto: used if the pose of the colour camera is known, else left "
           "out; registered: if it is not known, colour is used as if both cameras had the same viewpoint; off: left "
           "out."},
          {{"auto", ScannerColour::kAuto}, {"registered", ScannerColour::kRegistered}, {"off", ScannerColour::kOff}},
          [](auto& c) -> auto& { return c.acquire.colour; }),
      optional_choice<bool>(
          {"acquire.emitter", "",
           "The projector of the scanner's pattern: off where several scanners disturb each other. auto: as the camera "
           "has it."},
          on_off, [](auto& c) -> auto& { return c.scanner.emitter; }),
      std::move(laser_power),
      std::move(preset),
      boolean(
          {"acquire.lock_exposure", "",
           "Exposure and white balance of a scanner's colour are held after the first second, so that colours of "
           "different views fit together."},
          [](auto& c) -> auto& { return c.scanner.locks_exposure; }),
  };
}

/// Which depth is kept, by its confidence and its distance.
std::vector<ConfigKey> depth_range_keys() {
  return {
      integer(
          {"acquire.min_confidence", "", "Phone LiDAR: depth of less confidence is dropped (0 low, 1 medium, 2 high)."},
          {0, 2}, [](auto& c) -> auto& { return c.acquire.min_confidence; }),
      optional_length(
          {"acquire.min_depth", "", "Nearer depth is dropped. auto: as the sensor's range begins."}, {0, 100},
          [](auto& c) -> auto& { return c.acquire.min_depth_m; }),
      optional_length(
          {"acquire.max_depth", "",
           fmt::format("Farther depth is dropped; 0: no limit. auto: where the sensor's range ends, or where its noise "
                       "exceeds {} voxels.",
                       kMostNoiseVoxels)},
          {0, 1000}, [](auto& c) -> auto& { return c.acquire.max_depth_m; }),
  };
}

/// When the parts of a frame are taken.
std::vector<ConfigKey> timing_keys() {
  return {
      optional_number(
          {"acquire.readout", "s",
           "Rolling shutter: the time from the first row of a picture to the last. Tracking takes the camera's motion "
           "out of the frames. 0: all rows at once. auto: the sensor's; if its depth alone tells which sensor it is, "
           "only where frames fit badly in quick turns without it."},
          {0, 1}, [](auto& c) -> auto& { return c.acquire.readout_s; }),
      optional_number(
          {"acquire.colour_later", "s",
           "How long after its depth picture the colour picture of a frame is taken; less than 0: before it. auto: as "
           "for acquire.readout."},
          {-1, 1}, [](auto& c) -> auto& { return c.acquire.colour_later_s; }),
  };
}

/// What filters drop or smooth.
std::vector<ConfigKey> filter_keys() {
  return {
      number(
          {"acquire.edge_sigmas", "sigma",
           "Depth beside a step of more than this many standard deviations of the noise is dropped: it is often "
           "smeared between near and far; 0: keep it."},
          {0, 1000}, [](auto& c) -> auto& { return c.acquire.edge_sigmas; }),
      integer(
          {"acquire.outlier_neighbours", "",
           "Statistical outlier removal: how many nearest points each point is compared with; 0: off."},
          {0, 1000}, [](auto& c) -> auto& { return c.acquire.outlier_neighbours; }),
      number(
          {"acquire.outlier_sigmas", "sigma",
           "A point whose mean distance to its neighbours is this many standard deviations above the mean of all "
           "points is dropped."},
          {0.01, 1000}, [](auto& c) -> auto& { return c.acquire.outlier_sigmas; }),
      boolean(
          {"acquire.bilateral", "", "Smooth the depth and keep its edges."},
          [](auto& c) -> auto& { return c.acquire.bilateral; }),
  };
}

std::vector<ConfigKey> band_keys() {
  return {
      length(
          {"fusion.voxel_size", "",
           "Edge of a voxel: the finest detail of the mesh. Half of it takes up to four times the memory."},
          {0.0002, 0.1}, [](auto& c) -> auto& { return c.fusion.voxel_size_m; }),
      number(
          {"fusion.truncation", "voxels",
           "Least half-width, in voxels, of the band around the surface in which distances are kept."},
          {2, 64}, [](auto& c) -> auto& { return c.fusion.truncation_voxels; }),
      number(
          {"fusion.truncation_sigmas", "sigma",
           "Least half-width of the band in standard deviations of the noise: with it the band grows with the "
           "distance; "
           "0: a band of fixed width."},
          {0, 100}, [](auto& c) -> auto& { return c.fusion.truncation_sigmas; }),
  };
}

std::vector<ConfigKey> volume_keys() {
  return {
      number(
          {"fusion.max_weight", "",
           "Observations beyond this weight replace old ones, so that the volume follows a scene that changes."},
          {1, 4095}, [](auto& c) -> auto& { return c.fusion.max_weight; }),
      boolean(
          {"fusion.carve_free_space", "",
           "Frames that look through a known voxel push it towards free space; removes what moved away."},
          [](auto& c) -> auto& { return c.fusion.carve_free_space; }),
      boolean(
          {"fusion.loop_closure", "",
           "When poses are tracked and the walk comes back to where it has been, the drift is distributed over it at "
           "the end and the frames are fused again."},
          [](auto& c) -> auto& { return c.fusion.loop_closure; }),
      choice<SilhouetteUse>(
          {"fusion.silhouettes", "",
           "carve: where depth never decided, the visual hull of the masks (acquire.masks or acquire.background) fills "
           "the mesh: parts that give no depth appear. off: only depth counts."},
          {{"off", SilhouetteUse::kOff}, {"carve", SilhouetteUse::kCarve}},
          [](auto& c) -> auto& { return c.fusion.silhouettes; }),
      memory(
          {"fusion.memory_budget", "",
           "Memory that the program may take. auto: half of the machine's, or of the container's, between 128 MiB and "
           "4 GiB; report.json has the figure. The volume gets five sevenths of what is left beside 96 MiB for the "
           "program, and at least a quarter. A run whose volume would need more is fused in parts (fusion.bricks), or, "
           "where that cannot be, refused before it starts, with the budget and the voxel size that would fit. A mesh "
           "that is too large to be closed or simplified is made of larger voxels, with a warning."},
          {kLeastMemoryBudgetMib, kMostMemoryBudgetMib}, [](auto& c) -> auto& { return c.fusion.memory_budget_mib; }),
      choice<BrickSize>(
          {"fusion.bricks", "",
           "Poses that are known: keep the volume on disk beside the mesh, which is the same. auto: if it exceeds its "
           "part of fusion.memory_budget, what the camera does not see; 64 to 512: always, fused in cubes of so many "
           "voxels; off: never."},
          {{"auto", BrickSize::kAuto},
           {"off", BrickSize::kOff},
           {"64", BrickSize::k64},
           {"128", BrickSize::k128},
           {"256", BrickSize::k256},
           {"512", BrickSize::k512}},
          [](auto& c) -> auto& { return c.fusion.bricks; }),
  };
}

std::vector<ConfigKey> turntable_keys() {
  return {
      boolean(
          {"turntable.enabled", "",
           "The scanner stands still and an object turns before it. The axis and the angle of every frame are found, "
           "and the frames are fused again with them; if no turntable is found, the mesh has the tracked poses."},
          [](auto& c) -> auto& { return c.turntable.is_enabled; }),
      boolean(
          {"turntable.cut", "",
           "Cut away what does not turn with the object (walls, hands), and the disc it stands on."},
          [](auto& c) -> auto& { return c.turntable.cuts; }),
      boolean(
          {"turntable.close_base", "", "Close the object with a plane where it stood on the disc."},
          [](auto& c) -> auto& { return c.turntable.closes_base; }),
      number(
          {"turntable.rpm", "1/min",
           "Turns a minute of a steady turntable, in either direction; 0: not known. The recording must have times."},
          {0, 600}, [](auto& c) -> auto& { return c.turntable.rpm; }),
      number(
          {"turntable.step", "degrees", "Turn from one frame to the next, steady, in either direction; 0: not known."},
          {0, 170}, [](auto& c) -> auto& { return c.turntable.step_degrees; }),
      number(
          {"turntable.angle_sigma", "degrees",
           "How far angles that are known (rpm, step, --angles) may be off: standard deviation."},
          {0.001, 30}, [](auto& c) -> auto& { return c.turntable.angle_sigma_degrees; }),
      optional_length(
          {"turntable.distance", "",
           "Silhouettes, which do not tell a size: how far before the camera the axis is, where it passes the middle "
           "of "
           "the picture. auto: 1 m, with a warning."},
          {0.001, 1000}, [](auto& c) -> auto& { return c.turntable.distance_m; }),
  };
}

std::vector<ConfigKey> extract_keys() {
  return {
      number(
          {"extract.isovalue", "", "The value of the surface, in the volume's own unit (metres for a scan)."},
          {-3e38, 3e38}, [](auto& c) -> auto& { return c.extract.isovalue; }),
      choice<Decider>(
          {"extract.decider", "",
           "How the surface is resolved where corners leave a choice. trilinear: the topology of the trilinear "
           "isosurface, inside cells too. On faces alone: asymptotic, by the face saddle (Nielson & Hamann 1991); "
           "chord, by the crossing of the chords (the same decisions); knit, by paths through both cells (Digital "
           "Morse Theory 1999); fixed_high, always join; fixed_low, never. tetra5, tetra6, tetra24: cells are cut into "
           "so many tetrahedra. lorensen: the 15 cases of 1987, whose meshes have holes; for teaching only."},
          {{"trilinear", Decider::kTrilinear},
           {"asymptotic", Decider::kAsymptotic},
           {"chord", Decider::kChord},
           {"knit", Decider::kKnit},
           {"fixed_high", Decider::kFixedHigh},
           {"fixed_low", Decider::kFixedLow},
           {"tetra5", Decider::kTetra5},
           {"tetra6", Decider::kTetra6},
           {"tetra24", Decider::kTetra24},
           {"lorensen", Decider::kLorensen}},
          [](auto& c) -> auto& { return c.extract.decider; }),
      choice<VertexPlacement>(
          {"extract.placement", "",
           "Where a vertex sits on its edge. linear: where the interpolated value is the isovalue; "
           "mid_edge: in the middle."},
          {{"linear", VertexPlacement::kLinear}, {"mid_edge", VertexPlacement::kMidEdge}},
          [](auto& c) -> auto& { return c.extract.placement; }),
      choice<InsideSide>(
          {"extract.inside", "",
           "Which side of the isovalue is matter. auto: low for signed distances, high for any other "
           "volume."},
          {{"auto", InsideSide::kAuto}, {"low", InsideSide::kLow}, {"high", InsideSide::kHigh}},
          [](auto& c) -> auto& { return c.extract.inside; }),
      boolean(
          {"extract.normals", "", "Give every vertex a normal, from the gradient of the volume."},
          [](auto& c) -> auto& { return c.extract.normals; }),
      number(
          {"extract.min_weight", "",
           "Voxels observed with less weight count as unobserved. A frame that sees a voxel head-on, where the "
           "sensor's "
           "noise is least, counts 1; obliquely or from afar it counts less."},
          {0, 1e6}, [](auto& c) -> auto& { return c.extract.min_weight; }),
      integer(
          {"extract.min_component_triangles", "triangles", "Smaller separate pieces are removed; 0: keep all."},
          {0, 1e9}, [](auto& c) -> auto& { return c.extract.min_component_triangles; }),
      memory(
          {"extract.memory_budget", "",
           "Memory for a volume file and its mesh. auto: as fusion.memory_budget has it. A volume whose samples need "
           "more than half of it is read a few slices at a time, 26 at least, and its mesh goes to disk: .ply or .stl "
           "only. The part of the mesh that is "
           "held between two steps comes on top. A .vdb is loaded whole, whatever it needs."},
          {1, 1 << 24}, [](auto& c) -> auto& { return c.extract.memory_budget_mib; }),
  };
}

std::vector<ConfigKey> export_keys() {
  ConfigKey texel_size =
      describe(ConfigType::kLength,
               {"export.texel_size", "m",
                "Side of a texel on the surface. auto: three quarters of what a pixel of the nearest "
                "frames covers, or as fine as export.texture_size allows."},
               {0.00005, 0.1});
  bind_optional<double>(
      texel_size, [](auto& c) -> auto& { return c.output.texel_size_m; });
  ConfigKey longitude = describe(
      ConfigType::kNumber,
      {"export.georeference.longitude", "degrees",
       "3D Tiles: where the origin of the mesh is on the Earth (WGS 84), its x axis to the east. auto: nowhere."},
      {-180, 180});
  bind_optional<double>(
      longitude, [](auto& c) -> auto& { return c.output.georeference.longitude_deg; });
  ConfigKey latitude = describe(
      ConfigType::kNumber, {"export.georeference.latitude", "degrees", "As export.georeference.longitude."}, {-90, 90});
  bind_optional<double>(
      latitude, [](auto& c) -> auto& { return c.output.georeference.latitude_deg; });
  return {
      word_list(
          {"export.formats", "",
           "Mesh files that are written when the output is a folder. tiles: model.tiles, a folder of 3D Tiles."},
          {"glb", "ply", "obj", "stl", "3mf", "tiles"}, [](auto& c) -> auto& { return c.output.formats; }),
      optional_choice<UpAxis>(
          {"export.world_up", "",
           "Which axis of the recording's world points up, so that GLB, STL and the preview stand "
           "upright. auto: as is usual for the recording's layout."},
          axis_words(), [](auto& c) -> auto& { return c.output.world_up; }),
      optional_choice<UpAxis>(
          {"export.up", "",
           "Turn PLY and OBJ so that this axis points up. auto: leave them in the recording's "
           "world."},
          axis_words(), [](auto& c) -> auto& { return c.output.up; }),
      choice<Material>(
          {"export.material", "",
           "GLB, tiles: lit is shaded by the viewer's light; unlit shows exactly the colours the camera saw."},
          {{"lit", Material::kLit}, {"unlit", Material::kUnlit}}, [](auto& c) -> auto& { return c.output.material; }),
      boolean(
          {"export.quantize", "",
           "GLB: positions in 1/65535 of the longest side and normals in 1/127 (KHR_mesh_quantization); four fifths "
           "of the size. Assimp 5.2 and Open3D 0.16 read such files wrong, and do not say so."},
          [](auto& c) -> auto& { return c.output.quantize; }),
      boolean(
          {"export.compress", "",
           "GLB, tiles: EXT_meshopt_compression, for the web: half the size, with export.quantize a quarter. "
           "Blender, Assimp and Open3D do not read such files."},
          [](auto& c) -> auto& { return c.output.compress; }),
      choice<TextureFormat>(
          {"export.texture", "",
           "GLB of `run` and `capture`: a texture, baked from the colour frames, in the place of colours at the "
           "vertices. "
           "png is exact, jpeg smaller."},
          {{"off", TextureFormat::kOff}, {"png", TextureFormat::kPng}, {"jpeg", TextureFormat::kJpeg}},
          [](auto& c) -> auto& { return c.output.texture; }),
      integer(
          {"export.texture_size", "texels", "The texture's longest side at most."}, {64, 16384},
          [](auto& c) -> auto& { return c.output.texture_size; }),
      std::move(texel_size),
      std::move(longitude),
      std::move(latitude),
      length(
          {"export.georeference.height", "m", "Of the same origin above the ellipsoid."}, {-12000, 100000},
          [](auto& c) -> auto& { return c.output.georeference.height_m; }),
      boolean(
          {"export.preview", "", "Draw preview.png, error.png and coverage.png when the output is a folder."},
          [](auto& c) -> auto& { return c.output.preview; }),
      boolean(
          {"export.uncertainty", "",
           "Estimate how far each vertex may be off: PLY files get its standard deviation in metres as the property "
           "`uncertainty`, and a picture shows it."},
          [](auto& c) -> auto& { return c.output.uncertainty; }),
  };
}

std::vector<ConfigKey> all_keys() {
  std::vector<ConfigKey> keys;
  for (auto section :
       {recording_keys(), sensor_keys(), scanner_keys(), depth_range_keys(), timing_keys(), filter_keys(), band_keys(),
        noise_keys(), volume_keys(), turntable_keys(), extract_keys(), finish_keys(), export_keys()}) {
    std::move(section.begin(), section.end(), std::back_inserter(keys));
  }
  return keys;
}

Error complaint(std::string message) {
  return {ErrorCode::kConfig, std::move(message)};
}

std::string with_unit(const ConfigKey& key, double value) {
  const bool says_unit = key.type == ConfigType::kLength || key.type == ConfigType::kMemory || key.unit == "1/m";
  return format_number(value) + (says_unit ? " " + key.unit : "");
}

/// The hint for the most common mistake: millimetres written as metres.
std::string millimetre_hint(const ConfigKey& key, double metres) {
  const double as_mm = metres / 1000;
  if (key.type != ConfigType::kLength || as_mm < key.minimum || as_mm > key.maximum) return "";
  return fmt::format(" (did you mean millimetres? {} mm is {})", format_number(metres), format_number(as_mm));
}

/// The hint for a negative turn: the sign is not needed, because both directions are tried.
std::string sign_hint(const ConfigKey& key, double value) {
  const bool is_of_turn = key.name == "turntable.step" || key.name == "turntable.rpm";
  if (!is_of_turn || !(value < 0) || -value > key.maximum) return "";
  return fmt::format(" (the sign is not needed, either direction is found: write {})", format_number(-value));
}

Result<double> in_range(const ConfigKey& key, double value) {
  if (value >= key.minimum && value <= key.maximum) return value;
  return complaint(fmt::format("{} is outside {}{}{}", with_unit(key, value), format_config_range(key),
                               millimetre_hint(key, value), sign_hint(key, value)));
}

template <typename Stored>
Result<ConfigValue> checked(const ConfigKey& key, const std::optional<Stored>& parsed, std::string_view expected,
                            std::string_view word) {
  if (!parsed) return complaint(fmt::format("expected {}, got '{}'", expected, word));
  if (auto fits = in_range(key, static_cast<double>(*parsed)); !fits) return fits.error();
  return ConfigValue(*parsed);
}

bool is_topic_name(std::string_view word) {
  constexpr std::string_view kMarks = "/_-.~";
  constexpr std::size_t kLongest = 255;
  return !word.empty() && word.size() <= kLongest && std::all_of(word.begin(), word.end(), [&](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || kMarks.find(c) != std::string_view::npos;
  });
}

bool is_path(std::string_view word) {
  constexpr std::size_t kLongest = 4096;
  return !word.empty() && word.size() <= kLongest && std::none_of(word.begin(), word.end(), [](char c) {
    return std::iscntrl(static_cast<unsigned char>(c)) != 0;
  });
}

Result<ConfigValue> parse_choice(const ConfigKey& key, std::string_view word) {
  if (std::find(key.choices.begin(), key.choices.end(), word) != key.choices.end()) {
    if (key.type == ConfigType::kList) return ConfigValue(std::vector{std::string(word)});
    return ConfigValue(std::string(word));
  }
  const auto near = nearest_word(word, key.choices);
  return complaint(fmt::format("expected one of {}, got '{}'{}", format_config_range(key), word,
                               near ? fmt::format("; did you mean '{}'?", *near) : ""));
}

}  // namespace

ScanConfig built_in_config() {
  ScanConfig config;
  config.fusion.memory_budget_mib = kAutomaticBudgetMib;
  config.extract.memory_budget_mib = kAutomaticBudgetMib;
  return config;
}

std::span<const ConfigKey> config_schema() {
  static const std::vector<ConfigKey> keys = all_keys();
  return keys;
}

const ConfigKey* find_config_key(std::string_view name) {
  const auto keys = config_schema();
  const auto found = std::find_if(keys.begin(), keys.end(), [&](const ConfigKey& key) { return key.name == name; });
  return found == keys.end() ? nullptr : &*found;
}

Result<ConfigValue> parse_config_word(const ConfigKey& key, std::string_view word) {
  if (key.allows_auto && word == "auto") return ConfigValue();
  switch (key.type) {
    case ConfigType::kBool:
      if (word == "true" || word == "false") return ConfigValue(word == "true");
      return complaint(fmt::format("expected true or false, got '{}'", word));
    case ConfigType::kInteger: return checked(key, parse_integer(word), "a whole number", word);
    case ConfigType::kNumber: return checked(key, parse_finite(word), "a number", word);
    case ConfigType::kLength: {
      const auto parsed = parse_length(word);
      const auto metres = parsed ? std::optional(parsed->metres) : std::nullopt;
      return checked(key, metres, "a length such as 0.004, 4mm, 0.4 cm", word);
    }
    case ConfigType::kMemory: return checked(key, parse_memory_mib(word), "memory such as 4GiB, 512MiB", word);
    case ConfigType::kEnum:
    case ConfigType::kList: return parse_choice(key, word);
    case ConfigType::kTopic:
      if (is_topic_name(word)) return ConfigValue(std::string(word));
      return complaint(fmt::format("expected the name of a topic such as /camera/depth/image_raw, got '{}'", word));
    case ConfigType::kPath:
      if (is_path(word)) return ConfigValue(std::string(word));
      return complaint(fmt::format("expected a path, got '{}'", word));
    case ConfigType::kCamera: return complaint(fmt::format("expected the name of a file, got '{}'", word));
    case ConfigType::kIntrinsics: break;
  }
  return complaint(fmt::format("expected [fx, fy, cx, cy], a map or a file, got '{}'", word));
}

std::string format_config_range(const ConfigKey& key) {
  if (!key.choices.empty()) {
    std::vector<std::string> words = key.choices;
    if (key.allows_auto) words.insert(words.begin(), "auto");
    return fmt::format("{}", fmt::join(words, ", "));
  }
  if (key.minimum == key.maximum) return "";
  return fmt::format("{}..{}", format_number(key.minimum), with_unit(key, key.maximum));
}

}  // namespace scanknit
