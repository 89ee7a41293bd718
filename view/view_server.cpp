// This is the only file that uses Boost.Beast.
#include "view/view_server.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <chrono>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "core/version.h"
#include "view/own_addresses.h"
#include "view/page_files.h"
#include "view/view_access.h"
#include "view/view_feed.h"
#include "view/view_routes.h"

namespace scanknit {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using Tcp = asio::ip::tcp;
using ErrorCodeOf = beast::error_code;

constexpr std::uint16_t kUsualPort = 8765;
constexpr std::size_t kMostConnections = 96;
constexpr std::size_t kMostClients = 32;
constexpr std::uint32_t kMostHeaderBytes = 8 * 1024;
constexpr std::size_t kMostMessageBytes = 64 * 1024;
constexpr std::chrono::seconds kRequestTimeout{5};
constexpr std::chrono::seconds kIdleTimeout{30};
constexpr std::chrono::seconds kCloseTimeout{2};  // a page that draws on a busy processor needs one second
constexpr std::size_t kFilePieceBytes = 64 * 1024;
constexpr const char* kSubprotocol = "scanknit.v1";

std::string_view view_of(beast::string_view text) {
  return {text.data(), text.size()};
}

using Request = http::request<http::string_body>;

/// True when a WebSocket's client offers our protocol.
bool speaks_our_protocol(const Request& request) {
  return http::token_list(request[http::field::sec_websocket_protocol]).exists(kSubprotocol);
}

/// The state that all connections share.
struct Hub {
  Hub(ViewHub& view_, std::string token_) : view(view_), token(std::move(token_)) {}

  ViewHub& view;
  const std::string token;  ///< empty: none is required
  std::uint16_t port = 0;
  std::map<std::uint64_t, class Client*> clients;
  std::uint64_t last_client = 0;
  std::set<class Connection*> connections;

  [[nodiscard]] std::string cookie_name() const { return fmt::format("scanknit_{}", port); }
};

/// The connection of one open page.
class Client : public std::enable_shared_from_this<Client> {
 public:
  Client(Tcp::socket socket, Hub& hub) : hub_(hub), stream_(std::move(socket)) {
    auto timeout = websocket::stream_base::timeout::suggested(beast::role_type::server);
    timeout.handshake_timeout = kRequestTimeout;
    timeout.idle_timeout = kIdleTimeout;
    stream_.set_option(timeout);
    stream_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
      response.set(http::field::server, std::string("scanknit ") + kVersion);
      response.set(http::field::sec_websocket_protocol, kSubprotocol);
    }));
    stream_.read_message_max(kMostMessageBytes);
    stream_.auto_fragment(false);
  }

  ~Client() {
    if (number_ == 0) return;
    hub_.clients.erase(number_);
    hub_.view.clients = hub_.clients.size();
  }

  void run(Request request) {
    auto kept = std::make_shared<Request>(std::move(request));
    stream_.async_accept(*kept, [self = shared_from_this(), kept](ErrorCodeOf error) {
      if (!error) self->begin();
    });
  }

  void send_text(ViewBytes text) {
    if (!feed_->queue_text(std::move(text))) return close();
    pump();
  }

  /// Sends the next message, if there is one and the client can receive it now.
  void pump() {
    if (is_writing_ || is_closed_) return;
    if (is_leaving_ && feed_->is_up_to_date()) return send_close(websocket::close_code::going_away);
    const auto [message, is_text] = feed_->next();
    if (message == nullptr) return;
    is_writing_ = true;
    stream_.text(is_text);
    stream_.async_write(asio::buffer(*message),
                        [self = shared_from_this(), kept = message](ErrorCodeOf error, std::size_t) {
                          self->is_writing_ = false;
                          if (error) return self->close();
                          self->pump();
                        });
  }

  /// Closes the connection after everything was sent and the client has acknowledged it.
  void leave() {
    is_leaving_ = true;
    pump();
  }

  void close() {
    is_closed_ = true;
    beast::get_lowest_layer(stream_).cancel();
  }

 private:
  void begin() {
    number_ = ++hub_.last_client;
    hub_.clients[number_] = this;
    hub_.view.clients = hub_.clients.size();
    feed_.emplace(hub_.view.scene);
    pump();
    read();
  }

  void read() {
    stream_.async_read(buffer_, [self = shared_from_this()](ErrorCodeOf error, std::size_t) {
      if (error || self->is_closed_) return;
      const std::string text = beast::buffers_to_string(self->buffer_.data());
      self->buffer_.consume(self->buffer_.size());
      if (!self->stream_.got_text() || !self->take(text)) return self->send_close(websocket::close_code::policy_error);
      self->read();
    });
  }

  /// Closes with a handshake: the client receives everything sent before, then answers.
  void send_close(websocket::close_code why) {
    is_closed_ = true;
    stream_.async_close(why, [self = shared_from_this()](ErrorCodeOf) {});
  }

  bool take(const std::string& text) {
    auto message = parse_client_message(text);
    if (!message) return false;
    if (const auto* credit = std::get_if<ViewCredit>(&*message)) {
      feed_->give_credit(credit->messages);
      pump();
      return true;
    }
    ViewCommand& command = std::get<ViewCommand>(*message);
    command.client = number_;
    const std::uint64_t id = command.id;
    if (!hub_.view.refusal.empty()) {
      send_text(shared_text(ack_message(id, hub_.view.refusal)));
    } else if (!hub_.view.commands.try_push(std::move(command))) {
      send_text(shared_text(ack_message(id, "too many commands are waiting; try again in a moment")));
    }
    return true;
  }

  Hub& hub_;
  websocket::stream<beast::tcp_stream> stream_;
  beast::flat_buffer buffer_;
  std::optional<ViewFeed> feed_;  ///< set after the handshake
  std::uint64_t number_ = 0;
  bool is_writing_ = false, is_leaving_ = false, is_closed_ = false;
};

