#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/cluster/cluster_scan.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/terminal/signals.h"

namespace scanknit {

int cluster_command(const ClusterArguments& arguments, const CommonArguments& common) {
  if (const ConfigSources& config = common.config;
      !config.presets.empty() || config.file || !config.assignments.empty()) {
    return fail(
        {ErrorCode::kUsage, "the job has its configuration: give --config, --preset and --set after --, for plan"},
        common);
  }
  if (arguments.is_cancelling) {
    const auto cancelled = ClusterScan(arguments, common).cancel();
    if (!cancelled) return fail(cancelled.error(), common);
    const std::string text = common.is_json
                                 ? nlohmann::json{{"cancelled", *cancelled}}.dump(2) + "\n"
                                 : fmt::format("Cancelled {} batches; bricks that are done stay\n", *cancelled);
    return print_result(text, common);
  }
  if (arguments.output.empty()) {
    return fail({ErrorCode::kUsage, "no output: give -o OUT, the folder or mesh file that join writes"}, common);
  }
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const std::stop_token stop = stop_on_signal.token();
  Console console(common.verbosity);
  ClusterScan scan(arguments, common);
  const auto joined = scan.run(console, stop);
  if (joined && common.verbosity == Verbosity::kQuiet && !common.is_json) return kExitOk;
  if (joined) return print_result(*joined, common);
  const int code = fail(joined.error(), common);
  return stop.stop_requested() || scan.was_cancelled() ? kExitInterrupted : code;
}

}  // namespace scanknit
