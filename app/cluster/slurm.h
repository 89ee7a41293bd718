// Slurm (Yoo, Jette & Grondona 2003): batches of a cluster, through its own programs sbatch, squeue and scancel.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"

namespace scanknit {

/// What sbatch is given.
struct SlurmBatch {
  std::string name;
  std::filesystem::path script;
  std::filesystem::path out, err;         ///< Slurm's patterns: %A the batch, %a the task
  std::size_t tasks = 0;                  ///< of an array; 0: none
  std::size_t cpus = 1;                   ///< of each task
  std::string after = {};                 ///< a dependency, as "afterok:12"; empty: none
  std::vector<std::string> options = {};  ///< for sbatch, as given
};

/// One of a user's batches, or of an array's tasks, that waits or runs.
struct SlurmTask {
  std::string id;  ///< of the batch
  std::string name;
  bool is_running = false;
  std::string reason;  ///< why it waits, in Slurm's words
};

/// Returns the batch's number. Slurm starts it again on another node when its own is lost. Errors (kUsage): there is no
/// Slurm here, or it refuses the batch, with its words.
[[nodiscard]] Result<std::string> submit_to_slurm(const SlurmBatch& batch);

/// This user's with these names. Errors (kUsage): no Slurm, or it does not answer.
[[nodiscard]] Result<std::vector<SlurmTask>> slurm_queue(const std::vector<std::string>& names);

/// Errors: as above.
[[nodiscard]] Result<void> cancel_in_slurm(const std::vector<std::string>& ids);

}  // namespace scanknit
