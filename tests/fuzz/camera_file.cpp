// Files that state cameras: the first byte chooses the reader.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>

#include "acquire/lidar/ouster_packets.h"
#include "acquire/mkv/azure_calibration.h"
#include "acquire/replay/camera_files.h"
#include "app/config/config_camera.h"
#include "core/pose.h"
#include "folder/scratch_folder.h"

namespace scanknit {
namespace {

void check_camera(CameraIntrinsics camera) {
  require((camera.width == 0) == (camera.height == 0), "a size is stated as a whole, or not at all");
  if (camera.width == 0) camera.width = camera.height = 1;
  require(camera.is_valid(), "cameras are valid");
}

void check_model(const CameraModel& model) {
  check_camera(model.intrinsics);
  require(std::all_of(model.distortion.begin(), model.distortion.end(), [](double k) { return std::isfinite(k); }),
          "distortion is finite");
}

void check_scanner(const ScannerCamera& camera) {
  require(camera.colour || camera.depth, "one of the cameras is stated");
  for (const auto& model : {camera.colour, camera.depth}) {
    if (!model) continue;
    check_model(*model);
    require(model->intrinsics.width > 0, "a scanner's cameras have sizes");
  }
  if (camera.T_colour_depth) require(is_rigid(*camera.T_colour_depth), "poses are rigid and finite");
  if (camera.depth_bias) {
    const auto count = static_cast<std::size_t>(camera.depth_bias->columns * camera.depth_bias->rows);
    require(camera.depth_bias->scale.size() == count && camera.depth_bias->shift_per_m.size() == count,
            "a depth bias has a number for each node");
  }
}

/// CAMERA.yaml, or a map of one camera.
void read_yaml(std::string_view text, bool is_scanner) {
  const auto parsed = parse_yaml(text);
  if (const auto* error = std::get_if<YamlError>(&parsed)) return require(!error->message.empty(), "errors say why");
  bool has_complaint = false;
  const auto complain = [&](const YamlNode&, const std::string& what) {
    require(!what.empty(), "errors say why");
    has_complaint = true;
  };
  const YamlNode& root = std::get<YamlNode>(parsed);
  if (is_scanner) {
    const auto camera = read_scanner_camera(root, complain);
    require(camera.has_value() != has_complaint, "what is not read is complained of");
    if (camera) check_scanner(*camera);
  } else {
    const auto camera = read_camera_map(root, complain);
    require(camera.has_value() != has_complaint, "what is not read is complained of");
    if (camera) check_model(*camera);
  }
}

void read_azure(std::string_view text) {
  const auto calibration = parse_azure_calibration(std::as_bytes(std::span(text)));
  if (!calibration) return;
  for (const auto& camera : {calibration->depth, calibration->colour}) {
    if (camera) require(is_rigid(camera->T_camera_device), "poses are rigid and finite");
  }
  if (calibration->depth) {
    if (const auto camera = azure_depth_camera(*calibration->depth, 640, 576)) check_camera(*camera);
  }
  if (calibration->colour) check_camera(azure_colour_camera(*calibration->colour, 1280, 720));
}

void read_ouster(std::string_view text) {
  auto metadata = parse_ouster_metadata(text);
  if (!metadata) return;
  require(is_rigid(metadata->T_sensor_lidar), "poses are rigid and finite");
  const std::size_t bytes = metadata->packet_bytes();
  const auto packets = ouster_packets(*std::move(metadata));
  require(packets != nullptr && bytes > 0 && packets->blocks() > 0, "packets of a known sensor are not empty");
}

}  // namespace
}  // namespace scanknit

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace scanknit;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(bytes) + 1, size - 1);
  switch (bytes[0] % 6) {
    case 0: read_yaml(text, true); break;
    case 1: read_yaml(text, false); break;
    case 2:
      if (const auto camera = parse_camera_matrix(text)) check_camera(*camera);
      break;
    case 3:
      if (const auto camera = parse_camera_json(text)) check_camera(*camera);
      break;
    case 4: read_azure(text); break;
    default: read_ouster(text); break;
  }
  return 0;
}