/// An HTTP connection, until it closes or becomes a Client.
class Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(Tcp::socket socket, Hub& hub) : hub_(hub), stream_(std::move(socket)) { hub_.connections.insert(this); }
  ~Connection() { hub_.connections.erase(this); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void read() {
    is_trusted_ = false;
    since_ = std::chrono::steady_clock::now();
    parser_.emplace();
    parser_->header_limit(kMostHeaderBytes);
    parser_->body_limit(0);
    stream_.expires_after(kRequestTimeout);
    http::async_read(stream_, buffer_, *parser_, [self = shared_from_this()](ErrorCodeOf error, std::size_t) {
      if (error == http::error::body_limit && self->parser_->get().method() != http::verb::get)
        return self->refuse(http::status::method_not_allowed, "Only GET is answered.");
      if (error == http::error::body_limit || error == http::error::header_limit)
        return self->refuse(http::status::payload_too_large, "This request is too large.");
      if (error) return;
      self->answer(self->parser_->release());
    });
  }

  /// True when it may be closed to make room: its client has not shown a token.
  [[nodiscard]] bool may_be_closed() const { return !is_trusted_; }
  [[nodiscard]] std::chrono::steady_clock::time_point since() const { return since_; }

  void end() {
    hub_.connections.erase(this);
    stream_.close();
  }

 private:
  void answer(Request request) {
    keeps_alive_ = request.keep_alive();
    host_ = std::string(view_of(request[http::field::host]));
    const ViewRequest asked{.is_get = request.method() == http::verb::get,
                            .hosts = request.count(http::field::host),
                            .target = view_of(request.target()),
                            .host = host_,
                            .cookie = view_of(request[http::field::cookie])};
    const ViewRoute route = route_of(asked, hub_.token, hub_.cookie_name());
    is_trusted_ = route.is_trusted;
    switch (route.place) {
      case ViewPlace::kRefused: return refuse(static_cast<http::status>(route.status), route.why);
      case ViewPlace::kPage: return send_page(route.name);
      case ViewPlace::kLive: return become_client(std::move(request));
      case ViewPlace::kState: return send_state();
      case ViewPlace::kFile: return send_file(route.name);
    }
  }

  void become_client(Request request) {
    const auto origin = request.count(http::field::origin) == 1 ? view_of(request[http::field::origin]) : "";
    if (!websocket::is_upgrade(request)) return refuse(http::status::upgrade_required, "This is for WebSockets.");
    if (!is_own_origin(origin, host_)) return refuse(http::status::forbidden, "Another web page asked for this.");
    if (!speaks_our_protocol(request)) return refuse(http::status::bad_request, "The subprotocol is scanknit.v1.");
    if (hub_.clients.size() >= kMostClients)
      return refuse(http::status::service_unavailable, "Too many pages are looking on already.");
    stream_.expires_never();  // the WebSocket has its own timeouts
    std::make_shared<Client>(stream_.release_socket(), hub_)->run(std::move(request));
  }

  template <typename Body>
  void set_fields(http::response<Body>& response, std::string_view type) {
    response.set(http::field::server, std::string("scanknit ") + kVersion);
    response.set(http::field::content_type, std::string(type));
    response.set(http::field::cache_control, "no-store");
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Referrer-Policy", "no-referrer");
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    response.keep_alive(keeps_alive_);
  }

  void send_page(const std::string& path) {
    const PageFile& file =
        *std::find_if(page_files().begin(), page_files().end(), [&](const PageFile& one) { return one.path == path; });
    http::response<http::string_body> response(http::status::ok, 11);
    set_fields(response, file.type);
    response.set("Content-Security-Policy",
                 fmt::format("default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; "
                             "connect-src 'self' ws://{}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
                             host_));
    if (file.path == "/" && !hub_.token.empty()) {
      response.set(http::field::set_cookie,
                   fmt::format("{}={}; HttpOnly; SameSite=Strict; Path=/", hub_.cookie_name(), hub_.token));
    }
    response.body() = std::string(file.bytes);
    send(std::move(response));
  }

  void send_state() {
    if (hub_.view.scene.state == nullptr) return refuse(http::status::not_found, "There is no state yet.");
    send_text(http::status::ok, "application/json", *hub_.view.scene.state);
  }

  void send_text(http::status status, std::string_view type, std::string text) {
    http::response<http::string_body> response(status, 11);
    set_fields(response, type);
    response.body() = std::move(text);
    send(std::move(response));
  }

  /// Sends an error and closes the connection, without reading further requests.
  void refuse(http::status status, const char* why) {
    keeps_alive_ = false;
    send_text(status, "text/plain; charset=utf-8", std::string(why) + "\n");
  }

  void send_file(const std::string& name) {
    const auto file = hub_.view.files.find(name);
    if (file == hub_.view.files.end()) return refuse(http::status::not_found, "There is no such file.");
    http::response<http::file_body> response(http::status::ok, 11);
    ErrorCodeOf error;
    response.body().open(file->second.c_str(), beast::file_mode::scan, error);
    if (error) return refuse(http::status::not_found, "The file is not there any more.");
    set_fields(response, "application/octet-stream");
    response.set(http::field::content_disposition,
                 fmt::format("attachment; filename*=UTF-8''{}", percent_encoded(name)));
    send(std::move(response));
  }

  template <typename Body>
  void send(http::response<Body> response) {
    response.prepare_payload();
    auto kept = std::make_shared<http::response<Body>>(std::move(response));
    auto rest = std::make_shared<http::response_serializer<Body>>(*kept);
    rest->limit(kFilePieceBytes);
    write_some(kept, rest);
  }

  /// Writes a response piece by piece; each piece has its own timeout, so that a slow network can receive a large file.
  template <typename Response, typename Serializer>
  void write_some(std::shared_ptr<Response> response, std::shared_ptr<Serializer> rest) {
    stream_.expires_after(kIdleTimeout);
    http::async_write_some(stream_, *rest, [self = shared_from_this(), response, rest](ErrorCodeOf error, std::size_t) {
      if (error) return;
      if (!rest->is_done()) return self->write_some(response, rest);
      if (self->keeps_alive_) return self->read();
      ErrorCodeOf ignored;
      self->stream_.socket().shutdown(Tcp::socket::shutdown_send, ignored);
    });
  }

  Hub& hub_;
  beast::tcp_stream stream_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::string host_;
  bool keeps_alive_ = false, is_trusted_ = false;
  std::chrono::steady_clock::time_point since_;  ///< when it began to wait for its request
};

}  // namespace

