// From a recording of a turntable to a closed, coloured mesh: what `scanknit run RECORDING --preset turntable` does.
//
//   scan_a_turntable RECORDING FOLDER      Ctrl-C ends the frames; what has been fused becomes the mesh
#include <atomic>
#include <csignal>
#include <cstdio>

#include "scan/scan.h"

namespace {

std::atomic<bool> is_cancelled = false;

/// Prints progress and warnings, and ends the scan's frames when it is cancelled.
class Terminal final : public scanknit::ScanObserver {
  void on_progress(std::string_view what, std::size_t done, std::size_t total) override {
    std::fprintf(stderr, "\r%.*s %zu of %zu ", static_cast<int>(what.size()), what.data(), done, total);
  }
  void on_warning(const scanknit::ScanWarning& warning) override {
    std::fprintf(stderr, "\n%s\n", warning.text.c_str());
  }
  std::optional<scanknit::ScanCommand> next_command(std::stop_token, std::chrono::nanoseconds) override {
    if (!is_cancelled) return std::nullopt;
    return scanknit::ScanCommand{scanknit::ScanCommand::Kind::kFinish};
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  std::signal(SIGINT, [](int) { is_cancelled = true; });
  scanknit::ScanJob job{.input = argv[1]};
  job.files.meshes = {std::filesystem::path(argv[2]) / "model.glb"};
  job.config.acquire.min_depth_m = 0.2;
  job.config.acquire.max_depth_m = 1;
  job.config.fusion.voxel_size_m = 0.001;
  job.config.fusion.truncation_voxels = 5;
  job.config.turntable.is_enabled = true;
  job.config.extract.min_component_triangles = 1000;
  job.config.finish.min_piece_share = 0.02;
  Terminal terminal;
  const scanknit::ScanResult scan = scanknit::scan_recording(job, terminal);
  if (!scan.outcome) std::fprintf(stderr, "\n%s\n", scan.outcome.error().text().c_str());
  return scan.outcome ? 0 : 1;
}
