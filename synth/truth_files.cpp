#include "synth/truth_files.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "acquire/replay/text_numbers.h"
#include "core/files/atomic_file.h"
#include "core/files/byte_reader.h"
#include "core/files/little_endian.h"
#include "core/files/read_file.h"
#include "synth/sensor/sensor_keys.h"

namespace scanknit {
namespace {

constexpr std::uintmax_t kMaxJsonBytes = 64u << 10;
constexpr std::size_t kPointBytes = 6 * sizeof(float) + sizeof(std::uint32_t);
constexpr std::size_t kVertexBytes = 3 * sizeof(float);
constexpr std::size_t kColourBytes = 3;
constexpr std::size_t kFaceBytes = 1 + 3 * sizeof(std::uint32_t);

constexpr std::string_view kPly = "ply\nformat binary_little_endian 1.0\n";
constexpr std::string_view kPosition = "property float x\nproperty float y\nproperty float z\n";
constexpr std::string_view kNormal = "property float nx\nproperty float ny\nproperty float nz\n";
constexpr std::string_view kViews = "property uint views\n";
constexpr std::string_view kColour = "property uchar red\nproperty uchar green\nproperty uchar blue\n";
constexpr std::string_view kFaces = "property list uchar uint vertex_indices\n";
constexpr std::string_view kEnd = "end_header\n";

void append_vector(std::string& bytes, const Eigen::Vector3f& v) {
  for (int axis = 0; axis < 3; ++axis) append_little_endian(bytes, v[axis]);
}

std::string points_ply(const std::vector<TruthPoint>& points) {
  std::string bytes =
      fmt::format("{}element vertex {}\n{}{}{}{}", kPly, points.size(), kPosition, kNormal, kViews, kEnd);
  bytes.reserve(bytes.size() + points.size() * kPointBytes);
  for (const TruthPoint& point : points) {
    append_vector(bytes, point.position_m);
    append_vector(bytes, point.normal);
    append_little_endian(bytes, point.views);
  }
  return bytes;
}

std::string mesh_ply(const Mesh& mesh) {
  std::string bytes = fmt::format("{}element vertex {}\n{}{}element face {}\n{}{}", kPly, mesh.positions_m.size(),
                                  kPosition, mesh.colours.empty() ? "" : kColour, mesh.triangles.size(), kFaces, kEnd);
  for (std::size_t i = 0; i < mesh.positions_m.size(); ++i) {
    append_vector(bytes, mesh.positions_m[i]);
    if (mesh.colours.empty()) continue;
    for (const std::uint8_t channel : {mesh.colours[i].r, mesh.colours[i].g, mesh.colours[i].b})
      append_little_endian(bytes, channel);
  }
  for (const Triangle& t : mesh.triangles) {
    append_little_endian(bytes, std::uint8_t{3});
    for (const std::uint32_t v : t) append_little_endian(bytes, v);
  }
  return bytes;
}

/// Reads a PLY header exactly as write_truth() writes it; rejects all others.
class HeaderReader {
 public:
  explicit HeaderReader(std::string_view text) : text_(text) {}

  bool skip(std::string_view expected) {
    if (text_.substr(offset_, expected.size()) != expected) return false;
    offset_ += expected.size();
    return true;
  }
  bool number(std::size_t& value) {
    const std::string_view rest = text_.substr(offset_);
    const auto [end, code] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
    if (code != std::errc{}) return false;
    offset_ += static_cast<std::size_t>(end - rest.data());
    return skip("\n");
  }
  [[nodiscard]] std::size_t offset() const { return offset_; }

