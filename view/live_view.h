// LiveView: serves a page that shows a running scan in the browser (docs/live_view.md).
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
  std::string address = "127.0.0.1";  ///< IPv4 or IPv6; "0.0.0.0": all addresses of this computer
  std::optional<std::uint16_t> port;  ///< nothing: 8765, or any free port if that one is in use; 0: any free port
  std::string token = {};             ///< empty: a random one if other computers can reach the address
};

class ViewServer;

/// One thread of low priority serves all clients. Call all functions from the same thread. They return at once and
/// never wait for a client: a published value replaces the last one, and each client gets it as fast as it can receive.
class LiveView {
 public:
  /// Errors: kUsage for an invalid address; kOutput when the server cannot listen on it.
  [[nodiscard]] static Result<std::unique_ptr<LiveView>> start(const LiveViewOptions& options, const ViewHello& hello);

  /// Waits until all clients have received the last messages, for at most two seconds.
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  /// The page's URLs: one for each address of this computer, with the token if there is one.
  [[nodiscard]] std::vector<std::string> links() const;

  void publish(const ViewState& state);
  void publish(const ViewPose& pose);
  void publish(const CropBox& box);
  /// `message`: from view/mesh_chunk.h.
  void publish_chunk(std::uint32_t chunk, std::string message);
  void publish_picture(std::string message);
  /// Sets the files that can be downloaded, each under its file name. Serves no other files.
  void publish_files(const std::vector<std::filesystem::path>& paths);
  /// Replaces the camera's trail; positions in the world, metres.
  void publish_trail(const std::vector<Eigen::Vector3d>& positions);
  /// Removes all chunks and the trail from the page.
  void clear(std::uint32_t revision);

  /// The next command of a client; nothing when none comes within `timeout`, or when stopped.
  [[nodiscard]] std::optional<ViewCommand> next_command(std::stop_token stop, std::chrono::nanoseconds timeout);
  /// Answers all commands with `why` from now on, so that next_command() gets none; empty: accepts them again.
  void refuse_commands(std::string why);
  /// Answers the command; `error` empty: it was done.
  void answer(const ViewCommand& command, std::string_view error);

  /// The number of connected clients.
  [[nodiscard]] std::size_t clients() const;

 private:
  explicit LiveView(std::unique_ptr<ViewServer> server);
  std::unique_ptr<ViewServer> server_;
};

}  // namespace scanknit
