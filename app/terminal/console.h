// Console: what a person sees on stderr while the program works. Results go to stdout, never through here.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "core/log.h"

namespace spdlog {
class logger;
}

namespace scanknit {

enum class Verbosity { kQuiet, kNormal, kVerbose };

/// One thread. Quiet: errors only. Colours on a terminal unless NO_COLOR is set.
class Console final : public Log {
 public:
  explicit Console(Verbosity verbosity);
  ~Console() override;

  void write(LogLevel level, std::string_view message) override;
  void error(std::string_view message) { write(LogLevel::kError, message); }
  void debug(std::string_view message) { write(LogLevel::kDebug, message); }

  /// One or more lines as they are, at every verbosity.
  void plain(std::string_view lines);

  /// "fusing 12/50": on a terminal one line, redrawn ten times a second at most; else a line every tenth of the way.
  void progress(std::string_view what, std::size_t done, std::size_t total);

  /// Told of all progress, at every verbosity; empty: nobody is.
  void watch_progress(std::function<void(std::string_view what, std::size_t done, std::size_t total)> watcher) {
    watcher_ = std::move(watcher);
  }

 private:
  void clear_line();

  std::shared_ptr<spdlog::logger> logger_;
  bool is_quiet_ = false;
  bool is_terminal_ = false;
  bool has_line_ = false;
  std::chrono::steady_clock::time_point drawn_at_{};
  std::size_t tenths_shown_ = 0;
  std::function<void(std::string_view, std::size_t, std::size_t)> watcher_;
};

}  // namespace scanknit
