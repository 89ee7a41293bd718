// LogLevel: how important a message is.
#pragma once

namespace scanknit {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

}  // namespace scanknit
