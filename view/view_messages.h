// The JSON messages between the live view's server and its page (docs/live_view.md).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "core/axes.h"
#include "core/pose.h"
#include "core/result.h"

namespace scanknit {

/// The commands of the page.
enum class ViewAction { kStart, kPause, kReset, kCrop, kExport, kFinish };

/// The properties that do not change while the view is open.
struct ViewHello {
  std::string title;                               ///< the input's name
  std::string mode = "run";                        ///< "run", "capture" or "file"
  Eigen::Vector3d up = Eigen::Vector3d(0, -1, 0);  ///< unit, in the world
  bool is_orbit = false;                           ///< the scan is of one object: the user walks round it, or it turns
  bool is_paced = false;                           ///< frames come at their own pace
  double voxel_size_m = 0;                         ///< 0: unknown
  std::string tiles = {};                ///< of a mesh in tiles: the path of tileset.json on the server; or empty
  std::vector<ViewAction> actions = {};  ///< the commands that the program accepts
};

enum class ViewPhase { kWaiting, kScanning, kPaused, kExporting, kFinished, kFailed };

struct ViewState {
  ViewPhase phase = ViewPhase::kWaiting;
  std::string tracking = "none";  ///< "ok", "weak", "lost", "recovered"; "none" where poses are given; "unusable":
                                  ///< frames come, but nothing can be made of them
  std::string reason = {};        ///< why tracking is not ok; empty when it is
  std::string advice = {};        ///< advice for the user; may be empty
  std::size_t frame = 0;          ///< frames read
  std::size_t frames_total = 0;   ///< 0: unknown
  std::size_t fused = 0, dropped = 0, lost = 0;
  double fps = 0;            ///< frames fused a second, recently
  std::size_t silent_s = 0;  ///< seconds since a scanner sent its last picture; 0: less than two
  std::map<std::string, std::uint64_t> losses = {};  ///< pictures lost before fusion, by where
  std::size_t triangles = 0;
  bool is_behind = false;      ///< the mesh on the page does not show the newest frames yet
  bool is_crop_empty = false;  ///< no triangle lies within the crop box in force: Finish would write the whole mesh
  double memory_mib = 0;       ///< of the volume
  double view_share = 0;       ///< time spent on the view / time of the scan
  std::string message = {};    ///< for kFinished and kFailed the outcome; for kWaiting and kExporting the current work

  friend bool operator==(const ViewState&, const ViewState&) = default;
};

struct ViewPose {
  Pose T_world_camera = Pose::Identity();
  Eigen::Vector2d half = Eigen::Vector2d::Zero();  ///< half the picture's width and height at one metre, metres
  bool is_lost = false;
};

struct ViewFile {
  std::string name;
  std::uintmax_t bytes = 0;
};

[[nodiscard]] std::string to_message(const ViewHello& hello);
[[nodiscard]] std::string to_message(const ViewState& state);
[[nodiscard]] std::string to_message(const ViewPose& pose);
[[nodiscard]] std::string to_message(const std::vector<ViewFile>& files);
[[nodiscard]] std::string to_message(const CropBox& box);
/// The camera's past positions, in the world, metres.
[[nodiscard]] std::string trail_message(const std::vector<Eigen::Vector3d>& points);
/// The answer to a command; `error` empty: it was done.
[[nodiscard]] std::string ack_message(std::uint64_t id, std::string_view error);

struct ViewCommand {
  ViewAction action = ViewAction::kStart;
  CropBox box = {};          ///< for kCrop
  std::uint64_t id = 0;      ///< the client's number of the command, for the answer
  std::uint64_t client = 0;  ///< the client to answer
};

/// The client has processed so many binary messages.
struct ViewCredit {
  std::uint32_t messages = 0;
};

/// Errors (kInput): any message that docs/live_view.md does not define.
[[nodiscard]] Result<std::variant<ViewCredit, ViewCommand>> parse_client_message(std::string_view text);

}  // namespace scanknit
