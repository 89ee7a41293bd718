// What `scanknit run RECORDING --preset turntable` does: scan_a_turntable RECORDING FOLDER. It writes the same files,
// but no report. Ctrl-C ends the frames: what has been fused becomes the mesh, without looking for the turntable.
#include <csignal>
#include <iostream>

#include "scan/scan.h"

/// Prints progress and warnings; after Ctrl-C it stops the scan.
struct Terminal final : scanknit::ScanObserver {
  void on_progress(std::string_view what, std::size_t done, std::size_t total) override {
    std::cerr << '\r' << what << ' ' << done << " of " << total << ' ';
    if (is_interrupted) stop.request_stop();
  }
  void on_warning(const scanknit::ScanWarning& warning) override { std::cerr << '\n' << warning.text << '\n'; }
  std::stop_source stop;
  static inline volatile std::sig_atomic_t is_interrupted = 0;
};

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  std::signal(SIGINT, [](int) { Terminal::is_interrupted = 1; });
  const std::filesystem::path out = argv[2];
  scanknit::ScanJob job{.input = argv[1], .measures_fit = true};  // the fit is drawn in error.png and coverage.png
  job.files = {{out / "model.glb", out / "model.ply"}, out / "preview.png", out / "error.png", out / "coverage.png"};
  job.files.trajectory = out / "trajectory.txt";
  job.config.acquire.min_depth_m = 0.2;  // this, and what follows, is the preset
  job.config.acquire.max_depth_m = 1;
  job.config.fusion.voxel_size_m = 0.001;
  job.config.fusion.truncation_voxels = 5;
  job.config.fusion.loop_closure = false;
  job.config.turntable.is_enabled = true;
  job.config.extract.min_component_triangles = 1000;
  job.config.finish.min_piece_share = 0.02;
  job.config.finish.drops_crumbs = true;
  Terminal terminal;
  const scanknit::ScanResult scan = scanknit::scan_recording(job, terminal, terminal.stop.get_token());
  if (!scan.outcome) std::cerr << '\n' << scan.outcome.error().text() << '\n';
  return scan.outcome ? 0 : 1;
}
