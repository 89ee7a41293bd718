#include "app/cluster/cluster_scan.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <set>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "app/exit_codes.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr std::size_t kMaxFruitlessRounds = 3;
constexpr auto kLook = 1s;            // at the job's folder
constexpr std::size_t kAskSlurm = 5;  // every so many looks

/// What it needs of sbatch.
constexpr std::array<std::string_view, 13> kOwnOptions = {
    "--array",    "-a",       "--cpus-per-task", "-c",          "--dependency", "-d",    "--error",
    "--job-name", "--output", "--parsable",      "--test-only", "--wait",       "--wrap"};

const char* words_of(ClusterStep step) {
  switch (step) {
    case ClusterStep::kPlan: return "planning";
    case ClusterStep::kWork: return "fusing";
    case ClusterStep::kJoin: return "joining";
  }
  return "";
}

/// True once `stop` is requested.
bool wait(std::chrono::milliseconds time, const std::stop_token& stop) {
  for (; time > 0ms && !stop.stop_requested(); time -= 100ms) std::this_thread::sleep_for(100ms);
  return stop.stop_requested();
}

}  // namespace

ClusterScan::ClusterScan(const ClusterArguments& arguments, const CommonArguments& common)
    : arguments_(arguments), common_(common), folder_(arguments.job) {
  plan_ = {"plan", "-o", folder_.job().string(), "--quiet"};
  plan_.insert(plan_.end(), arguments.plan.begin(), arguments.plan.end());
}

bool ClusterScan::is_planned() const {
  std::error_code code;
  return fs::exists(config_file_of_job(folder_.job()), code);
}

Result<void> ClusterScan::check_arguments() const {
  for (const std::string& option : arguments_.slurm_options) {
    if (std::find(kOwnOptions.begin(), kOwnOptions.end(), option.substr(0, option.find('='))) == kOwnOptions.end())
      continue;
    return Error{ErrorCode::kUsage, "scanknit cluster decides that itself, and reads it", "--sbatch=" + option};
  }
  const std::string job = folder_.job().string();
  if (!is_planned() && arguments_.plan.empty()) {
    return Error{ErrorCode::kInput, "is no job: give the recording and the options of scanknit plan after --", job};
  }
  if (is_planned() && !arguments_.plan.empty() && !folder_.has_script(ClusterStep::kPlan, plan_)) {
    return Error{ErrorCode::kUsage,
                 "was planned with other arguments: leave out what follows --, or choose another folder", job};
  }
  return {};
}

Result<std::string> ClusterScan::submit_step(ClusterStep step, const std::vector<std::string>& arguments,
                                             std::size_t tasks, const std::string& after) const {
  auto batch = folder_.prepare(step, arguments);
  if (!batch) return batch.error();
  batch->tasks = tasks;
  batch->cpus = std::max<std::size_t>(1, common_.threads);
  batch->after = after;
  batch->options = arguments_.slurm_options;
  return submit_to_slurm(*batch);
}

Result<void> ClusterScan::submit(Console& console) {
  const std::string job = folder_.job().string();
  const std::string threads = std::to_string(std::max<std::size_t>(1, common_.threads));
  const auto lock = folder_.lock();
  if (!lock) return lock.error();
  const auto queue = slurm_queue(folder_.names());
  if (!queue) return queue.error();
  if (!queue->empty()) return {};
  if (const auto begun = folder_.set_cancelled(false); !begun) return begun.error();
  std::string after;
  std::string said;
  std::size_t missing = arguments_.array_size;
  if (!is_planned()) {
    const auto plan = submit_step(ClusterStep::kPlan, plan_, 0, "");
    if (!plan) return plan.error();
    after = "afterok:" + *plan;
    said += fmt::format("plan {}, ", *plan);
  } else {
    const auto status = job_status(folder_.job(), BrickCheck::kEnds);
    if (!status) return status.error();
    done_ = status->done;
    missing = std::min(missing, status->bricks - status->done);
  }
  if (missing > 0) {
    const auto work = submit_step(ClusterStep::kWork,
                                  {"work", job, "--quiet", "--workers", std::to_string(missing), "--threads", threads},
                                  missing, after);
    if (!work) return work.error();
    after = "afterany:" + *work;
    said += fmt::format("{} workers {}, ", missing, *work);
  }
  std::vector<std::string> join = {"join", job, "-o", fs::absolute(arguments_.output).string(), "--threads", threads};
  if (common_.is_json) join.push_back("--json");
  const auto joined = submit_step(ClusterStep::kJoin, join, 0, after);
  if (!joined) return joined.error();
  console.info(fmt::format("submitted to Slurm: {}join {}", said, *joined));
  return {};
}

