#include "view/view_routes.h"

#include <algorithm>

#include "view/page_files.h"
#include "view/view_access.h"

namespace scanknit {
namespace {

ViewRoute refused(unsigned status, const char* why) {
  ViewRoute route;
  route.status = status;
  route.why = why;
  return route;
}

ViewRoute found(ViewPlace place, std::string_view name = {}) {
  ViewRoute route;
  route.place = place;
  route.name = name;
  return route;
}

ViewRoute place_of(std::string_view path) {
  const auto& pages = page_files();
  const bool is_page = std::any_of(pages.begin(), pages.end(), [&](const PageFile& file) { return file.path == path; });
  if (is_page) return found(ViewPlace::kPage, path);
  if (path == "/api/v1/live") return found(ViewPlace::kLive);
  if (path == "/api/v1/state") return found(ViewPlace::kState);
  constexpr std::string_view kFiles = "/files/";
  if (path.substr(0, kFiles.size()) == kFiles)
    return found(ViewPlace::kFile, percent_decoded(path.substr(kFiles.size())));
  return refused(404, "There is no such page.");
}

}  // namespace

ViewRoute route_of(const ViewRequest& request, std::string_view token, std::string_view cookie_name) {
  if (!request.is_get) return refused(405, "Only GET is answered.");
  if (request.hosts != 1) return refused(400, "A request names one Host.");
  if (!is_own_host(request.host)) return refused(403, "This address does not name the computer that scans.");

  const std::size_t mark = request.target.find('?');
  const std::string_view path = request.target.substr(0, mark);
  const std::string_view query = mark == std::string_view::npos ? std::string_view() : request.target.substr(mark + 1);
  const bool is_trusted = token.empty() || is_same_secret(value_of(query, "token", "&"), token) ||
                          is_same_secret(value_of(request.cookie, cookie_name, "; "), token);
  ViewRoute route = place_of(path);
  const bool is_open_to_all = route.place == ViewPlace::kPage && path != "/";
  if (!is_trusted && !is_open_to_all)
    return refused(401, "The token is missing or wrong: open the link that the scan printed.");
  route.is_trusted = is_trusted;
  return route;
}

}  // namespace scanknit
