#include "view/live_view.h"

#include <map>
#include <system_error>
#include <utility>

#include "view/page_files.h"
#include "view/view_server.h"

namespace scanknit {

LiveView::LiveView(std::unique_ptr<ViewServer> server) : server_(std::move(server)) {}
LiveView::~LiveView() = default;

Result<std::unique_ptr<LiveView>> LiveView::start(const LiveViewOptions& options, const ViewHello& hello) {
  if (page_files().empty()) {
    return Error{ErrorCode::kUsage,
                 "this program was built without the live view's page; ./quickstart.sh build builds it in"};
  }
  auto server = ViewServer::start(options, shared_text(to_message(hello)));
  if (!server) return server.error();
  return std::unique_ptr<LiveView>(new LiveView(*std::move(server)));
}

std::vector<std::string> LiveView::links() const {
  return server_->links();
}

void LiveView::publish(const ViewState& state) {
  server_->change([text = shared_text(to_message(state))](ViewHub& hub) {
    hub.scene.state = text;
    ++hub.scene.state_serial;
  });
}

void LiveView::publish(const ViewPose& pose) {
  server_->change([text = shared_text(to_message(pose)), pose](ViewHub& hub) {
    hub.scene.pose = text;
    ++hub.scene.pose_serial;
    if (!pose.is_lost) hub.scene.add_to_trail(pose.T_world_camera.translation());
  });
}

void LiveView::publish(const CropBox& box) {
  server_->change([text = shared_text(to_message(box))](ViewHub& hub) {
    hub.scene.crop = text;
    hub.announcements.push_back(text);
  });
}

void LiveView::publish_chunk(std::uint32_t chunk, std::string message) {
  server_->change(
      [chunk, bytes = shared_text(std::move(message))](ViewHub& hub) { hub.scene.set_chunk(chunk, bytes); });
}

void LiveView::publish_picture(std::string message) {
  server_->change([bytes = shared_text(std::move(message))](ViewHub& hub) {
    hub.scene.picture = bytes;
    ++hub.scene.picture_serial;
  });
}

void LiveView::publish_files(const std::vector<std::filesystem::path>& paths) {
  std::map<std::string, std::filesystem::path> files;
  std::vector<ViewFile> listed;
  for (const std::filesystem::path& path : paths) {
    std::error_code error;
    const auto bytes = std::filesystem::file_size(path, error);
    if (error || !files.emplace(path.filename().string(), path).second) continue;
    listed.push_back({path.filename().string(), bytes});
  }
  server_->change([files = std::move(files), text = shared_text(to_message(listed))](ViewHub& hub) {
    hub.files = files;
    hub.scene.files = text;
    hub.announcements.push_back(text);
  });
}

void LiveView::publish_trail(const std::vector<Eigen::Vector3d>& positions) {
  server_->change([positions](ViewHub& hub) {
    hub.scene.set_trail(positions);
    hub.announcements.push_back(shared_text(trail_message(hub.scene.trail())));
  });
}

void LiveView::clear(std::uint32_t revision) {
  server_->change([revision](ViewHub& hub) {
    hub.scene.clear(revision);
    hub.announcements.push_back(shared_text(trail_message({})));
  });
}

std::optional<ViewCommand> LiveView::next_command(std::stop_token stop, std::chrono::nanoseconds timeout) {
  return server_->hub().commands.pop(std::move(stop), timeout);
}

void LiveView::refuse_commands(std::string why) {
  server_->change([why = std::move(why)](ViewHub& hub) { hub.refusal = why; });
}

void LiveView::answer(const ViewCommand& command, std::string_view error) {
  server_->send_to(command.client, shared_text(ack_message(command.id, error)));
}

std::size_t LiveView::clients() const {
  return server_->hub().clients;
}

}  // namespace scanknit
