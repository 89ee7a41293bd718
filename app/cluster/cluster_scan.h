// ClusterScan: brings a scan to its end on a cluster: plans it, fuses its bricks, joins them, and again what was lost.
#pragma once

#include <cstddef>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "app/cluster/cluster_folder.h"
#include "app/commands.h"
#include "app/terminal/console.h"
#include "core/result.h"
#include "scan/job/brick_job.h"

namespace scanknit {

/// All state is files: the job's, which say what is done, and Slurm's queue. So a second process goes on where the
/// first one ended, and the batches come to their end without either.
class ClusterScan {
 public:
  /// Both must outlive it.
  ClusterScan(const ClusterArguments& arguments, const CommonArguments& common);

  /// Submits what is missing, unless it is in the queue already, and follows it. Returns the text that `join` printed.
  /// Errors: kUsage when Slurm is not there or refuses; those of the step that failed, with its words; kInternal when
  /// batches are killed again and again without anything done between.
  [[nodiscard]] Result<std::string> run(Console& console, const std::stop_token& stop);

  /// Takes the batches out of the queue. Returns how many. Errors: kInput for a job that does not exist.
  [[nodiscard]] Result<std::size_t> cancel() const;

  /// True when run() ended because somebody did so.
  [[nodiscard]] bool was_cancelled() const { return was_cancelled_; }

 private:
  enum class Next { kSubmit, kWait, kEnd };
  [[nodiscard]] Result<void> check_arguments() const;
  [[nodiscard]] bool is_planned() const;
  /// Unless another process has done so meanwhile.
  [[nodiscard]] Result<void> submit(Console& console);
  [[nodiscard]] Result<std::string> submit_step(ClusterStep step, const std::vector<std::string>& arguments,
                                                std::size_t tasks, const std::string& after) const;
  void show(const std::vector<SlurmTask>& queue, Console& console);
  /// What to do when nothing of the job is in the queue. Errors: it cannot come to its end.
  [[nodiscard]] Result<Next> after_queue();
  [[nodiscard]] Error failure_of(ClusterStep step) const;

  const ClusterArguments& arguments_;
  const CommonArguments& common_;
  ClusterFolder folder_;
  std::vector<std::string> plan_;     ///< the arguments of `plan`
  std::size_t done_ = 0;              ///< bricks, when last submitted
  std::size_t shown_ = 0;             ///< bricks
  std::size_t fruitless_rounds_ = 0;  ///< in a row
  bool is_waiting_told_ = false;
  bool was_cancelled_ = false;
};

}  // namespace scanknit
