// Log: where rooms say what a person may want to know. The application plugs a sink in.
#pragma once

#include <string_view>

namespace scanknit {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

class Log {
 public:
  virtual ~Log() = default;
  virtual void write(LogLevel level, std::string_view message) = 0;

  void info(std::string_view message) { write(LogLevel::kInfo, message); }
  void warn(std::string_view message) { write(LogLevel::kWarning, message); }
};

}  // namespace scanknit