class ViewServer::Network {
 public:
  Network(const asio::ip::address& address, std::string token, ViewHub& view)
      : address_(address), hub_(view, std::move(token)) {}

  ~Network() {
    if (!thread_.joinable()) return;
    const auto deadline = std::chrono::steady_clock::now() + kCloseTimeout;
    asio::post(io_, [this, deadline] { say_good_bye(deadline); });
    thread_.join();
  }

  Result<void> listen(std::optional<std::uint16_t> port) {
    ErrorCodeOf error = listen_on(port.value_or(kUsualPort));
    if (error == asio::error::address_in_use && !port) error = listen_on(0);
    if (!error) return {};
    const std::string where = fmt::format("{} port {}", address_.to_string(), port.value_or(kUsualPort));
    if (error == asio::error::address_in_use)
      return Error{ErrorCode::kOutput, "another program listens there; port 0 takes any free port", where};
    return Error{ErrorCode::kOutput, "the live view cannot listen there: " + error.message(), where};
  }

  void start() {
    hub_.port = acceptor_.local_endpoint().port();
    accept();
    thread_ = std::thread([this] {
      pthread_setname_np(pthread_self(), "view");
      constexpr int kLower = 10;  // nice levels below the program
      const auto thread = static_cast<id_t>(gettid());
      (void)setpriority(PRIO_PROCESS, thread,
                        getpriority(PRIO_PROCESS, thread) + kLower);  // on Linux this affects only this thread
      io_.run();
    });
  }

