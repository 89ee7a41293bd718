#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "app/commands/mesh_command.h"
#include "app/config/config_print.h"
#include "app/config/outputs.h"
#include "app/exit_codes.h"
#include "app/job/local_workers.h"
#include "app/job/plan_estimate.h"
#include "app/terminal/scan_console.h"
#include "app/terminal/signals.h"
#include "scan/job/brick_job.h"

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

/// What went wrong with workers; empty if nothing.
std::string complaints(const std::vector<LocalWorkers::End>& ends) {
  std::string text;
  for (const LocalWorkers::End& end : ends) {
    if (end.signal) {
      text += fmt::format("worker {} was killed (signal {}); its bricks are free a minute later\n", end.worker,
                          *end.signal);
    } else if (end.code != kExitOk) {
      text += fmt::format("worker {} ended with exit code {}\n", end.worker, end.code);
    }
  }
  return text;
}

/// That of the first worker that failed: 1 if a signal ended it.
int code_of(const std::vector<LocalWorkers::End>& ends) {
  for (const LocalWorkers::End& end : ends) {
    if (end.signal) return exit_code_of(ErrorCode::kInternal);
    if (end.code != kExitOk) return end.code;
  }
  return kExitOk;
}

/// The workers' threads together are those of one process.
std::vector<std::string> worker_arguments(const WorkArguments& arguments, const CommonArguments& common) {
  const std::size_t all = common.threads > 0 ? common.threads : std::max(1u, std::thread::hardware_concurrency());
  const std::size_t each = std::max<std::size_t>(1, all / arguments.local);
  return {"work",      arguments.job.string(), "--quiet", "--workers", std::to_string(arguments.local),
          "--threads", std::to_string(each)};
}

int work_locally(const WorkArguments& arguments, const CommonArguments& common) {
  using namespace std::chrono_literals;
  const auto sources = config_of_job(arguments.job, common.config);
  if (!sources) return fail(sources.error(), common);
  const auto before = job_status(arguments.job, BrickCheck::kNames);
  if (!before) return fail(before.error(), common);
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const std::stop_token stop = stop_on_signal.token();
  auto workers = LocalWorkers::start(arguments.local, worker_arguments(arguments, common));
  if (!workers) return fail(workers.error(), common);
  Console console(common.verbosity);
  bool is_told = false;
  auto looked_at = std::chrono::steady_clock::now();
  while (workers->are_running()) {
    if (stop.stop_requested() && !std::exchange(is_told, true)) workers->stop();
    if (const std::string said = workers->wait(200ms); !said.empty()) console.plain(said);
    const auto now = std::chrono::steady_clock::now();
    if (now < looked_at + 1s) continue;
    looked_at = now;
    const auto status = job_status(arguments.job, BrickCheck::kNames);
    if (status) console.progress("fusing bricks", status->done, status->bricks);
  }
  if (stop.stop_requested()) return kExitInterrupted;
  if (const std::string text = complaints(workers->ends()); !text.empty()) console.plain(text);
  const auto after = job_status(arguments.job, BrickCheck::kNames);
  if (!after) return fail(after.error(), common);
  const std::size_t fused = after->done - std::min(before->done, after->done);
  const int code = code_of(workers->ends());
  const int printed = print_json_or(
      {{"fused", fused}, {"elsewhere", after->in_work}},
      fmt::format("Fused    {} bricks by {} workers; others were at {}\n", fused, arguments.local, after->in_work),
      common);
  return code != kExitOk ? code : printed;
}

}  // namespace

int plan_command(const PlanArguments& arguments, const CommonArguments& common) {
  const double process_s = processor_seconds();
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto loaded = load_config(with_run_defaults(common.config));
  if (!loaded) return fail(loaded.error(), common);
  PlanRequest request{job_of(arguments.recording, *loaded, {}), config_to_yaml(loaded->config), arguments.trajectory};
  AcquireConfig& frames = request.job.config.acquire;
  frames.from = arguments.from;
  frames.every = arguments.every;
  if (arguments.to) frames.to = *arguments.to;
  ScanConsole console(common.verbosity);
  const std::stop_token stop = stop_on_signal.token();
  const auto bricks = plan_job(request, arguments.job, console, stop);
  if (!bricks) return fail_or_interrupted(bricks.error(), stop, common);
  const std::string name = arguments.job.string();
  Json json = {{"job", name}, {"bricks", *bricks}};
  std::string text = fmt::format("Planned  {}: {} bricks\n", name, *bricks);
  if (arguments.estimates) {
    const double plan_s = processor_seconds();
    const auto estimate = estimate_planned(arguments.job, arguments.workers, plan_s, process_s, console, stop);
    if (!estimate) return fail_or_interrupted(estimate.error(), stop, common);
    json["estimate"] = estimate_json(*estimate);
    text += estimate_text(*estimate);
  }
  text += fmt::format("Next     scanknit work {}, then scanknit join {} -o OUT\n", name, name);
  return print_json_or(json, text, common);
}

int work_command(const WorkArguments& arguments, const CommonArguments& common) {
  if (arguments.local > 0) return work_locally(arguments, common);
  const StopOnSignal stop_on_signal;  // must come before any other thread
  const auto sources = config_of_job(arguments.job, common.config);
  if (!sources) return fail(sources.error(), common);
  const auto loaded = load_config(*sources);
  if (!loaded) return fail(loaded.error(), common);
  ScanConsole console(common.verbosity);
  const std::stop_token stop = stop_on_signal.token();
  const auto work = work_on_job(arguments.job, loaded->config, {arguments.brick, arguments.workers}, console, stop);
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
  const auto status = job_status(arguments.job, arguments.opens_bricks ? BrickCheck::kEnds : BrickCheck::kNames);
  if (!status) return fail(status.error(), common);
  Json json = {{"recording", status->recording},
               {"bricks", status->bricks},
               {"done", status->done},
               {"in_work", status->in_work},
               {"free", status->free}};
  if (arguments.opens_bricks) json["torn"] = status->torn;
  const std::string torn = arguments.opens_bricks ? fmt::format(" ({} of them torn)", status->torn) : "";
  return print_json_or(json,
                       fmt::format("Bricks   {} of {} done, {} in work, {} free{}\n", status->done, status->bricks,
                                   status->in_work, status->free, torn),
                       common);
}

}  // namespace scanknit
