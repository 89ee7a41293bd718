#include "app/scan/second_look.h"

#include <fmt/format.h>

#include <utility>

#include "app/scan/reconstruction.h"

namespace scanknit {
namespace {

RunReport::Loops described(const LoopClosure& closure, const Reconstruction& scan) {
  RunReport::Loops loops{closure.is_corrected, closure.drift_m, 0, {}};
  for (const Loop& loop : closure.loops) {
    loops.pairs.push_back({scan.sequence_of(loop.from), scan.sequence_of(loop.to), loop.shift_m, loop.overlap,
                           loop.inlier_share, loop.refused});
  }
  return loops;
}

/// Where the tracker was pulled, the walk is tracked again without what it was pulled by; then loops are looked for
/// once more.
Result<LoopClosure> close_pulled(Reconstruction& scan, LoopClosure closure, const SecondLook& again) {
  for (const FrameRange& frames : closure.pulled) {
    auto source = again.open();
    if (!source) return source.error();
    if (const auto tracked = scan.track_again(frames, **source, again.stop); !tracked) return tracked.error();
  }
  return *scan.find_loops();
}

/// Returns how far the camera that moves most does.
Result<double> fuse_corrected(Reconstruction& scan, const LoopClosure& closure, const SecondLook& again,
                              Console& console) {
  auto source = again.open();
  if (!source) return source.error();
  return scan.fuse_at(closure.T_world_cameras, **source, again.stop, console);
}

/// True when the scan has changed.
Result<bool> close(Reconstruction& scan, LoopClosure closure, const SecondLook& again, Console& console,
                   RunReport& report) {
  if (!closure.has_come_back()) return false;
  if (!closure.pulled.empty() && again.open) {
    console.info("coming upon an old place bent the walk: that part is tracked again");
    auto straight = close_pulled(scan, std::move(closure), again);
    if (!straight) return straight.error();
    closure = *std::move(straight);
  }
  report.tracking->loops = described(closure, scan);
  if (!closure.is_corrected) return false;
  report.tracking->loops->is_corrected = false;  // not yet
  console.info(
      fmt::format("the walk came back {:.0f} mm beside where it had been: closing the loop", closure.drift_m * 1000));
  if (!again.open)
    return Error{ErrorCode::kInput,
                 "closing it takes the frames again, and no recording was made; leave out --no-recording"};
  const auto moved_m = fuse_corrected(scan, closure, again, console);
  if (!moved_m) return moved_m.error();
  report.tracking->loops->is_corrected = true;
  report.tracking->loops->largest_correction_m = *moved_m;
  return true;
}

}  // namespace

bool look_again(Reconstruction& scan, const SecondLook& again, Console& console, RunReport& report) {
  auto closure = scan.find_loops();
  if (!closure || !report.tracking) return false;
  report.tracking->loops = described(*closure, scan);
  const auto closed = close(scan, *std::move(closure), again, console, report);
  if (closed) return *closed;
  const std::string warning = again.stop.stop_requested()
                                  ? "closing the loop was interrupted: the mesh is as tracked"
                                  : "the loop could not be closed, the mesh is as tracked: " + closed.error().text();
  console.warn(warning);
  report.warnings.push_back(warning);
  return false;
}

}  // namespace scanknit
