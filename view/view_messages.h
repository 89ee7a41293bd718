// What the live view's server and page say to each other as text (docs/live_view.md): JSON out, JSON in.
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

/// What somebody at the page can ask for.
enum class ViewAction { kStart, kPause, kReset, kCrop, kExport, kFinish };

/// What does not change while the view is open.
struct ViewHello {
  std::string title;                               ///< the input's name
  std::string mode = "run";                        ///< "run", "capture" or "file"
  Eigen::Vector3d up = Eigen::Vector3d(0, -1, 0);  ///< unit, in the world
  bool is_orbit = false;                           ///< an object that is walked round or turned
  bool is_paced = false;                           ///< frames come whether they are taken or not
  double voxel_size_m = 0;                         ///< 0: unknown
  std::vector<ViewAction> actions = {};            ///< those that are answered
};

enum class ViewPhase { kWaiting, kScanning, kPaused, kExporting, kFinished, kFailed };

struct ViewState {
  ViewPhase phase = ViewPhase::kWaiting;
  std::string tracking = "none";  ///< "ok", "weak", "lost", "recovered"; "none" where poses are given; "unusable":
                                  ///< frames come, but nothing can be made of them
  std::string reason = {};        ///< of these; empty when ok
  std::string advice = {};        ///< what to do now, for a person; may be empty
  std::size_t frame = 0;          ///< frames read
  std::size_t frames_total = 0;   ///< 0: unknown
  std::size_t fused = 0, dropped = 0, lost = 0;
  double fps = 0;            ///< frames fused a second, lately
  std::size_t silent_s = 0;  ///< for how long a scanner has sent nothing; 0: less than two seconds
  std::map<std::string, std::uint64_t> losses = {};  ///< pictures lost before anybody could fuse them, by where
  std::size_t triangles = 0;
  bool is_behind = false;      ///< the scan has more than the mesh that is shown
  bool is_crop_empty = false;  ///< no triangle lies within the crop box in force: Finish would write all of the mesh
  double memory_mib = 0;       ///< of the volume
  double view_share = 0;       ///< time spent on the view / time of the scan
  std::string message = {};    ///< of kFinished and kFailed; of kWaiting and kExporting what is worked on

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
/// Where the camera was, world metres.
[[nodiscard]] std::string trail_message(const std::vector<Eigen::Vector3d>& points);
/// `error` empty: it was done.
[[nodiscard]] std::string ack_message(std::uint64_t id, std::string_view error);

struct ViewCommand {
  ViewAction action = ViewAction::kStart;
  CropBox box = {};          ///< of kCrop
  std::uint64_t id = 0;      ///< the client's own, for the answer
  std::uint64_t client = 0;  ///< whom to answer
};

/// So many binary messages have been used.
struct ViewCredit {
  std::uint32_t messages = 0;
};

/// Errors (kInput): anything that docs/live_view.md does not name.
[[nodiscard]] Result<std::variant<ViewCredit, ViewCommand>> parse_client_message(std::string_view text);

}  // namespace scanknit
