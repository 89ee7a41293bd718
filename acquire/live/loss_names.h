// The names of LossCounters in reports and messages; docs/devices.md explains them.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "core/frame.h"

namespace scanknit {

[[nodiscard]] inline std::map<std::string, std::uint64_t> losses_by_name(const LossCounters& losses) {
  return {{"device", losses.device},
          {"transport", losses.transport},
          {"overflow", losses.overflow},
          {"queue", losses.queue},
          {"writer", losses.writer}};
}

}  // namespace scanknit
