#include "tests/app/scan.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace scanknit {

Scan::Scan(const ScanSize& size) {
  const Outcome outcome =
      scanknit_command({"synth", "sphere", "-o", recording().string(), "--frames", std::to_string(size.frames),
                        "--width", std::to_string(size.width), "--height", std::to_string(size.height), "--quiet"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
}

std::filesystem::path Scan::depth_picture(std::size_t place) const {
  std::vector<std::filesystem::path> pictures;
  for (const auto& entry : std::filesystem::directory_iterator(recording() / "depth")) pictures.push_back(entry.path());
  std::sort(pictures.begin(), pictures.end());
  return pictures.at(place);
}

Outcome Scan::run(const std::vector<std::string>& more_arguments) const {
  std::vector<std::string> arguments = {"run", recording().string(), "--set", "fusion.voxel_size=8mm"};
  const bool has_output = std::find(more_arguments.begin(), more_arguments.end(), "-o") != more_arguments.end();
  if (!has_output) arguments.insert(arguments.end(), {"-o", output().string()});
  arguments.insert(arguments.end(), more_arguments.begin(), more_arguments.end());
  return scanknit_command(arguments);
}

nlohmann::json Scan::report() const {
  const std::string text = read_text(output() / "report.json");
  return nlohmann::json::parse(text, nullptr, false);
}

}  // namespace scanknit
