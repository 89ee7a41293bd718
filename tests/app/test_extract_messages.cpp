// What `scanknit extract` says of volumes that it takes in part, or not at all.
#include <gtest/gtest.h>
#include <openvdb/openvdb.h>

#include <array>
#include <bit>
#include <fstream>
#include <limits>

#include "tests/app/program.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

void expect_said(const Outcome& outcome, int exit_code, const std::string& part) {
  EXPECT_EQ(outcome.exit_code, exit_code) << outcome.err;
  EXPECT_NE(outcome.err.find(part), std::string::npos) << outcome.err;
}

/// A raw file of 3 x 3 x 3 samples: `middle` among `around`.
template <typename Sample>
void write_cube(const fs::path& path, Sample middle, Sample around) {
  std::ofstream file(path, std::ios::binary);
  for (int n = 0; n < 27; ++n) {
    const auto raw = std::bit_cast<std::array<char, sizeof(Sample)>>(n == 13 ? middle : around);
    file.write(raw.data(), raw.size());
  }
}

Outcome extract_cube(const fs::path& path, const char* type, const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {
      "extract", path.string(), "-o", path.string() + ".ply", "--dims", "3x3x3", "--type", type, "--spacing", "1"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return scanknit_command(arguments);
}

TEST(ExtractMessages, AnIsovalueMayBeAsLargeAsAnyFloat) {
  const TempFolder folder;
  for (const float size : {2e12f, -2e12f, 2e38f}) {
    write_cube(folder / "a.raw", 1.25f * size, 0.5f * size);
    const Outcome outcome = extract_cube(folder / "a.raw", "float", {"--isovalue", std::to_string(size)});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  }
  expect_said(extract_cube(folder / "a.raw", "float", {"--isovalue", "1e39"}), 3, "3e+38");
}

TEST(ExtractMessages, AVolumeWithoutAFiniteSampleIsCalledThat) {
  const TempFolder folder;
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  write_cube(folder / "nan.raw", kNaN, kNaN);
  const std::string said = "not one finite sample";
  expect_said(extract_cube(folder / "nan.raw", "float", {}), 4, said);
  expect_said(extract_cube(folder / "nan.raw", "float", {"--auto-isovalue"}), 4, said);
  expect_said(extract_cube(folder / "nan.raw", "float", {"--isovalue", "3"}), 7, said);
}

TEST(ExtractMessages, HeaderBytesSayTheirBound) {
  const TempFolder folder;
  write_cube(folder / "a.raw", 1.0f, 0.0f);
  expect_said(extract_cube(folder / "a.raw", "float", {"--header-bytes", "-1"}), 2, "0 or more, got '-1'");
}

TEST(ExtractMessages, RoundingToFloatIsWarnedOf) {
  const TempFolder folder;
  write_cube(folder / "a.raw", std::int32_t{2}, std::int32_t{0});
  expect_said(extract_cube(folder / "a.raw", "int32", {"--isovalue", "1"}), 0, "samples of int32 become 32-bit floats");
  write_cube(folder / "b.raw", 2.0f, 0.0f);
  const Outcome quiet = extract_cube(folder / "b.raw", "float", {"--isovalue", "1"});
  EXPECT_EQ(quiet.exit_code, 0);
  EXPECT_EQ(quiet.err.find("floats"), std::string::npos) << quiet.err;
}

TEST(ExtractMessages, OtherGridsOfAVdbAreNamed) {
  const TempFolder folder;
  openvdb::initialize();
  const auto write = [&](const std::vector<std::string>& names) {
    openvdb::GridPtrVec grids;
    for (const std::string& name : names) {
      const auto grid = openvdb::FloatGrid::create(0);
      for (int n = 0; n < 27; ++n) grid->tree().setValue({n % 3, n / 3 % 3, n / 9}, n == 13 ? 2.0f : 0.5f);
      grid->setName(name);
      grids.push_back(grid);
    }
    openvdb::io::File((folder / "a.vdb").string()).write(grids);
    return scanknit_command(
        {"extract", (folder / "a.vdb").string(), "-o", (folder / "a.ply").string(), "--isovalue", "1"});
  };
  for (const auto& names : {std::vector<std::string>{"density"}, std::vector<std::string>{"tsdf", "weight"}}) {
    const Outcome all_taken = write(names);
    EXPECT_EQ(all_taken.exit_code, 0) << all_taken.err;
    EXPECT_EQ(all_taken.err.find("left out"), std::string::npos) << all_taken.err;
  }
  expect_said(write({"density", "heat", "fuel"}), 0, "'density' is meshed; left out: 'fuel', 'heat'");
  expect_said(write({"density", "density"}), 0, "left out: 'density'");
}

}  // namespace
}  // namespace scanknit
