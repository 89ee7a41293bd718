// ViewRoutes: what a request to the live view asks for, and whether it may, by its words alone.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace scanknit {

/// What counts of an HTTP request.
struct ViewRequest {
  bool is_get = false;
  std::size_t hosts = 0;  ///< Host headers that it has
  std::string_view target, host, cookie;
};

enum class ViewPlace {
  kRefused,
  kPage,   ///< a file of the page
  kLive,   ///< the WebSocket
  kState,  ///< the newest state
  kFile,   ///< a file of the scan; it may not be there
};

struct ViewRoute {
  ViewPlace place = ViewPlace::kRefused;
  unsigned status = 200;    ///< HTTP's, of kRefused
  const char* why = "";     ///< likewise, for a person
  std::string name = {};    ///< of kPage the path, of kFile the file's name
  bool is_trusted = false;  ///< whoever asks may look on; the page's own script and style are for all
};

/// `token`: empty when none is asked for; it stands in the target, or in the cookie of that name.
[[nodiscard]] ViewRoute route_of(const ViewRequest& request, std::string_view token, std::string_view cookie_name);

}  // namespace scanknit