 private:
  std::string_view text_;
  std::size_t offset_ = 0;
};

Error malformed(const std::filesystem::path& path, const std::string& what) {
  return {ErrorCode::kInput, what, path.string()};
}

/// Reads a float; its bytes must be there.
float take_float(ByteReader& reader) {
  return reader.little_endian<float>().value_or(0.0f);
}
Eigen::Vector3f take_vector(ByteReader& reader) {
  const float x = take_float(reader);
  const float y = take_float(reader);
  const float z = take_float(reader);
  return {x, y, z};
}

Result<std::vector<TruthPoint>> read_points(const std::filesystem::path& path, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_mesh_bytes);
  if (!text) return text.error();
  HeaderReader header(*text);
  std::size_t count = 0;
  if (!header.skip(kPly) || !header.skip("element vertex ") || !header.number(count) || !header.skip(kPosition) ||
      !header.skip(kNormal) || !header.skip(kViews) || !header.skip(kEnd)) {
    return malformed(path, "not a file of visible points of the synthetic scanner");
  }
  const auto body = std::as_bytes(std::span(*text)).subspan(header.offset());
  if (count > limits.max_mesh_vertices || body.size() != count * kPointBytes) {
    return malformed(path, fmt::format("{} bytes for {} points, expected {}", body.size(), count, kPointBytes));
  }
  ByteReader reader(body);
  std::vector<TruthPoint> points(count);
  for (TruthPoint& point : points) {
    point.position_m = take_vector(reader);
    point.normal = take_vector(reader);
    point.views = reader.little_endian<std::uint32_t>().value_or(0);
    if (!point.position_m.allFinite() || !point.normal.allFinite()) return malformed(path, "a number is not finite");
  }
  return points;
}

Result<Mesh> read_mesh_file(const std::filesystem::path& path, const Limits& limits) {
  const auto text = read_text_file(path, limits.max_mesh_bytes);
  if (!text) return text.error();
  HeaderReader header(*text);
  std::size_t vertices = 0;
  std::size_t faces = 0;
  const bool begins =
      header.skip(kPly) && header.skip("element vertex ") && header.number(vertices) && header.skip(kPosition);
  const bool has_colour = begins && header.skip(kColour);
  if (!begins || !header.skip("element face ") || !header.number(faces) || !header.skip(kFaces) || !header.skip(kEnd)) {
    return malformed(path, "not a mesh of the synthetic scanner");
  }
  const auto body = std::as_bytes(std::span(*text)).subspan(header.offset());
  const std::size_t stride = kVertexBytes + (has_colour ? kColourBytes : 0);
  // Both counts are at most 2^30 here, so the products fit.
  if (vertices > limits.max_mesh_vertices || faces > limits.max_mesh_triangles ||
      body.size() != vertices * stride + faces * kFaceBytes) {
    return malformed(path, fmt::format("{} bytes do not hold {} vertices and {} faces", body.size(), vertices, faces));
  }
  ByteReader reader(body);
  Mesh mesh;
  mesh.positions_m.resize(vertices);
  mesh.colours.resize(has_colour ? vertices : 0);
  for (std::size_t i = 0; i < vertices; ++i) {
    mesh.positions_m[i] = take_vector(reader);
    if (!has_colour) continue;
    for (std::uint8_t* channel : {&mesh.colours[i].r, &mesh.colours[i].g, &mesh.colours[i].b}) {
      *channel = reader.little_endian<std::uint8_t>().value_or(0);
    }
  }
  mesh.triangles.resize(faces);
  for (Triangle& t : mesh.triangles) {
    if (reader.little_endian<std::uint8_t>() != std::uint8_t{3}) return malformed(path, "a face is not a triangle");
    for (std::uint32_t& v : t) v = reader.little_endian<std::uint32_t>().value_or(0);
  }
  return mesh;
}

Result<std::string> read_scene_name(const std::filesystem::path& path) {
  const auto text = read_text_file(path, kMaxJsonBytes);
  if (!text) return text.error();
  const auto json = nlohmann::json::parse(*text, nullptr, false);
  if (!json.is_object() || !json.contains("scene") || !json["scene"].is_string()) {
    return malformed(path, "expected a JSON object with a \"scene\"");
  }
  return json["scene"].get<std::string>();
}

/// True when the points lie on the scene's surface: the scenes of the catalogue may change between versions.
bool lie_on(const SyntheticScene& scene, const std::vector<TruthPoint>& points) {
  constexpr double kTolerance_m = 1e-5;
  const std::size_t stride = points.size() / 1000 + 1;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    if (scene.surface_distance(points[i].position_m.cast<double>()) > kTolerance_m) return false;
  }
  return true;
}