  [[nodiscard]] std::vector<std::string> links() const {
    std::vector<std::string> hosts;
    if (address_.is_unspecified()) hosts = own_addresses(address_.is_v6());
    if (hosts.empty()) hosts.push_back(address_.is_unspecified() ? "127.0.0.1" : address_.to_string());
    std::vector<std::string> links;
    for (const std::string& host : hosts) links.push_back(link_to(host, hub_.port, hub_.token));
    return links;
  }

  void change(std::function<void(ViewHub&)> change) {
    asio::post(io_, [this, change = std::move(change)] {
      change(hub_.view);
      for (const ViewBytes& text : std::exchange(hub_.view.announcements, {}))
        for_each_client([&](Client& client) { client.send_text(text); });
      for_each_client([](Client& client) { client.pump(); });
    });
  }

  void send_to(std::uint64_t number, ViewBytes text) {
    asio::post(io_, [this, number, text = std::move(text)] {
      const auto client = hub_.clients.find(number);
      if (client != hub_.clients.end()) client->second->send_text(text);
    });
  }

 private:
  /// Visits all clients; a client may disconnect during its visit.
  template <typename Visit>
  void for_each_client(const Visit& visit) {
    std::vector<std::shared_ptr<Client>> clients;
    for (const auto& [number, client] : hub_.clients) clients.push_back(client->shared_from_this());
    for (const auto& client : clients) visit(*client);
  }

