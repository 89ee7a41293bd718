#include "app/cluster/slurm.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "app/cluster/run_program.h"

namespace scanknit {
namespace {

/// What the program printed. Errors: kUsage.
Result<std::string> ask(const std::vector<std::string>& words) {
  auto end = run_program(words);
  if (!end) {
    return Error{ErrorCode::kUsage,
                 "Slurm is not on this machine: install slurm-client, or log in where jobs are submitted", words[0]};
  }
  if (end->code != 0) {
    std::string said = end->err.empty() ? fmt::format("exit code {}", end->code) : end->err;
    while (said.ends_with('\n')) said.pop_back();
    return Error{ErrorCode::kUsage, "Slurm says: " + said, words[0]};
  }
  return std::move(end->out);
}

}  // namespace

Result<std::string> submit_to_slurm(const SlurmBatch& batch) {
  std::vector<std::string> words = {"sbatch",
                                    "--parsable",
                                    "--requeue",
                                    "--open-mode=append",
                                    "--kill-on-invalid-dep=yes",
                                    "--job-name=" + batch.name,
                                    "--output=" + batch.out.string(),
                                    "--error=" + batch.err.string(),
                                    fmt::format("--cpus-per-task={}", batch.cpus)};
  if (batch.tasks > 0) words.push_back(fmt::format("--array=0-{}", batch.tasks - 1));
  if (!batch.after.empty()) words.push_back("--dependency=" + batch.after);
  words.insert(words.end(), batch.options.begin(), batch.options.end());
  words.push_back(batch.script.string());
  const auto printed = ask(words);
  if (!printed) return printed.error();
  return printed->substr(0, printed->find_first_of(";\n"));  // "12", or "12;cluster"
}

Result<std::vector<SlurmTask>> slurm_queue(const std::vector<std::string>& names) {
  const auto printed = ask({"squeue", "--me", "--array", "--noheader", fmt::format("--name={}", fmt::join(names, ",")),
                            "--format=%F|%j|%T|%r"});
  if (!printed) return printed.error();
  std::vector<SlurmTask> tasks;
  std::istringstream lines(*printed);
  SlurmTask task;
  std::string state;
  while (std::getline(lines, task.id, '|') && std::getline(lines, task.name, '|') && std::getline(lines, state, '|') &&
         std::getline(lines, task.reason)) {
    task.is_running = state == "RUNNING" || state == "COMPLETING";
    tasks.push_back(task);
  }
  return tasks;
}

Result<void> cancel_in_slurm(const std::vector<std::string>& ids) {
  std::vector<std::string> words = {"scancel"};
  words.insert(words.end(), ids.begin(), ids.end());
  const auto printed = ask(words);
  if (!printed) return printed.error();
  return {};
}

}  // namespace scanknit
