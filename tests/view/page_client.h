// A client of the live view, as a browser would be one, that waits for seconds at most.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace scanknit::test {

struct HttpAnswer {
  int status = 0;                             ///< 0: no answer
  std::map<std::string, std::string> fields;  ///< by lower-case name
  std::string body;
};

/// One request with the fields given; Host is 127.0.0.1 unless it is among them.
HttpAnswer http_request(std::uint16_t port, const std::string& method, const std::string& target,
                        const std::map<std::string, std::string>& fields = {}, const std::string& body = {});

/// Sends the bytes, then closes.
void send_bytes(std::uint16_t port, const std::string& bytes);

/// Sends the bytes and gives all that comes back until the other side ends it.
std::string answer_to(std::uint16_t port, const std::string& bytes);

/// Somebody who connects and says nothing.
class SilentConnection {
 public:
  explicit SilentConnection(std::uint16_t port);
  ~SilentConnection();

 private:
  struct Socket;
  std::unique_ptr<Socket> socket_;
};

struct PageMessage {
  bool is_text = false;
  std::string bytes;
};

class PageClient {
 public:
  /// Nothing when the server will not have it; `status` then says why.
  static std::unique_ptr<PageClient> connect(std::uint16_t port, const std::string& target = "/api/v1/live",
                                             std::optional<std::string> origin = std::nullopt, int* status = nullptr);
  ~PageClient();

  /// The next message; nothing after a minute without one, or when the connection has ended.
  std::optional<PageMessage> next();
  /// The next text of that type; binary messages on the way to it are kept in `binaries`, without credit.
  nlohmann::json next_of(const std::string& type);
  /// Binary messages until none comes for a while; gives credit for each if wanted.
  std::vector<std::string> next_binaries(bool gives_credit);
  void say(const std::string& text);
  void say_binary(const std::string& bytes);
  /// Goes without a word.
  void vanish();

  std::vector<std::string> binaries;

 private:
  struct Stream;
  std::optional<PageMessage> next_within(std::chrono::milliseconds patience);
  explicit PageClient(std::unique_ptr<Stream> stream);
  std::unique_ptr<Stream> stream_;
};

}  // namespace scanknit::test
