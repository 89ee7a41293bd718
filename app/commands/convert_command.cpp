#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "acquire/convert/sharpest_frames.h"
#include "acquire/frame_source.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/terminal/signals.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

int print_summary(const ConvertSummary& summary, const ConvertArguments& arguments, const CommonArguments& common) {
  const std::string output = arguments.output.string();
  if (common.is_json) {
    const Json json = {{"output", output},           {"frames", summary.frames},
                       {"dropped", summary.dropped}, {"with_colour", summary.colour},
                       {"with_pose", summary.poses}, {"warnings", summary.warnings}};
    return print_result(json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n", common);
  }
  if (common.verbosity == Verbosity::kQuiet) return kExitOk;
  return print_result(fmt::format("Written  {}: {} frames, {} with colour, {} with a pose; {} dropped\n", output,
                                  summary.frames, summary.colour, summary.poses, summary.dropped),
                      common);
}

}  // namespace

int convert_command(const ConvertArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  auto loaded = load_config(common.config);
  if (!loaded) return fail(loaded.error(), common);
  AcquireConfig& acquire = loaded->config.acquire;
  acquire.poses = PoseMode::kTrack;  // keeps poses, and frames without a pose
  auto source = open_recording(arguments.recording, acquire);
  if (!source) return fail(source.error(), common);
  Console console(common.verbosity);
  for (const std::string& warning : (*source)->info().warnings) console.warn(warning);
  std::size_t frames = (*source)->info().frames;
  if (arguments.frames > 0) {
    const auto choosing = [&](std::size_t done) { console.progress("choosing frames", done, frames); };
    const auto chosen = find_sharpest_frames(**source, arguments.frames, choosing, stop_on_signal.token());
    if (!chosen) return fail(chosen.error(), common);
    if (stop_on_signal.token().stop_requested()) return kExitInterrupted;
    source = open_recording(arguments.recording, acquire);
    if (!source) return fail(source.error(), common);
    frames = chosen->size();
    source = only_frames(*std::move(source), *chosen);
  }
  const auto progress = [&](std::size_t done) { console.progress("converting", done, frames); };
  const auto summary =
      convert_recording(**source, arguments.target, arguments.output, progress, stop_on_signal.token());
  if (!summary) return fail(summary.error(), common);
  for (const std::string& warning : summary->warnings) console.warn(warning);
  const int printed = print_summary(*summary, arguments, common);
  return summary->was_stopped ? kExitInterrupted : printed;
}

}  // namespace scanknit
