#include "scan/frames/frame_archive.h"

#include <variant>

namespace scanknit {

Result<void> for_each_frame(FrameSource& source, const std::stop_token& stop,
                            const std::function<Result<Reading>(Frame&)>& visit) {
  while (true) {
    FrameEvent event = source.next(stop);
    if (std::holds_alternative<EndOfStream>(event)) return {};
    if (const auto* error = std::get_if<Error>(&event)) return *error;
    auto* frame = std::get_if<Frame>(&event);
    if (frame == nullptr) continue;
    const auto reading = visit(*frame);
    if (!reading) return reading.error();
    if (*reading == Reading::kStop) return {};
  }
}

}  // namespace scanknit
