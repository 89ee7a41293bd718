#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "acquire/record/repair_recording.h"
#include "app/commands.h"
#include "app/exit_codes.h"
#include "app/terminal/signals.h"

namespace scanknit {

int repair_command(const RepairArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto loaded = load_config(common.config);
  if (!loaded) return fail(loaded.error(), common);
  const std::filesystem::path output = arguments.output.empty() ? arguments.file : arguments.output;
  const auto summary = repair_recording(arguments.file, output, loaded->config.acquire.limits, stop_on_signal.token());
  if (!summary) {
    const int code = fail(summary.error(), common);
    return stop_on_signal.token().stop_requested() ? kExitInterrupted : code;
  }
  if (common.is_json) {
    using Json = nlohmann::ordered_json;
    const Json json = {{"file", output.string()},
                       {"messages", summary->messages},
                       {"lost_messages", summary->lost},
                       {"fault", summary->fault ? Json(*summary->fault) : Json(nullptr)}};
    return print_result(json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n", common);
  }
  if (common.verbosity == Verbosity::kQuiet) return kExitOk;
  return print_result(fmt::format("Written  {}: {} messages kept, {} lost\nFault    {}\n", output.string(),
                                  summary->messages, summary->lost, summary->fault.value_or("none: it was whole")),
                      common);
}

}  // namespace scanknit
