#include "view/view_messages.h"

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/version.h"

namespace scanknit {
namespace {

using Json = nlohmann::json;

constexpr std::array kActions = {
    std::pair{"start", ViewAction::kStart},   std::pair{"pause", ViewAction::kPause},
    std::pair{"reset", ViewAction::kReset},   std::pair{"crop", ViewAction::kCrop},
    std::pair{"export", ViewAction::kExport}, std::pair{"finish", ViewAction::kFinish},
};

const char* to_string(ViewAction action) {
  for (const auto& [name, known] : kActions) {
    if (known == action) return name;
  }
  return "";
}

const char* to_string(ViewPhase phase) {
  switch (phase) {
    case ViewPhase::kWaiting: return "waiting";
    case ViewPhase::kScanning: return "scanning";
    case ViewPhase::kPaused: return "paused";
    case ViewPhase::kExporting: return "exporting";
    case ViewPhase::kFinished: return "finished";
    case ViewPhase::kFailed: return "failed";
  }
  return "";
}

/// JSON as text. File names and reasons may not be UTF-8: replaces such bytes instead of throwing.
std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json numbers(const Eigen::Vector3d& point) {
  return {point.x(), point.y(), point.z()};
}

std::optional<Eigen::Vector3d> point_of(const Json& json) {
  constexpr double kFarthest_m = 1e6;
  if (!json.is_array() || json.size() != 3) return std::nullopt;
  Eigen::Vector3d point;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!json[axis].is_number()) return std::nullopt;
    const double value = json[axis].get<double>();
    if (!(std::abs(value) <= kFarthest_m)) return std::nullopt;
    point[static_cast<Eigen::Index>(axis)] = value;
  }
  return point;
}

Error no_message(const char* why) {
  return {ErrorCode::kInput, why, "message of the live view's page"};
}

/// `message` has a "cmd".
Result<std::variant<ViewCredit, ViewCommand>> command_of(const Json& message) {
  const Json& name = message["cmd"];
  const auto id = message.find("id");
  if (!name.is_string()) return no_message("cmd: expected a word");
  if (id == message.end() || !id->is_number_unsigned()) return no_message("id: expected a whole number");
  ViewCommand command;
  command.id = id->get<std::uint64_t>();
  bool is_known = false;
  for (const auto& [word, action] : kActions) {
    if (name != word) continue;
    command.action = action;
    is_known = true;
  }
  if (!is_known) return no_message("cmd: expected start, pause, reset, crop, export or finish");
  if (command.action != ViewAction::kCrop) return std::variant<ViewCredit, ViewCommand>(command);
  const auto box = message.find("box");
  if (box == message.end()) return no_message("box: expected two corners, or null");
  if (box->is_null()) return std::variant<ViewCredit, ViewCommand>(command);
  if (!box->is_array() || box->size() != 2) return no_message("box: expected two corners, or null");
  const auto least = point_of((*box)[0]);
  const auto most = point_of((*box)[1]);
  if (!least || !most || !(least->array() < most->array()).all())
    return no_message("box: expected [[x, y, z], [x, y, z]], metres, the second beyond the first");
  command.box = Eigen::AlignedBox3d(*least, *most);
  return std::variant<ViewCredit, ViewCommand>(command);
}

}  // namespace

std::string to_message(const ViewHello& hello) {
  Json commands = Json::array();
  for (const ViewAction action : hello.actions) commands.push_back(to_string(action));
  return text_of({{"type", "hello"},
                  {"version", kVersion},
                  {"title", hello.title},
                  {"mode", hello.mode},
                  {"up", numbers(hello.up)},
                  {"is_orbit", hello.is_orbit},
                  {"is_paced", hello.is_paced},
                  {"voxel_size_m", hello.voxel_size_m},
                  {"tiles", hello.tiles},
                  {"commands", commands}});
}

std::string to_message(const ViewState& state) {
  return text_of({{"type", "state"},
                  {"phase", to_string(state.phase)},
                  {"tracking", state.tracking},
                  {"reason", state.reason},
                  {"advice", state.advice},
                  {"frame", state.frame},
                  {"frames_total", state.frames_total},
                  {"fused", state.fused},
                  {"dropped", state.dropped},
                  {"lost", state.lost},
                  {"fps", state.fps},
                  {"silent_s", state.silent_s},
                  {"losses", state.losses},
                  {"triangles", state.triangles},
                  {"is_behind", state.is_behind},
                  {"is_crop_empty", state.is_crop_empty},
                  {"memory_mib", state.memory_mib},
                  {"view_share", state.view_share},
                  {"message", state.message}});
}

std::string to_message(const ViewPose& pose) {
  Json elements = Json::array();
  const Eigen::Matrix4d matrix = pose.T_world_camera.matrix();
  for (Eigen::Index i = 0; i < matrix.size(); ++i) elements.push_back(matrix.data()[i]);  // column by column
  return text_of(
      {{"type", "pose"}, {"T", elements}, {"half", {pose.half.x(), pose.half.y()}}, {"is_lost", pose.is_lost}});
}

std::string to_message(const std::vector<ViewFile>& files) {
  Json list = Json::array();
  for (const ViewFile& file : files) list.push_back({{"name", file.name}, {"bytes", file.bytes}});
  return text_of({{"type", "files"}, {"files", list}});
}

std::string to_message(const CropBox& box) {
  Json corners = nullptr;
  if (box) corners = Json::array({numbers(box->min()), numbers(box->max())});
  return text_of({{"type", "crop"}, {"box", corners}});
}

std::string trail_message(const std::vector<Eigen::Vector3d>& points) {
  Json list = Json::array();
  for (const Eigen::Vector3d& point : points) list.push_back(numbers(point));
  return text_of({{"type", "trail"}, {"points", list}});
}

std::string ack_message(std::uint64_t id, std::string_view error) {
  return text_of({{"type", "ack"}, {"id", id}, {"ok", error.empty()}, {"error", error}});
}

Result<std::variant<ViewCredit, ViewCommand>> parse_client_message(std::string_view text) {
  const Json message = Json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!message.is_object()) return no_message("expected a JSON object");
  if (message.contains("cmd")) return command_of(message);
  const auto got = message.find("got");
  constexpr std::uint32_t kMostAtOnce = 1'000;
  if (got == message.end() || !got->is_number_unsigned() || got->get<std::uint64_t>() > kMostAtOnce)
    return no_message("expected cmd, or got with a number of messages");
  return std::variant<ViewCredit, ViewCommand>(ViewCredit{got->get<std::uint32_t>()});
}

}  // namespace scanknit
