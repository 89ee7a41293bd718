// ClusterFolder: JOB.slurm, beside a job's folder: the scripts that Slurm runs, what they said, and how they ended.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "app/cluster/slurm.h"
#include "core/result.h"

namespace scanknit {

/// The commands that a cluster runs, in this order.
enum class ClusterStep { kPlan, kWork, kJoin };
inline constexpr ClusterStep kClusterSteps[] = {ClusterStep::kPlan, ClusterStep::kWork, ClusterStep::kJoin};

/// A file that one process has locked, on whichever machine where the file system has locks.
class FileLock {
 public:
  explicit FileLock(int descriptor) : descriptor_(descriptor) {}
  FileLock(FileLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  FileLock& operator=(FileLock&&) = delete;
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock();

 private:
  int descriptor_;
};

/// STEP.sh               what Slurm runs; anyone can give it to sbatch by hand
/// STEP.out, STEP.err    what it printed, and its errors; of the tasks of an array: STEP-TASK.out, STEP-TASK.err
/// STEP.ends             the exit codes of those that came to their end, one a line
/// lock                  of the process that submits
/// cancelled             somebody cancelled the batches
class ClusterFolder {
 public:
  explicit ClusterFolder(const std::filesystem::path& job);

  [[nodiscard]] const std::filesystem::path& job() const { return job_; }
  /// For people, and for Slurm: the step's and, so that jobs are told apart, a number made of the job's path.
  [[nodiscard]] std::string name_of(ClusterStep step) const;
  [[nodiscard]] std::vector<std::string> names() const;

  [[nodiscard]] bool has_script(ClusterStep step) const;
  /// True when the step's script is there and runs this program with these arguments.
  [[nodiscard]] bool has_script(ClusterStep step, const std::vector<std::string>& arguments) const;
  /// Writes the step's script, for this program with these arguments; removes what the step left before. Returns its
  /// name, script and files. Errors: kOutput.
  [[nodiscard]] Result<SlurmBatch> prepare(ClusterStep step, const std::vector<std::string>& arguments) const;

  /// Exit codes since prepare(). Who was killed has none.
  [[nodiscard]] std::vector<int> ends_of(ClusterStep step) const;
  /// Empty when somebody gave the script to sbatch with another --output. Errors: kInput.
  [[nodiscard]] Result<std::string> printed_by(ClusterStep step) const;
  /// The last lines of the first task that said something; empty: none did.
  [[nodiscard]] std::string errors_of(ClusterStep step) const;

  /// Makes the folder, and keeps other processes out of this call until the result is destroyed. Errors: kOutput.
  [[nodiscard]] Result<FileLock> lock() const;

  [[nodiscard]] bool is_cancelled() const;
  [[nodiscard]] Result<void> set_cancelled(bool is_cancelled) const;

 private:
  [[nodiscard]] std::filesystem::path file(ClusterStep step, const std::string& ending) const;
  [[nodiscard]] std::string script(ClusterStep step, const std::vector<std::string>& arguments) const;
  /// In the order of their names.
  [[nodiscard]] std::vector<std::filesystem::path> files_of(ClusterStep step) const;

  std::filesystem::path job_, folder_;
};

}  // namespace scanknit
