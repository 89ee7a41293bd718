// Routes: decides from a request's headers alone what it asks for, and whether it is allowed.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace scanknit {

/// The parts of an HTTP request that matter.
struct ViewRequest {
  bool is_get = false;
  std::size_t hosts = 0;  ///< number of Host headers
  std::string_view target, host, cookie;
};

enum class ViewPlace {
  kRefused,
  kPage,   ///< a file of the page
  kLive,   ///< the WebSocket
  kState,  ///< the newest state
  kFile,   ///< a file of the scan; it may not exist
};

struct ViewRoute {
  ViewPlace place = ViewPlace::kRefused;
  unsigned status = 200;    ///< HTTP status for kRefused
  const char* why = "";     ///< the reason for kRefused, as text
  std::string name = {};    ///< for kPage the path, for kFile the file's name
  bool is_trusted = false;  ///< the client may see the scan; the page's script and style are public
};

/// `token`: empty when none is required. The request has it in the target or in the cookie of that name.
[[nodiscard]] ViewRoute route_of(const ViewRequest& request, std::string_view token, std::string_view cookie_name);

}  // namespace scanknit
