#include "scan/volume/write_beside_mesh.h"

#include <string>

#include "core/files/atomic_file.h"
#include "export/trajectory.h"

namespace scanknit {

Result<void> write_beside_mesh(const TsdfVolume& volume, const Trajectory& trajectory, const ScanJob& job,
                               ScanSession& session, FilesByKind& files, std::optional<double> view_sigma_m) {
  if (job.files.volume) {
    files["volume"] = job.files.volume->string();
    const auto saved = session.timed("write", [&] { return volume.save(*job.files.volume, view_sigma_m); });
    if (!saved) return saved;
  }
  if (!job.files.trajectory) return {};
  files["trajectory"] = job.files.trajectory->string();
  const std::string text = trajectory_text(*job.files.trajectory, stamped_poses(trajectory));
  return session.timed("write", [&] { return write_file_atomically(*job.files.trajectory, text); });
}

}  // namespace scanknit
