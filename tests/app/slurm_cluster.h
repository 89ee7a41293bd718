// SlurmCluster: a real Slurm on this machine, with a controller and four nodes of one processor each.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

#include "tests/app/program.h"

namespace scanknit {

/// The daemons of Debian's packages slurmctld, slurmd and munge, in a folder and at ports of their own. During its
/// lifetime, SLURM_CONF names it to Slurm's programs.
class SlurmCluster {
 public:
  static constexpr int kNodes = 4;

  [[nodiscard]] static bool is_installed();
  SlurmCluster();
  ~SlurmCluster();
  SlurmCluster(const SlurmCluster&) = delete;
  SlurmCluster& operator=(const SlurmCluster&) = delete;

  /// True once all nodes wait for work; false if that takes more than half a minute.
  [[nodiscard]] bool is_ready() const;
  /// As if its plug was pulled: its daemon and all that runs on it are killed; the controller is told. What ran there
  /// starts again at once on another node, not two minutes later as Slurm has it.
  void lose_node(int node) const;
  void return_node(int node) const;
  /// What the node's workers run as; 0: none.
  [[nodiscard]] pid_t program_on(int node) const;
  /// The number of batches and tasks that wait or run.
  [[nodiscard]] int queued() const;

 private:
  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return folder_ / name; }
  void write_configuration() const;

  TempFolder folder_;
};

}  // namespace scanknit