/// Every value of the sensor, and the camera that it has in truth.
nlohmann::ordered_json sensor_json(const SynthConfig& config, const RenderedSensor& sensor) {
  nlohmann::ordered_json values;
  for (const SensorKey& key : sensor_keys()) values[std::string(key.name)] = value_of(key, sensor);
  const CameraIntrinsics& camera = config.intrinsics;
  return {{"sensor", {{"name", sensor.name}, {"values", values}}},
          {"true_camera",
           {{"fx", camera.fx},
            {"fy", camera.fy},
            {"cx", camera.cx},
            {"cy", camera.cy},
            {"k1", sensor.lens.k1},
            {"k2", sensor.lens.k2}}}};
}

}  // namespace

Result<void> write_truth(const SyntheticScene& scene, const SynthConfig& config, std::size_t frames,
                         const std::vector<TruthPoint>& visible, const std::filesystem::path& folder) {
  nlohmann::ordered_json json;
  json["scene"] = scene.name();
  if (scene.mesh() != nullptr) json["mesh"] = kGroundTruthMeshFile;
  json["frames"] = frames;
  json["width"] = config.intrinsics.width;
  json["height"] = config.intrinsics.height;
  json["noise"] = config.noise;
  json["seed"] = config.seed;
  json["depth_scale"] = units_per_metre(config);
  if (config.turntable) {
    json["turntable"] = {{"turns", config.turntable->turns},
                         {"angle_noise_rad", config.turntable->angle_noise_rad},
                         {"is_on_side", config.turntable->is_on_side},
                         {"has_hand", config.turntable->has_hand}};
  }
  if (config.sensor) json.update(sensor_json(config, *config.sensor));
  if (config.path != PathKind::kScene) json["path"] = kPathNames[static_cast<std::size_t>(config.path)];
  if (!config.recorded_path.empty()) json["path"] = "recorded";
  if (config.person != PersonKind::kNobody) json["person"] = kPersonNames[static_cast<std::size_t>(config.person)];
  json["world"] = "metres, right-handed, y down";
  json["visible_points"] = {{"file", kVisiblePointsFile}, {"count", visible.size()}, {"min_views", config.min_views}};
  if (const Mesh* mesh = scene.mesh()) {
    if (auto done = write_file_atomically(folder / kGroundTruthMeshFile, mesh_ply(*mesh)); !done) return done;
  }
  if (auto done = write_file_atomically(folder / kVisiblePointsFile, points_ply(visible)); !done) return done;
  return write_file_atomically(folder / kGroundTruthFile, json.dump(2) + "\n");
}

Result<std::vector<Pose>> read_true_poses(const std::filesystem::path& folder, const Limits& limits) {
  std::error_code ignored;
  const bool is_kept_apart = std::filesystem::exists(folder / kTruePosesFile, ignored);
  const std::filesystem::path path = folder / (is_kept_apart ? kTruePosesFile : kPosesFile);
  const auto text = read_text_file(path, limits.max_text_bytes);
  if (!text) return text.error();
  constexpr std::size_t kNumbersPerPose = 19;  // three integers, then the matrix row by row
  const auto numbers = parse_numbers(*text);
  if (!numbers || numbers->size() % kNumbersPerPose != 0) return malformed(path, "not a trajectory of 4 x 4 matrices");
  std::vector<Pose> poses;
  for (std::size_t first = 0; first < numbers->size(); first += kNumbersPerPose) {
    const auto begin = numbers->begin() + static_cast<std::ptrdiff_t>(first);
    const auto pose = pose_from_numbers({begin + 3, begin + kNumbersPerPose});
    if (!pose) return malformed(path, pose.error().message);
    poses.push_back(*pose);
  }
  return poses;
}

Result<Truth> read_truth(const std::filesystem::path& folder, const Limits& limits) {
  const auto name = read_scene_name(folder / kGroundTruthFile);
  if (!name) return name.error();
  auto visible = read_points(folder / kVisiblePointsFile, limits);
  if (!visible) return visible.error();

  auto scene = make_scene(*name);
  if (*name == "mesh") {
    auto mesh = read_mesh_file(folder / kGroundTruthMeshFile, limits);
    if (!mesh) return mesh.error();
    scene = make_mesh_scene_as_is(*std::move(mesh));
  }
  if (!scene) return malformed(folder / kGroundTruthFile, scene.error().text());
  if (!lie_on(**scene, *visible)) {
    return malformed(folder / kGroundTruthFile,
                     "scene \"" + *name + "\" has changed since this recording was made; make the recording again");
  }
  return Truth{*std::move(scene), *std::move(visible)};
}

}  // namespace scanknit
