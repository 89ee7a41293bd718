#include "app/terminal/view_links.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "view/qr_code.h"

namespace scanknit {
namespace {

/// The width of the terminal on stderr; 0: stderr is no terminal.
int terminal_columns() {
  constexpr int kUsual = 80;  // if the terminal does not report its width
  if (isatty(STDERR_FILENO) == 0) return 0;
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

}  // namespace

void announce(const std::vector<std::string>& links, Console& console) {
  for (const std::string& link : links) console.plain(fmt::format("live view: {}", link));
  const std::string code = links.empty() ? "" : qr_code(links.front(), terminal_columns());
  if (!code.empty()) console.plain(code);
}

}  // namespace scanknit
