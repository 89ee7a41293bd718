// Console: messages for the user on stderr while the program works. Results go to stdout, not through this class.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace spdlog {
class logger;
}

namespace scanknit {

enum class LogLevel;
enum class Verbosity { kQuiet, kNormal, kVerbose };

/// For one thread. Quiet: prints errors only. Uses colours on a terminal unless NO_COLOR is set.
class Console {
 public:
  explicit Console(Verbosity verbosity);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void say(LogLevel level, std::string_view message);
  void info(std::string_view message);
  void warn(std::string_view message);
  void error(std::string_view message);

  /// Prints lines unchanged, at every verbosity.
  void plain(std::string_view lines);

  /// Prints "fusing 12/50": on a terminal one line, redrawn at most ten times a second; else one line for each tenth.
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