  ErrorCodeOf listen_on(std::uint16_t port) {
    ErrorCodeOf error;
    const Tcp::endpoint endpoint(address_, port);
    if (acceptor_.is_open()) acceptor_.close(error);
    acceptor_.open(endpoint.protocol(), error);
    if (!error) acceptor_.set_option(asio::socket_base::reuse_address(true), error);
    if (!error) acceptor_.bind(endpoint, error);
    if (!error) acceptor_.listen(asio::socket_base::max_listen_connections, error);
    return error;
  }

  void accept() {
    acceptor_.async_accept([this](ErrorCodeOf error, Tcp::socket socket) {
      if (error == asio::error::operation_aborted) return;
      if (error) return accept_later();  // most likely out of file descriptors
      if (has_room()) {
        ErrorCodeOf ignored;
        socket.set_option(Tcp::no_delay(true), ignored);
        std::make_shared<Connection>(std::move(socket), hub_)->read();
      }
      accept();
    });
  }

  /// Makes room, if necessary, by closing the untrusted connection that has waited longest: strangers' connections
  /// cannot block the server.
  bool has_room() {
    if (hub_.connections.size() + hub_.clients.size() < kMostConnections) return true;
    Connection* first = nullptr;
    for (Connection* one : hub_.connections) {
      if (one->may_be_closed() && (first == nullptr || one->since() < first->since())) first = one;
    }
    if (first == nullptr) return false;
    first->end();
    return true;
  }

  void accept_later() {
    pause_.expires_after(std::chrono::milliseconds(200));
    pause_.async_wait([this](ErrorCodeOf error) {
      if (!error) accept();
    });
  }

  void say_good_bye(std::chrono::steady_clock::time_point deadline) {
    ErrorCodeOf ignored;
    acceptor_.close(ignored);
    for_each_client([](Client& client) { client.leave(); });
    if (hub_.clients.empty() || std::chrono::steady_clock::now() >= deadline) return io_.stop();
    pause_.expires_after(std::chrono::milliseconds(10));
    pause_.async_wait([this, deadline](ErrorCodeOf) { say_good_bye(deadline); });
  }

  asio::ip::address address_;
  Hub hub_;
  asio::io_context io_{1};  // declared after hub_, because its connections use the hub
  Tcp::acceptor acceptor_{io_};
  asio::steady_timer pause_{io_};
  std::thread thread_;
};

ViewServer::ViewServer() : hub_(std::make_unique<ViewHub>()) {}
ViewServer::~ViewServer() = default;

Result<std::unique_ptr<ViewServer>> ViewServer::start(const LiveViewOptions& options, ViewBytes hello) {
  ErrorCodeOf error;
  std::string named = options.address == "localhost" ? "127.0.0.1" : options.address;
  if (named.size() > 2 && named.front() == '[' && named.back() == ']') named = named.substr(1, named.size() - 2);
  const auto address = asio::ip::make_address(named, error);
  if (error) {
    return Error{ErrorCode::kUsage,
                 "expected a numeric address of this computer, such as 192.168.0.7, or 0.0.0.0 for all of them",
                 options.address};
  }
  std::string token = options.token;
  if (token.empty() && !address.is_loopback()) token = random_token();
  std::unique_ptr<ViewServer> server(new ViewServer);
  server->hub_->scene.hello = std::move(hello);
  server->hub_->scene.files = shared_text(to_message(std::vector<ViewFile>{}));
  server->hub_->scene.crop = shared_text(to_message(CropBox{}));
  server->network_ = std::make_unique<Network>(address, std::move(token), *server->hub_);
  if (auto listening = server->network_->listen(options.port); !listening) return listening.error();
  server->network_->start();
  return server;
}

std::vector<std::string> ViewServer::links() const {
  return network_->links();
}

void ViewServer::change(std::function<void(ViewHub&)> change) {
  network_->change(std::move(change));
}

void ViewServer::send_to(std::uint64_t client, ViewBytes text) {
  network_->send_to(client, std::move(text));
}

}  // namespace scanknit
