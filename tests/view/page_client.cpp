#include "tests/view/page_client.h"

#include <algorithm>
#include <boost/asio.hpp>
#include <boost/beast.hpp>
#include <cctype>
#include <chrono>
#include <utility>

namespace scanknit::test {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using Tcp = asio::ip::tcp;

using namespace std::chrono_literals;

constexpr auto kPatience = 60s;
constexpr auto kShortPatience = 500ms;

void connect_to(Tcp::socket& socket, std::uint16_t port) {
  socket.connect({asio::ip::make_address("127.0.0.1"), port});
}

std::string host_of(std::uint16_t port) {
  return "127.0.0.1:" + std::to_string(port);
}

}  // namespace

HttpAnswer http_request(std::uint16_t port, const std::string& method, const std::string& target,
                        const std::map<std::string, std::string>& fields, const std::string& body) {
  asio::io_context io;
  Tcp::socket socket(io);
  connect_to(socket, port);
  http::request<http::string_body> request;
  request.method_string(method);
  request.target(target);
  request.version(11);
  request.set(http::field::host, host_of(port));
  for (const auto& [name, value] : fields) request.set(name, value);
  request.body() = body;
  request.prepare_payload();
  beast::error_code error;
  http::write(socket, request, error);
  beast::flat_buffer buffer;
  http::response_parser<http::string_body> parser;
  parser.body_limit(64 * 1024 * 1024);
  http::async_read(socket, buffer, parser, [](beast::error_code, std::size_t) {});
  io.run_for(kPatience);
  HttpAnswer answer;
  if (!parser.is_header_done()) return answer;
  answer.status = static_cast<int>(parser.get().result_int());
  answer.body = parser.get().body();
  for (const auto& field : parser.get()) {
    std::string name(field.name_string());
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    answer.fields[name] = std::string(field.value());
  }
  return answer;
}

void send_bytes(std::uint16_t port, const std::string& bytes) {
  asio::io_context io;
  Tcp::socket socket(io);
  connect_to(socket, port);
  beast::error_code error;
  asio::write(socket, asio::buffer(bytes), error);
}

std::string answer_to(std::uint16_t port, const std::string& bytes) {
  asio::io_context io;
  Tcp::socket socket(io);
  connect_to(socket, port);
  beast::error_code error;
  asio::write(socket, asio::buffer(bytes), error);
  std::string answer;
  asio::async_read(socket, asio::dynamic_buffer(answer), [](beast::error_code, std::size_t) {});
  io.run_for(kPatience);
  return answer;
}

struct SilentConnection::Socket {
  asio::io_context io;
  Tcp::socket socket{io};
};

SilentConnection::SilentConnection(std::uint16_t port) : socket_(std::make_unique<Socket>()) {
  connect_to(socket_->socket, port);
}
SilentConnection::~SilentConnection() = default;

struct PageClient::Stream {
  asio::io_context io;
  beast::websocket::stream<Tcp::socket> socket{io};
  beast::flat_buffer buffer;
  bool is_reading = false, has_ended = false;
  std::optional<PageMessage> message;
};

PageClient::PageClient(std::unique_ptr<Stream> stream) : stream_(std::move(stream)) {}
PageClient::~PageClient() = default;

std::unique_ptr<PageClient> PageClient::connect(std::uint16_t port, const std::string& target,
                                                std::optional<std::string> origin, int* status) {
  auto stream = std::make_unique<Stream>();
  connect_to(stream->socket.next_layer(), port);
  stream->socket.set_option(beast::websocket::stream_base::decorator([&](beast::websocket::request_type& request) {
    const std::string value = origin.value_or("http://" + host_of(port));
    if (!value.empty()) request.set(http::field::origin, value);
    request.set(http::field::sec_websocket_protocol, "scanknit.v1");
  }));
  beast::error_code error;
  stream->socket.handshake(host_of(port), target, error);
  if (!error) return std::unique_ptr<PageClient>(new PageClient(std::move(stream)));
  if (status != nullptr) {  // once more, without a WebSocket's ears
    std::map<std::string, std::string> fields = {{"Upgrade", "websocket"},
                                                 {"Connection", "Upgrade"},
                                                 {"Sec-WebSocket-Key", "AAAAAAAAAAAAAAAAAAAAAA=="},
                                                 {"Sec-WebSocket-Version", "13"},
                                                 {"Sec-WebSocket-Protocol", "scanknit.v1"}};
    if (!origin || !origin->empty()) fields["Origin"] = origin.value_or("http://" + host_of(port));
    *status = http_request(port, "GET", target, fields).status;
  }
  return nullptr;
}

std::optional<PageMessage> PageClient::next() {
  return next_within(kPatience);
}

std::optional<PageMessage> PageClient::next_within(std::chrono::milliseconds patience) {
  Stream& stream = *stream_;
  if (stream.has_ended) return std::nullopt;
  if (!stream.is_reading) {
    stream.is_reading = true;
    stream.socket.async_read(stream.buffer, [&stream](beast::error_code error, std::size_t) {
      stream.is_reading = false;
      stream.has_ended = error.failed();
      if (!error) stream.message = {stream.socket.got_text(), beast::buffers_to_string(stream.buffer.data())};
      stream.buffer.consume(stream.buffer.size());
    });
  }
  const auto deadline = std::chrono::steady_clock::now() + patience;
  stream.io.restart();
  while (stream.is_reading && std::chrono::steady_clock::now() < deadline) stream.io.run_one_until(deadline);
  return std::exchange(stream.message, std::nullopt);
}

nlohmann::json PageClient::next_of(const std::string& type) {
  while (auto message = next()) {
    if (!message->is_text) {
      binaries.push_back(message->bytes);
      continue;
    }
    auto json = nlohmann::json::parse(message->bytes);
    if (json["type"] == type) return json;
  }
  return nullptr;
}

std::vector<std::string> PageClient::next_binaries(bool gives_credit) {
  std::vector<std::string> messages = std::move(binaries);
  binaries.clear();
  if (gives_credit && !messages.empty()) say("{\"got\":" + std::to_string(messages.size()) + "}");
  while (auto message = next_within(kShortPatience)) {
    if (message->is_text) continue;
    messages.push_back(message->bytes);
    if (gives_credit) say("{\"got\":1}");
  }
  return messages;
}

void PageClient::say(const std::string& text) {
  beast::error_code error;
  stream_->socket.text(true);
  stream_->socket.write(asio::buffer(text), error);
}

void PageClient::say_binary(const std::string& bytes) {
  beast::error_code error;
  stream_->socket.binary(true);
  stream_->socket.write(asio::buffer(bytes), error);
}

void PageClient::vanish() {
  beast::error_code ignored;
  stream_->socket.next_layer().close(ignored);
}

}  // namespace scanknit::test
