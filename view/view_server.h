// ViewServer: serves the live view's pages and messages over HTTP and WebSocket, on one port, with one thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/system/bounded_queue.h"
#include "view/live_view.h"
#include "view/view_scene.h"

namespace scanknit {

/// The data that is served. For the server's thread only, except the atomic members and queues.
struct ViewHub {
  ViewScene scene;
  std::map<std::string, std::filesystem::path> files;  ///< files that can be downloaded, by name
  std::vector<ViewBytes> announcements;                ///< texts that must still be sent to every client
  BoundedQueue<ViewCommand> commands{64};
  std::string refusal;  ///< the answer to all commands; empty: commands are accepted
  std::atomic<std::size_t> clients = 0;
};

class ViewServer {
 public:
  /// Like LiveView::start(). `hello`: the first message for every client.
  [[nodiscard]] static Result<std::unique_ptr<ViewServer>> start(const LiveViewOptions& options, ViewBytes hello);

  /// Waits until all clients have received the last messages, for at most two seconds.
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  [[nodiscard]] std::vector<std::string> links() const;

  /// Makes the server's thread call `change` and send the changes to all clients. Returns at once.
  void change(std::function<void(ViewHub&)> change);
  /// Sends a text to one client; does nothing if it has disconnected.
  void send_to(std::uint64_t client, ViewBytes text);

  [[nodiscard]] ViewHub& hub() { return *hub_; }

 private:
  class Network;
  ViewServer();
  std::unique_ptr<ViewHub> hub_;
  std::unique_ptr<Network> network_;  // declared last, because its thread uses the hub
};

}  // namespace scanknit
