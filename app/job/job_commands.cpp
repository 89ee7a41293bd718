#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <system_error>

#include "app/commands/mesh_command.h"
#include "app/config/config_print.h"
#include "app/config/outputs.h"
#include "app/exit_codes.h"
#include "app/terminal/scan_console.h"
#include "app/terminal/signals.h"
#include "scan/bricks/brick_job.h"

namespace scanknit {
namespace {

using Json = nlohmann::ordered_json;

/// Errors (kUsage): the command line has a configuration, and the job its own.
Result<ConfigSources> config_of_job(const std::filesystem::path& job, const ConfigSources& given) {
  if (!given.presets.empty() || given.file || !given.assignments.empty()) {
    return Error{ErrorCode::kUsage, "the job has its configuration: give --config, --preset and --set to scanknit plan",
                 job.string()};
  }
  std::error_code code;
  if (!std::filesystem::exists(config_file_of_job(job), code)) {
    return Error{ErrorCode::kInput, "is no job; scanknit plan RECORDING -o JOB makes one", job.string()};
  }
  ConfigSources sources;
  sources.file = config_file_of_job(job);
  return sources;
}

int print_json_or(const Json& json, const std::string& text, const CommonArguments& common) {
  constexpr auto kReplace = Json::error_handler_t::replace;  // paths need not be UTF-8
  if (common.is_json) return print_result(json.dump(2, ' ', false, kReplace) + "\n", common);
  return common.verbosity == Verbosity::kQuiet ? kExitOk : print_result(text, common);
}

int fail_or_interrupted(const Error& error, const std::stop_token& stop, const CommonArguments& common) {
  const int code = fail(error, common);
  return stop.stop_requested() ? kExitInterrupted : code;
}

}  // namespace

int plan_command(const PlanArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto loaded = load_config(with_run_defaults(common.config));
  if (!loaded) return fail(loaded.error(), common);
  ScanJob job = job_of(arguments.recording, *loaded, {});
  job.config.acquire.from = arguments.from;
  job.config.acquire.every = arguments.every;
  if (arguments.to) job.config.acquire.to = *arguments.to;
  ScanConsole console(common.verbosity);
  const std::stop_token stop = stop_on_signal.token();
  const auto bricks = plan_job(job, config_to_yaml(loaded->config), arguments.job, console, stop);
  if (!bricks) return fail_or_interrupted(bricks.error(), stop, common);
  const std::string name = arguments.job.string();
  return print_json_or({{"job", name}, {"bricks", *bricks}},
                       fmt::format("Planned  {}: {} bricks\nNext     scanknit work {}, then scanknit join {} -o OUT\n",
                                   name, *bricks, name, name),
                       common);
}

int work_command(const WorkArguments& arguments, const CommonArguments& common) {
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto sources = config_of_job(arguments.job, common.config);
  if (!sources) return fail(sources.error(), common);
  const auto loaded = load_config(*sources);
  if (!loaded) return fail(loaded.error(), common);
  ScanConsole console(common.verbosity);
  const std::stop_token stop = stop_on_signal.token();
  const auto work = work_on_job(arguments.job, loaded->config, arguments.brick, console, stop);
  if (!work) return fail_or_interrupted(work.error(), stop, common);
  const int code = print_json_or(
      {{"fused", work->fused}, {"elsewhere", work->elsewhere}},
      fmt::format("Fused    {} bricks; other workers were at {}\n", work->fused, work->elsewhere), common);
  return work->is_stopped && code == kExitOk ? kExitInterrupted : code;
}

int join_command(const JoinArguments& arguments, const CommonArguments& common) {
  const auto sources = config_of_job(arguments.job, common.config);
  if (!sources) return fail(sources.error(), common);
  MeshCommand command{.input = arguments.job, .config = *sources, .outputs = arguments.outputs};
  command.scan = [&](const ScanJob& job, const LoadedConfig&, ScanObserver& observer, const std::stop_token& stop) {
    return join_job(arguments.job, job, observer, stop);
  };
  return run_mesh_command(command, common);
}

int status_command(const StatusArguments& arguments, const CommonArguments& common) {
  const auto status = job_status(arguments.job);
  if (!status) return fail(status.error(), common);
  return print_json_or({{"recording", status->recording},
                        {"bricks", status->bricks},
                        {"done", status->done},
                        {"in_work", status->in_work},
                        {"free", status->free},
                        {"torn", status->torn}},
                       fmt::format("Bricks   {} of {} done, {} in work, {} free ({} of them torn)\n", status->done,
                                   status->bricks, status->in_work, status->free, status->torn),
                       common);
}

}  // namespace scanknit
