// Console: what a person sees on stderr while the program works. Results go to stdout, never through here.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "core/log.h"

namespace spdlog {
class logger;
}

namespace scanknit {

enum class Verbosity { kQuiet, kNormal, kVerbose };

/// One thread. Quiet: errors only. Colours on a terminal unless NO_COLOR is set.
class Console {
 public:
  explicit Console(Verbosity verbosity);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void say(LogLevel level, std::string_view message);
  void info(std::string_view message) { say(LogLevel::kInfo, message); }
  void warn(std::string_view message) { say(LogLevel::kWarning, message); }
  void error(std::string_view message) { say(LogLevel::kError, message); }

  /// One or more lines as they are, at every verbosity.
  void plain(std::string_view lines);

  /// "fusing 12/50": on a terminal one line, redrawn ten times a second at most; else a line every tenth of the way.
  void progress(std::string_view what, std::size_t done, std::size_t total);

 private:
  void clear_line();

  std::shared_ptr<spdlog::logger> logger_;
  bool is_quiet_ = false;
  bool is_terminal_ = false;
  bool has_line_ = false;
  std::chrono::steady_clock::time_point drawn_at_{};
  std::size_t tenths_shown_ = 0;
};

}  // namespace scanknit
