// record: writes the raw pictures of a scanner to a file.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "acquire/live/loss_names.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/terminal/scan_console.h"
#include "app/terminal/signals.h"
#include "core/files/atomic_file.h"
#include "scan/live/live_scanner.h"
#include "scan/scan_session.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

struct Recorded {
  std::size_t frames = 0;  ///< depth pictures received
  RecorderSummary file;
  LossCounters losses;
  std::optional<Error> failure;  ///< of the scanner or the file; everything before it is kept
};

Result<Recorded> record(const RecordArguments& arguments, const ScanConfig& config, std::stop_token stop,
                        ScanSession& session) {
  if (auto writable = check_writable(arguments.output); !writable) return writable.error();
  auto scanner = open_scanner(arguments.scanner, config, Calibration::kOptional, stop, session);
  if (!scanner) return scanner.error();
  if (arguments.wants_ros2 && config.acquire.geometry == Geometry::kStereo) {
    return Error{ErrorCode::kUsage, "a bag of ROS 2 holds depth: leave out --ros2 to keep infrared pairs"};
  }
  RecorderConfig recorder_config;
  if (arguments.wants_ros2) recorder_config.ros2_streams = scanner->streams;
  auto recorder = Recorder::create(arguments.output, scanner->calibration, recorder_config);
  if (!recorder) return recorder.error();
  LiveOptions options = live_options(arguments.scanner, PoseMode::kTrack, session);
  options.matches_pairs = false;
  auto source = LiveSource::start(*std::move(scanner), std::move(options), recorder->get());
  if (!source) return source.error();
  session.info("recording; Ctrl-C ends it");

  Recorded recorded;
  while (!(*recorder)->failure()) {
    const FrameEvent event = (*source)->next(stop);
    if (std::holds_alternative<EndOfStream>(event) || std::holds_alternative<Error>(event)) break;
    session.progress("recording", ++recorded.frames, arguments.scanner.frames.value_or(0));
  }
  recorded.failure = (*source)->failure();
  recorded.losses = (*source)->losses();
  recorded.losses.queue = 0;  // pictures that the queue dropped are in the file
  source->reset();            // stops the scanner
  const auto kept = (*recorder)->finish();
  if (!kept) return kept.error();
  recorded.file = *kept;
  recorded.losses.writer += (*recorder)->lost();
  return recorded;
}

int print_summary(const Recorded& recorded, const RecordArguments& arguments, const CommonArguments& common) {
  const std::string output = arguments.output.string();
  if (common.is_json) {
    const Json json = {{"output", output},
                       {"depth_pictures", recorded.frames},
                       {"pictures", recorded.file.frames},
                       {"bytes", recorded.file.bytes},
                       {"losses", losses_by_name(recorded.losses)}};
    return print_result(json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n", common);
  }
  if (common.verbosity == Verbosity::kQuiet) return kExitOk;
  return print_result(fmt::format("Written  {}: {} pictures, {:.1f} MB\n", output, recorded.file.frames,
                                  static_cast<double>(recorded.file.bytes) / 1e6),
                      common);
}

}  // namespace

int record_command(const RecordArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto loaded = load_config(with_run_defaults(common.config));
  if (!loaded) return fail(loaded.error(), common);
  ScanConsole console(common.verbosity);
  ScanSession session(console, {});
  const auto recorded = record(arguments, loaded->config, stop_on_signal.token(), session);
  if (!recorded) return fail(recorded.error(), common);
  warn_of_losses(recorded->losses, session);
  if (recorded->file.frames == 0) {  // there is no file
    return fail(recorded->failure.value_or(Error{ErrorCode::kDevice, "no picture came: nothing was recorded"}), common);
  }
  const int printed = print_summary(*recorded, arguments, common);
  if (recorded->failure) return fail(*recorded->failure, common);
  return printed;
}

}  // namespace scanknit
