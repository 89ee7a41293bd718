#include "app/terminal/console.h"

#include <fmt/format.h>
#include <spdlog/logger.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "scan/scan_observer.h"

namespace scanknit {
namespace {

spdlog::sink_ptr stderr_sink() {
  const char* no_colour = std::getenv("NO_COLOR");  // https://no-color.org: any non-empty value
  if (no_colour != nullptr && *no_colour != '\0') return std::make_shared<spdlog::sinks::stderr_sink_mt>();
  return std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
}

spdlog::level::level_enum level_of(Verbosity verbosity) {
  switch (verbosity) {
    case Verbosity::kQuiet: return spdlog::level::err;
    case Verbosity::kNormal: return spdlog::level::info;
    case Verbosity::kVerbose: return spdlog::level::debug;
  }
  return spdlog::level::info;
}

spdlog::level::level_enum level_of(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug: return spdlog::level::debug;
    case LogLevel::kInfo: return spdlog::level::info;
    case LogLevel::kWarning: return spdlog::level::warn;
    case LogLevel::kError: return spdlog::level::err;
  }
  return spdlog::level::info;
}

/// Writes to stderr and ignores errors. fmt::print would throw when the terminal has closed, and end the scan.
void print(const std::string& text) {
  (void)std::fwrite(text.data(), 1, text.size(), stderr);
  (void)std::fflush(stderr);
}

}  // namespace

Console::Console(Verbosity verbosity)
    : logger_(std::make_shared<spdlog::logger>("scanknit", stderr_sink())),
      is_quiet_(verbosity == Verbosity::kQuiet),
      is_terminal_(::isatty(STDERR_FILENO) == 1) {
  logger_->set_level(level_of(verbosity));
  logger_->set_pattern("%^%l%$: %v");
  logger_->set_error_handler([](const std::string&) {});  // ignores errors, like print()
}

Console::~Console() {
  clear_line();
}

void Console::say(LogLevel level, std::string_view message) {
  clear_line();
  logger_->log(level_of(level), "{}", message);
}

void Console::info(std::string_view message) {
  say(LogLevel::kInfo, message);
}

void Console::warn(std::string_view message) {
  say(LogLevel::kWarning, message);
}

void Console::error(std::string_view message) {
  say(LogLevel::kError, message);
}

void Console::plain(std::string_view lines) {
  clear_line();
  print(fmt::format("{}\n", lines));
}

void Console::progress(std::string_view what, std::size_t done, std::size_t total) {
  if (is_quiet_ || total == 0) return;
  if (!is_terminal_) {
    const std::size_t tenths = done * 10 / total;
    if (tenths > tenths_shown_ || done == total) info(fmt::format("{} {}/{}", what, done, total));
    tenths_shown_ = done == total ? 0 : tenths;
    return;
  }
  constexpr auto kRedrawEvery = std::chrono::milliseconds(100);
  const auto now = std::chrono::steady_clock::now();
  if (done < total && now - drawn_at_ < kRedrawEvery) return;
  drawn_at_ = now;
  print(fmt::format("\r\033[K{} {}/{}", what, done, total));
  has_line_ = true;
  if (done == total) clear_line();
}

void Console::clear_line() {
  if (!has_line_) return;
  print("\r\033[K");
  has_line_ = false;
}

}  // namespace scanknit