void ClusterScan::show(const std::vector<SlurmTask>& queue, Console& console) {
  const auto workers = std::count_if(queue.begin(), queue.end(), [&](const SlurmTask& task) {
    return task.is_running && task.name == folder_.name_of(ClusterStep::kWork);
  });
  if (const auto status = is_planned() ? job_status(folder_.job(), BrickCheck::kNames) : Error{};
      status && std::exchange(shown_, status->done) != status->done) {
    console.progress(fmt::format("fusing bricks, {} workers,", workers), status->done, status->bricks);
  }
  const bool all_wait = std::none_of(queue.begin(), queue.end(), [](const SlurmTask& task) { return task.is_running; });
  if (!all_wait) is_waiting_told_ = false;
  const auto first =
      std::find_if(queue.begin(), queue.end(), [](const SlurmTask& task) { return task.reason != "Dependency"; });
  if (all_wait && first != queue.end() && !std::exchange(is_waiting_told_, true)) {
    console.info(fmt::format("waiting for Slurm ({})", first->reason));
  }
}

Error ClusterScan::failure_of(ClusterStep step) const {
  const auto ends = folder_.ends_of(step);
  const auto worst = std::max_element(ends.begin(), ends.end());
  const std::string said = folder_.errors_of(step);
  if (worst == ends.end() || *worst == kExitOk) {
    return {ErrorCode::kInternal,
            fmt::format("{} was ended by Slurm (time, memory, a lost node?): see its logs; the same command goes on",
                        words_of(step)),
            folder_.job().string() + ".slurm"};
  }
  return {error_code_of(*worst),
          fmt::format("{} failed with exit code {}{}{}", words_of(step), *worst, said.empty() ? "" : ":\n", said),
          folder_.job().string()};
}

Result<ClusterScan::Next> ClusterScan::after_queue() {
  const auto joins = folder_.ends_of(ClusterStep::kJoin);
  if (std::find(joins.begin(), joins.end(), kExitOk) != joins.end()) return Next::kEnd;
  const auto has_failed = [&](ClusterStep step) {
    const auto ends = folder_.ends_of(step);
    return std::any_of(ends.begin(), ends.end(), [](int code) { return code != kExitOk && code != kExitInterrupted; });
  };
  std::size_t done = done_, missing = 1;
  if (!is_planned()) {
    if (has_failed(ClusterStep::kPlan)) return failure_of(ClusterStep::kPlan);
  } else {
    const auto status = job_status(folder_.job(), BrickCheck::kEnds);
    if (!status) return status.error();
    done = status->done;
    missing = status->bricks - done;
    if (missing > 0 && status->in_work > 0) return Next::kWait;  // a worker that Slurm knows not, or a dead one's claim
    const ClusterStep last = missing > 0 ? ClusterStep::kWork : ClusterStep::kJoin;
    if (done <= done_ && has_failed(last)) return failure_of(last);  // not for want of another worker's bricks
  }
  fruitless_rounds_ = done > done_ ? 0 : fruitless_rounds_ + 1;
  if (fruitless_rounds_ < kMaxFruitlessRounds) return Next::kSubmit;
  return failure_of(!is_planned() ? ClusterStep::kPlan : missing > 0 ? ClusterStep::kWork : ClusterStep::kJoin);
}

Result<std::string> ClusterScan::run(Console& console, const std::stop_token& stop) {
  const auto stopped = [&] {
    return Error{ErrorCode::kInternal,
                 "interrupted: Slurm goes on without this process. The same command follows it again, --cancel ends it",
                 folder_.job().string()};
  };
  if (const auto checked = check_arguments(); !checked) return checked.error();
  auto queue = slurm_queue(folder_.names());
  if (!queue) return queue.error();
  bool is_submitted = !queue->empty();
  for (std::size_t looks = 1; true; ++looks) {
    const bool is_over = queue && queue->empty();
    if (is_over && is_submitted && folder_.is_cancelled()) {
      was_cancelled_ = true;
      return Error{ErrorCode::kInternal, "was cancelled; bricks that are done stay", folder_.job().string()};
    }
    const auto next = !is_over ? Next::kWait : is_submitted ? after_queue() : Next::kSubmit;
    if (!next) return next.error();
    if (*next == Next::kEnd) return folder_.printed_by(ClusterStep::kJoin);
    if (*next == Next::kSubmit) {
      if (const auto submitted = submit(console); !submitted) return submitted.error();
      is_submitted = true;
    }
    if (wait(kLook, stop)) return stopped();
    if (is_over || looks % kAskSlurm == 0) queue = slurm_queue(folder_.names());  // no answer: perhaps the next time
    if (queue) show(*queue, console);
  }
}

Result<std::size_t> ClusterScan::cancel() const {
  const auto queue = slurm_queue(folder_.names());
  if (!queue) return queue.error();
  std::set<std::string> ids;
  for (const SlurmTask& task : *queue) ids.insert(task.id);
  if (ids.empty() && !is_planned() && !folder_.has_script(ClusterStep::kJoin)) {
    return Error{ErrorCode::kInput, "is no job, and was given to no cluster", folder_.job().string()};
  }
  if (ids.empty()) return std::size_t{0};
  if (const auto noted = folder_.set_cancelled(true); !noted) return noted.error();
  if (const auto cancelled = cancel_in_slurm({ids.begin(), ids.end()}); !cancelled) return cancelled.error();
  return ids.size();
}

}  // namespace scanknit
