// The levels of messages.
#pragma once

namespace scanknit {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

}  // namespace scanknit
