// SecondLook: the end of a scan, when all of it is known: loops are closed and the frames are fused again.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>

#include "acquire/frame_source.h"
#include "app/terminal/console.h"
#include "core/result.h"
#include "export/report/report.h"

namespace scanknit {

class Reconstruction;

/// How the frames can be read once more.
struct SecondLook {
  /// Errors: why they cannot.
  std::function<Result<std::unique_ptr<FrameSource>>()> open;
  std::stop_token stop;  ///< ends the second look, and leaves all as it was
};

/// Looks for loops, tells of them in the report, and fuses the frames of `scan` again where there was drift. True: the
/// scan has changed and everything is to be written anew. False: it is as it was, or could not be fused again (which is
/// warned of) and must not be used any more; what was written before stands.
[[nodiscard]] bool look_again(Reconstruction& scan, const SecondLook& again, Console& console, RunReport& report);

}  // namespace scanknit
