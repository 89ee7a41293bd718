// LiveView: a scan as a page in the browser, served while it goes on (docs/live_view.md).
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "view/view_messages.h"

namespace scanknit {

struct LiveViewOptions {
  std::string address = "127.0.0.1";  ///< IPv4 or IPv6; "0.0.0.0": all of this computer's
  std::optional<std::uint16_t> port;  ///< nothing: 8765, or any free one when that is taken; 0: any free one
  std::string token = {};             ///< empty: a random one where the address can be reached from other computers
};

class ViewServer;

/// One thread of low priority serves all clients. Every function may be called from any one thread, returns at once and
/// never waits for a client: what is published replaces what was, and goes out as fast as each client takes it.
class LiveView {
 public:
  /// Errors: kUsage for an address that is none; kOutput when it cannot be listened on.
  [[nodiscard]] static Result<std::unique_ptr<LiveView>> start(const LiveViewOptions& options, const ViewHello& hello);

  /// Gives the clients up to two seconds to receive the last messages, and ends as soon as all have.
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  /// Where the page is: an address for each way to reach this computer, with the token if there is one.
  [[nodiscard]] std::vector<std::string> links() const;

  void publish(const ViewState& state);
  void publish(const ViewPose& pose);
  void publish(const CropBox& box);
  /// `message` of view/mesh_chunk.h.
  void publish_chunk(std::uint32_t chunk, std::string message);
  void publish_picture(std::string message);
  /// What can be downloaded; each under the name that it has in its folder. Nothing else is served.
  void publish_files(const std::vector<std::filesystem::path>& paths);
  /// Where the camera was, world metres, in place of what was published of that.
  void publish_trail(const std::vector<Eigen::Vector3d>& positions);
  /// All chunks and the trail go.
  void clear(std::uint32_t revision);

  /// What somebody asked for; nothing when nobody did within `timeout`, or when stopped.
  [[nodiscard]] std::optional<ViewCommand> next_command(std::stop_token stop, std::chrono::nanoseconds timeout);
  /// From now on commands are answered with `why` and do not arrive here; empty: they do.
  void refuse_commands(std::string why);
  /// `error` empty: it was done.
  void answer(const ViewCommand& command, std::string_view error);

  /// Clients that are looking on.
  [[nodiscard]] std::size_t clients() const;

 private:
  explicit LiveView(std::unique_ptr<ViewServer> server);
  std::unique_ptr<ViewServer> server_;
};

}  // namespace scanknit
