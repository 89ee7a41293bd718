// A small synthetic recording for the end-to-end tests, and the report of a run.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/app/program.h"

namespace scanknit {

/// A sphere of 10 cm radius seen from all round in small pictures: half a second to render, with true poses.
inline constexpr int kScanFrames = 12;

struct ScanSize {
  int frames = kScanFrames;
  int width = 96;
  int height = 72;
};

class Scan {
 public:
  explicit Scan(const ScanSize& size = {});

  [[nodiscard]] std::filesystem::path recording() const { return folder_ / "recording"; }
  [[nodiscard]] std::filesystem::path output() const { return folder_ / "out"; }
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
  /// The depth picture with this place in the recording.
  [[nodiscard]] std::filesystem::path depth_picture(std::size_t place) const;

  /// `scanknit run RECORDING -o OUT --set fusion.voxel_size=8mm ...`
  [[nodiscard]] Outcome run(const std::vector<std::string>& more_arguments = {}) const;
  /// report.json of the output folder; null when there is none.
  [[nodiscard]] nlohmann::json report() const;

 private:
  TempFolder folder_;
};

}  // namespace scanknit
