#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "acquire/frame_source.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/terminal/signals.h"

namespace scanknit {
namespace {

int print_summary(const ConvertSummary& summary, const ConvertArguments& arguments, const CommonArguments& common) {
  const std::string output = arguments.output.string();
  if (common.is_json) {
    using Json = nlohmann::ordered_json;
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
  const auto source = open_recording(arguments.recording, acquire);
  if (!source) return fail(source.error(), common);
  Console console(common.verbosity);
  for (const std::string& warning : (*source)->info().warnings) console.warn(warning);
  const std::size_t frames = (*source)->info().frames;
  const auto progress = [&](std::size_t done) { console.progress("converting", done, frames); };
  const auto summary =
      convert_recording(**source, arguments.target, arguments.output, progress, stop_on_signal.token());
  if (!summary) return fail(summary.error(), common);
  for (const std::string& warning : summary->warnings) console.warn(warning);
  const int printed = print_summary(*summary, arguments, common);
  return summary->was_stopped ? kExitInterrupted : printed;
}

}  // namespace scanknit
