// ViewServer: the live view's pages and messages over HTTP and WebSocket, on one port, by one thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/bounded_queue.h"
#include "core/result.h"
#include "view/live_view.h"
#include "view/view_scene.h"

namespace scanknit {

/// What is served. For the server's thread only, but for what is atomic or a queue.
struct ViewHub {
  ViewScene scene;
  std::map<std::string, std::filesystem::path> files;  ///< that can be downloaded, by name
  std::vector<ViewBytes> announcements;                ///< texts that each client is still to be told
  BoundedQueue<ViewCommand> commands{64};
  std::string refusal;  ///< what commands are answered with; empty: they are taken
  std::atomic<std::size_t> clients = 0;
};

class ViewServer {
 public:
  /// As LiveView::start(). `hello` is what every client is told first.
  [[nodiscard]] static Result<std::unique_ptr<ViewServer>> start(const LiveViewOptions& options, ViewBytes hello);

  /// Gives the clients up to two seconds to receive the last messages, and ends as soon as all have.
  ~ViewServer();
  ViewServer(const ViewServer&) = delete;
  ViewServer& operator=(const ViewServer&) = delete;

  [[nodiscard]] std::vector<std::string> links() const;

  /// Has the server's thread do `change`, and give every client its news. Returns at once.
  void change(std::function<void(ViewHub&)> change);
  /// Nothing happens when that client has gone.
  void tell(std::uint64_t client, ViewBytes text);

  [[nodiscard]] ViewHub& hub() { return *hub_; }

 private:
  class Network;
  ViewServer();
  std::unique_ptr<ViewHub> hub_;
  std::unique_ptr<Network> network_;  // last: its thread uses the hub
};

}  // namespace scanknit
