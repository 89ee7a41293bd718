#include "app/view_links.h"

#include <fmt/format.h>
#include <unistd.h>

#include "view/qr_code.h"

namespace scanknit {

void announce(const std::vector<std::string>& links, Console& console) {
  for (const std::string& link : links) console.plain(fmt::format("live view: {}", link));
  if (isatty(STDERR_FILENO) != 0 && !links.empty()) console.plain(qr_code(links.front()));
}

}  // namespace scanknit
