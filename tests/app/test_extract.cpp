// `scanknit extract` and `scanknit info` on volumes of every kind.
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "export/mesh/read_mesh.h"
#include "tests/app/program.h"
#include "tests/app/scan.h"
#include "tests/app/volume_files.h"
#include "tests/support/text.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

using test::contains;

std::vector<std::string> joined(std::vector<std::string> first, const std::vector<std::string>& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

std::vector<std::string> raw_options(const Ball& ball) {
  return {"--dims", ball.dims_option(), "--type", "uint16", "--spacing", ball.spacing_option()};
}

/// `scanknit extract VOLUME -o OUTPUT ...`
Outcome extract(const fs::path& volume, const fs::path& output, const std::vector<std::string>& more) {
  return scanknit_command(joined({"extract", volume.string(), "-o", output.string()}, more));
}

Json report_of(const fs::path& volume, const fs::path& output, const std::vector<std::string>& more) {
  const Outcome outcome = extract(volume, output, joined({"--json"}, more));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return Json::parse(outcome.out, nullptr, false);
}

Json info(const fs::path& file, const std::vector<std::string>& more = {}) {
  const Outcome outcome = scanknit_command(joined({"info", "--json", file.string()}, more));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  return Json::parse(outcome.out, nullptr, false);
}

void expect_a_ball_at(const Json& bounds, const std::array<double, 3>& centre, double radius) {
  constexpr double kTolerance = 0.04;  // of the radius: the widest spacing is a fifth of it
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(bounds[0][axis].get<double>(), centre[axis] - radius, kTolerance * radius);
    EXPECT_NEAR(bounds[1][axis].get<double>(), centre[axis] + radius, kTolerance * radius);
  }
}

/// The middle of the ball in the file's coordinates, which begin at `origin`.
std::array<double, 3> middle(const Ball& ball, const std::array<double, 3>& origin) {
  std::array<double, 3> centre = origin;
  for (std::size_t axis = 0; axis < 3; ++axis) centre[axis] += (ball.dims[axis] - 1) / 2.0 * ball.spacing_mm[axis];
  return centre;
}

struct VolumeKind {
  const char* name;
  const char* file;
  const char* format;
  std::function<void(const Ball&, const fs::path&)> write;
  std::vector<std::string> options;
  bool has_origin;
};

std::ostream& operator<<(std::ostream& out, const VolumeKind& kind) {
  return out << kind.name;
}

class EveryVolume : public ::testing::TestWithParam<VolumeKind> {
 protected:
  EveryVolume() { GetParam().write(ball_, path()); }
  [[nodiscard]] fs::path path() const { return folder_ / GetParam().file; }
  [[nodiscard]] std::array<double, 3> centre_mm() const {
    return middle(ball_, GetParam().has_origin ? kBallOriginMm : std::array<double, 3>{});
  }
  Ball ball_;
  TempFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(
    Kind, EveryVolume,
    ::testing::Values(
        VolumeKind{"Nrrd", "ball.nrrd", "NRRD", write_nrrd, {}, true},
        VolumeKind{"MetaImage", "ball.mha", "MetaImage", write_meta_image, {}, true},
        VolumeKind{"Nifti", "ball.nii", "NIfTI", write_nifti, {}, true},
        VolumeKind{"Dicom", "series", "DICOM", write_dicom_series, {}, true},
        VolumeKind{"Images", "stack", "image stack", write_tiff_stack, {"--spacing", "0.5x0.75x1"}, false},
        VolumeKind{"Raw", "ball.raw", "raw", [](const Ball& ball, const fs::path& path) { write_raw(ball, path); },
                   raw_options({}), false},
        VolumeKind{"BigEndianRaw", "ball.bin", "raw",
                   [](const Ball& ball, const fs::path& path) { write_raw(ball, path, true); },
                   joined(raw_options({}), {"--byte-order", "big"}), false}),
    [](const auto& info_of_test) { return std::string(info_of_test.param.name); });

TEST_P(EveryVolume, BecomesAClosedManifoldMeshOfTheRightSize) {
  const Json report =
      report_of(path(), folder_ / "ball.ply", joined({"--isovalue", kBallIsovalue}, GetParam().options));
  EXPECT_EQ(report["mesh"]["is_closed"], true);
  EXPECT_EQ(report["mesh"]["is_manifold"], true);
  EXPECT_EQ(report["mesh"]["euler"], 2);
  std::array<double, 3> centre_m = centre_mm();
  for (double& coordinate : centre_m) coordinate /= 1000;
  expect_a_ball_at(report["mesh"]["bounds_m"], centre_m, kBallRadiusMm / 1000);
  EXPECT_EQ(report["volume"]["format"], GetParam().format);
  EXPECT_EQ(report["volume"]["dims"], Json(ball_.dims));
  EXPECT_NEAR(report["volume"]["spacing_m"][2].get<double>(), 0.001, 1e-9);
}

TEST_P(EveryVolume, KeepsItsOwnCoordinatesInPly) {
  const fs::path mesh = folder_ / "ball.ply";
  (void)report_of(path(), mesh, joined({"--isovalue", kBallIsovalue}, GetParam().options));
  expect_a_ball_at(info(mesh)["bounds_m"], centre_mm(), kBallRadiusMm);
}

TEST_P(EveryVolume, IsDescribed) {
  const Json json = info(path(), GetParam().options);
  EXPECT_EQ(json["kind"], "volume");
  EXPECT_EQ(json["format"], GetParam().format);
  EXPECT_EQ(json["sample_type"], "uint16");
  EXPECT_EQ(json["dims"], Json(ball_.dims));
  EXPECT_NEAR(json["spacing"][1].get<double>(), 0.75, 1e-6);
  EXPECT_NEAR(json["origin"][0].get<double>(), GetParam().has_origin ? kBallOriginMm[0] : 0, 1e-6);
  EXPECT_EQ(json["directions"], Json::parse("[[1.0,0.0,0.0],[0.0,1.0,0.0],[0.0,0.0,1.0]]"));
  EXPECT_EQ(json["metres_per_unit"], 0.001);
  EXPECT_EQ(json["value_range"], Json({ball_.sample(0, 0, 0), ball_.sample(11, 9, 7)}));
  const Outcome text = scanknit_command(joined({"info", path().string()}, GetParam().options));
  EXPECT_TRUE(contains(text.out, GetParam().format)) << text.out;
}

/// A ball in a NRRD file.
class Extract : public ::testing::Test {
 protected:
  Extract() { write_nrrd(ball_, path()); }
  [[nodiscard]] fs::path path() const { return folder_ / "ball.nrrd"; }
  [[nodiscard]] fs::path operator/(const std::string& name) const { return folder_ / name; }
  Ball ball_;
  TempFolder folder_;
};

TEST_F(Extract, StlAndObjKeepTheFilesUnitAndGlbIsMetresYUp) {
  const std::array<double, 3> centre = middle(ball_, kBallOriginMm);
  for (const char* name : {"ball.stl", "ball.obj"}) {
    (void)report_of(path(), folder_ / name, {"--isovalue", kBallIsovalue});
    expect_a_ball_at(info(folder_ / name)["bounds_m"], centre, kBallRadiusMm);
  }
  (void)report_of(path(), folder_ / "ball.glb", {"--isovalue", kBallIsovalue});
  // z up becomes y up: x, z, -y.
  expect_a_ball_at(info(folder_ / "ball.glb")["bounds_m"], {centre[0] / 1000, centre[2] / 1000, -centre[1] / 1000},
                   kBallRadiusMm / 1000);
}

TEST_F(Extract, AFolderGetsMeshesPreviewAndReport) {
  ASSERT_EQ(extract(path(), folder_ / "out", {"--isovalue", kBallIsovalue}).exit_code, 0);
  for (const char* name : {"model.glb", "model.ply", "preview.png", "report.json"}) {
    EXPECT_TRUE(fs::exists(folder_ / "out" / name)) << name;
  }
}

TEST_F(Extract, WritesNoColoursAndNormalsAsAsked) {
  (void)report_of(path(), folder_ / "ball.ply", {"--isovalue", kBallIsovalue});
  EXPECT_EQ(info(folder_ / "ball.ply")["has_colours"], false);
  EXPECT_EQ(info(folder_ / "ball.ply")["has_normals"], true);
  EXPECT_TRUE(contains(read_text(folder_ / "ball.ply").substr(0, 300), "positions in millimetres"));
  (void)report_of(path(), folder_ / "bare.ply", {"--isovalue", kBallIsovalue, "--set", "extract.normals=false"});
  EXPECT_EQ(info(folder_ / "bare.ply")["has_normals"], false);
}

TEST_F(Extract, WithoutAnIsovalueShowsTheValuesAndExitsWith2) {
  const Outcome outcome = extract(path(), folder_ / "ball.ply", {});
  EXPECT_EQ(outcome.exit_code, 2);
  const std::string range =
      "from " + std::to_string(ball_.sample(0, 0, 0)) + " to " + std::to_string(ball_.sample(11, 9, 7));
  EXPECT_TRUE(contains(outcome.err, range)) << outcome.err;
  EXPECT_TRUE(contains(outcome.err, "auto-isovalue")) << outcome.err;
  EXPECT_FALSE(fs::exists(folder_ / "ball.ply"));
}

TEST_F(Extract, TakesTheIsovalueFromAConfiguration) {
  std::ofstream(folder_ / "iso.yaml") << "extract: {isovalue: 600}\n";
  const Json report = report_of(path(), folder_ / "ball.ply", {"--config", (folder_ / "iso.yaml").string()});
  EXPECT_EQ(report["extract"]["isovalue"], 600.0);
  EXPECT_EQ(report["extract"]["isovalue_source"], "config");
}

TEST_F(Extract, ProposesAnIsovalueAndSaysIt) {
  const Outcome outcome = extract(path(), folder_ / "out", {"--auto-isovalue"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json report = Json::parse(read_text(folder_ / "out" / "report.json"));
  EXPECT_EQ(report["extract"]["isovalue_source"], "otsu");
  EXPECT_EQ(report["extract"]["isovalue"], report["config"]["extract"]["isovalue"]);
  const double isovalue = report["extract"]["isovalue"].get<double>();
  EXPECT_GT(isovalue, 300);
  EXPECT_LT(isovalue, 700);
  for (const std::string& text : {outcome.out, outcome.err}) EXPECT_TRUE(contains(text, "Otsu")) << text;
  const Outcome both = extract(path(), folder_ / "out", {"--auto-isovalue", "--isovalue", "600"});
  EXPECT_EQ(both.exit_code, 2) << both.err;
}

TEST_F(Extract, PrintsHowOftenEachSubCaseOccurred) {
  const Outcome outcome = extract(path(), folder_ / "out", {"--isovalue", kBallIsovalue, "--stats"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json report = Json::parse(read_text(folder_ / "out" / "report.json"));
  const Json& sub_cases = report["extract"]["sub_cases"];
  std::size_t cells = 0, without_surface = 0;
  for (const auto& [name, count] : sub_cases.items()) {
    EXPECT_TRUE(contains(outcome.out, "\n" + name + " ")) << name << " in\n" << outcome.out;
    cells += count.get<std::size_t>();
    if (name == "0") without_surface = count.get<std::size_t>();
  }
  EXPECT_EQ(cells, 23u * 19 * 15);
  EXPECT_GT(without_surface, 0u);
  for (const char* name : {"3A", "3B", "6A", "6B", "7A", "10C", "12A", "14"}) {
    EXPECT_TRUE(sub_cases.contains(name)) << name;
  }
  EXPECT_EQ(sub_cases["1"], report["extract"]["cases"]["configuration_01"]);
}

TEST_F(Extract, KnowsEveryDecider) {
  for (const char* decider : {"trilinear", "asymptotic", "chord", "knit", "fixed_high", "fixed_low", "tetra5", "tetra6",
                              "tetra24", "lorensen"}) {
    const Json report = report_of(path(), folder_ / "ball.ply", {"--isovalue", kBallIsovalue, "--decider", decider});
    EXPECT_EQ(report["mesh"]["is_closed"], true) << decider;  // a ball has no ambiguous face
    EXPECT_EQ(report["config"]["extract"]["decider"], decider);
  }
  EXPECT_EQ(extract(path(), folder_ / "ball.ply", {"--isovalue", "600", "--decider", "guess"}).exit_code, 3);
}

TEST_F(Extract, IsTheSameBytesForAnyNumberOfThreads) {
  std::vector<std::string> meshes;
  for (const char* threads : {"1", "2", "5"}) {
    (void)report_of(path(), folder_ / "ball.ply", {"--isovalue", kBallIsovalue, "--threads", threads});
    meshes.push_back(read_text(folder_ / "ball.ply"));
  }
  EXPECT_TRUE(meshes[0] == meshes[1] && meshes[0] == meshes[2]);
}

TEST_F(Extract, LorensenWarnsOfHoles) {
  const Outcome outcome = extract(path(), folder_ / "ball.ply", {"--isovalue", kBallIsovalue, "--decider", "lorensen"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_TRUE(contains(outcome.err, "holes")) << outcome.err;
  EXPECT_FALSE(contains(extract(path(), folder_ / "ball.ply", {"--isovalue", kBallIsovalue}).err, "holes"));
}

TEST_F(Extract, AnEmptyMeshExitsWith7AndShowsTheValues) {
  const Outcome outcome = extract(path(), folder_ / "ball.ply", {"--isovalue", "5000"});
  EXPECT_EQ(outcome.exit_code, 7);
  EXPECT_TRUE(contains(outcome.err, std::to_string(ball_.sample(11, 9, 7)))) << outcome.err;
  EXPECT_FALSE(fs::exists(folder_ / "ball.ply"));
}

TEST_F(Extract, OptionsThatDoNotFitTheVolumeExitWith2) {
  write_nifti(ball_, folder_ / "ball.nii");
  const std::vector<std::string> isovalue = {"--isovalue", "600"};
  const auto exit_code = [&](const std::string& file, const std::vector<std::string>& more) {
    return extract(folder_ / file, folder_ / "a.ply", joined(isovalue, more)).exit_code;
  };
  EXPECT_EQ(exit_code("ball.nii", {"--dims", ball_.dims_option()}), 2);
  EXPECT_EQ(exit_code("ball.nii", {"--spacing", "1"}), 2);
  EXPECT_EQ(exit_code("ball.vdb", {"--spacing", "1"}), 2);
  EXPECT_EQ(exit_code("ball.nii", {"--type", "int12"}), 2);
  EXPECT_EQ(exit_code("ball.nii", {"--byte-order", "big"}), 2);
  EXPECT_EQ(exit_code("ball.raw", {"--dims", "24x20", "--type", "uint16", "--spacing", "1"}), 2);
  EXPECT_EQ(exit_code("ball.raw", {"--dims", "24x20x16", "--type", "uint16", "--spacing", "0"}), 2);
  write_raw(ball_, folder_ / "ball.raw");
  EXPECT_EQ(exit_code("ball.raw", {"--dims", "24x20x16", "--type", "uint16"}), 2);  // no spacing
  write_tiff_stack(ball_, folder_ / "stack");
  const Outcome no_spacing = extract(folder_ / "stack", folder_ / "a.ply", isovalue);
  EXPECT_EQ(no_spacing.exit_code, 2);
  EXPECT_TRUE(contains(no_spacing.err, "spacing")) << no_spacing.err;
}

TEST_F(Extract, UnreadableVolumesExitWith4AndWriteNothing) {
  const std::string whole = read_text(path());
  std::ofstream(folder_ / "short.nrrd", std::ios::binary) << whole.substr(0, whole.size() - 1);
  std::ofstream(folder_ / "head.nrrd", std::ios::binary) << whole.substr(0, 100);
  std::ofstream(folder_ / "empty.nii", std::ios::binary) << "";
  std::ofstream(folder_ / "notes.txt", std::ios::binary) << "not a volume";
  fs::create_directories(folder_ / "nothing");
  for (const char* name : {"short.nrrd", "head.nrrd", "empty.nii", "notes.txt", "nothing", "absent.nrrd"}) {
    const Outcome outcome = extract(folder_ / name, folder_ / "a.ply", {"--isovalue", "600"});
    EXPECT_EQ(outcome.exit_code, 4) << name << ": " << outcome.err;
    EXPECT_TRUE(contains(outcome.err, name)) << outcome.err;
    EXPECT_EQ(scanknit_command({"info", (folder_ / name).string()}).exit_code, 4) << name;
  }
  EXPECT_FALSE(fs::exists(folder_ / "a.ply"));
}

TEST(ExtractVdb, OfSignedDistancesIsAtZeroByDefault) {
  const Scan scan;
  const fs::path volume = scan / "v.vdb";
  ASSERT_EQ(scan.run({"--save-volume", volume.string()}).exit_code, 0);
  const Json plain = report_of(volume, scan / "a.ply", {});
  EXPECT_EQ(plain["extract"]["isovalue"], 0.0);
  EXPECT_EQ(plain["extract"]["isovalue_source"], "signed_distance");
  const Outcome automatic = extract(volume, scan / "a.ply", {"--auto-isovalue"});
  EXPECT_EQ(automatic.exit_code, 0);
  EXPECT_TRUE(contains(automatic.err, "signed distances")) << automatic.err;
  EXPECT_EQ(report_of(volume, scan / "a.ply", {"--isovalue", "0.001"})["extract"]["isovalue_source"], "config");
}

/// A raw ball of 1.7 MiB as floats.
class Streamed : public ::testing::Test {
 protected:
  Streamed() { write_raw(ball_, path()); }
  [[nodiscard]] fs::path path() const { return folder_ / "ball.raw"; }
  [[nodiscard]] std::vector<std::string> options(const char* budget, const char* isovalue = kBallIsovalue) const {
    return joined(raw_options(ball_),
                  {"--isovalue", isovalue, "--set", std::string("extract.memory_budget=") + budget});
  }
  Ball ball_{{72, 64, 96}, {0.2, 0.25, 0.15}};
  TempFolder folder_;
};

TEST_F(Streamed, MeshesAreTheSameBytes) {
  for (const std::string ending : {".ply", ".stl"}) {
    const Json whole = report_of(path(), folder_ / ("whole" + ending), options("1GiB"));
    const Json streamed = report_of(path(), folder_ / ("streamed" + ending), options("1MiB"));
    EXPECT_EQ(whole["volume"]["is_streamed"], false);
    EXPECT_EQ(streamed["volume"]["is_streamed"], true);
    EXPECT_EQ(streamed["extract"]["sub_cases"], whole["extract"]["sub_cases"]);
    const std::string bytes = read_text(folder_ / ("whole" + ending));
    EXPECT_GT(bytes.size(), 100'000u);
    EXPECT_TRUE(bytes == read_text(folder_ / ("streamed" + ending))) << ending;
  }
}

TEST_F(Streamed, TheReportSaysWhatIsNotKnown) {
  const Json whole = report_of(path(), folder_ / "whole.ply", options("1GiB"))["mesh"];
  const Json streamed = report_of(path(), folder_ / "streamed.ply", options("1MiB"))["mesh"];
  for (const char* key : {"vertices", "triangles", "bounds_m"}) EXPECT_EQ(streamed[key], whole[key]) << key;
  for (const char* key : {"components", "boundary_edges", "euler", "is_closed", "is_manifold"}) {
    EXPECT_TRUE(streamed[key].is_null()) << key;
  }
}

TEST_F(Streamed, AFolderHasAPictureOfTheMeshMadeCoarse) {
  const Json streamed = report_of(path(), folder_ / "out", joined(options("1MiB"), {"--set", "export.formats=[ply]"}));
  EXPECT_EQ(streamed["volume"]["is_streamed"], true);
  const std::string picture = read_text(folder_ / "out/preview.png");
  EXPECT_EQ(streamed["files"]["preview"], (folder_ / "out/preview.png").string());
  EXPECT_GT(picture.size(), 20'000u) << "four balls, shaded";
  const std::string page = read_text(folder_ / "out/report.html");
  EXPECT_TRUE(contains(page, "is drawn coarsely"));
  EXPECT_TRUE(contains(page, "<img"));
}

TEST_F(Streamed, OtherFormatsAreRefusedWithWhatToDo) {
  const Outcome outcome = extract(path(), folder_ / "ball.glb", options("1MiB"));
  EXPECT_EQ(outcome.exit_code, 9);
  for (const char* word : {".ply", ".stl", "extract.memory_budget"}) {
    EXPECT_TRUE(contains(outcome.err, word)) << outcome.err;
  }
  EXPECT_FALSE(fs::exists(folder_ / "ball.glb"));
}

TEST_F(Streamed, CannotBeFinishedAndSaysWhatToDo) {
  const std::vector<std::string> simplify = {"--set", "finish.triangles=1000"};
  const Outcome outcome = extract(path(), folder_ / "ball.ply", joined(options("1MiB"), simplify));
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_TRUE(contains(outcome.err, "extract.memory_budget")) << outcome.err;
  const Json whole = report_of(path(), folder_ / "ball.ply", joined(options("1GiB"), simplify));
  EXPECT_LE(whole["mesh"]["triangles"], 1000);
  EXPECT_EQ(whole["mesh"]["is_closed"], true);
}

TEST_F(Streamed, AVolumeWithoutDistancesCannotBeClosed) {
  const Outcome outcome =
      extract(path(), folder_ / "ball.ply", joined(options("1GiB"), {"--set", "finish.watertight=full"}));
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_TRUE(contains(outcome.err, "leave them out")) << outcome.err;
}

TEST_F(Streamed, AnEmptyMeshExitsWith7AndLeavesNoFile) {
  const Outcome outcome = extract(path(), folder_ / "ball.ply", options("1MiB", "5000"));
  EXPECT_EQ(outcome.exit_code, 7) << outcome.err;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 1);  // the volume
}

TEST_F(Streamed, AFullDiskExitsWith8AndKeepsTheOldFile) {
  std::ofstream(folder_ / "ball.ply") << "old";
  constexpr std::uintmax_t kDiskBytes = 100'000;
  const Outcome outcome = scanknit_command(
      joined({"extract", path().string(), "-o", (folder_ / "ball.ply").string()}, options("1MiB")), kDiskBytes);
  EXPECT_EQ(outcome.exit_code, 8) << outcome.err;
  EXPECT_EQ(read_text(folder_ / "ball.ply"), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 2);
}

TEST_F(Streamed, ProposesTheSameIsovalue) {
  const auto automatic = [&](const char* budget) {
    return joined(raw_options(ball_), {"--auto-isovalue", "--set", std::string("extract.memory_budget=") + budget});
  };
  EXPECT_EQ(report_of(path(), folder_ / "a.ply", automatic("1MiB"))["extract"]["isovalue"],
            report_of(path(), folder_ / "b.ply", automatic("1GiB"))["extract"]["isovalue"]);
}

/// No defect, and no open edge but on the border of the volume, whose samples 0 and `last_mm` lie there.
void expect_manifold_within_border(const Json& report, const fs::path& file, const Eigen::Vector3d& last_mm) {
  EXPECT_GT(report["mesh"]["triangles"].get<std::size_t>(), 100'000u);
  for (const char* key : {"non_manifold_edges", "non_manifold_vertices", "misoriented_edges", "duplicate_triangles"}) {
    EXPECT_EQ(report["mesh"][key], 0) << key;
  }
  const auto mesh = read_mesh(file);
  ASSERT_TRUE(mesh);
  std::map<std::array<std::uint32_t, 2>, int> triangles_of_edge;
  for (const Triangle& t : mesh->triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax({t[i], t[(i + 1) % 3]});
      ++triangles_of_edge[{low, high}];
    }
  }
  constexpr double kRoundingMm = 1e-3;
  for (const auto& [edge, count] : triangles_of_edge) {
    if (count == 2) continue;
    const Eigen::Vector3d a = mesh->positions_m[edge[0]].cast<double>();
    const Eigen::Vector3d b = mesh->positions_m[edge[1]].cast<double>();
    const auto both_at = [&](double place, int axis) {
      return std::abs(a[axis] - place) < kRoundingMm && std::abs(b[axis] - place) < kRoundingMm;
    };
    bool is_on_border = false;
    for (int axis = 0; axis < 3; ++axis) is_on_border |= both_at(0, axis) || both_at(last_mm[axis], axis);
    ASSERT_TRUE(is_on_border) << a.transpose() << " to " << b.transpose();
  }
}

TEST(ExtractMri, AnMriFromDebianIsClosedAndManifold) {
  const fs::path volume = "/usr/share/mricron/templates/ch2bet.nii.gz";
  if (!fs::exists(volume)) GTEST_SKIP() << "SKIPPED: the Debian package mricron-data is not installed";
  const TempFolder folder;
  const Json report = report_of(volume, folder / "brain.ply", {"--auto-isovalue"});
  EXPECT_EQ(report["mesh"]["is_closed"], true);  // the brain alone, with air around
  expect_manifold_within_border(report, folder / "brain.ply", Eigen::Vector3d::Zero());
  EXPECT_EQ(report["volume"]["dims"], Json({181, 217, 181}));
}

TEST(ExtractCt, TheSkullOfACtFromDebianIsManifold) {
  const fs::path project = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";
  if (!fs::exists(project)) GTEST_SKIP() << "SKIPPED: the Debian package invesalius-examples is not installed";
  const TempFolder folder;
  const std::string unpack = "tar xzf '" + project.string() + "' -C '" + folder.path().string() + "'";
  ASSERT_EQ(std::system(unpack.c_str()), 0);
  fs::path samples;
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    if (entry.path().filename() == "matrix.dat") samples = entry.path();
  }
  ASSERT_FALSE(samples.empty());
  const Json report =
      report_of(samples, folder / "skull.ply",
                {"--dims", "256x256x108", "--type", "int16", "--spacing", "0.957x0.957x1.5", "--isovalue", "300"});
  expect_manifold_within_border(report, folder / "skull.ply", {255 * 0.957, 255 * 0.957, 107 * 1.5});
  EXPECT_GT(report["mesh"]["boundary_edges"], 0);  // the scan ends within the head
}

TEST(ExtractInterrupt, CtrlCFinishesTheMeshAndExitsWith130) {
  const TempFolder folder;
  std::string noise;
  std::uint32_t state = 1;
  for (int i = 0; i < 112 * 112 * 112; ++i) {
    state = state * 1664525u + 1013904223u;  // Knuth's linear congruential generator
    noise.push_back(static_cast<char>(state >> 24));
  }
  std::ofstream(folder / "noise.raw", std::ios::binary) << noise;
  Program program({"extract", (folder / "noise.raw").string(), "-o", (folder / "noise.ply").string(), "--dims",
                   "112x112x112", "--type", "uint8", "--spacing", "1", "--isovalue", "127.5", "--decider", "lorensen"});
  while (program.is_running() && !contains(program.err_so_far(), "holes")) std::this_thread::yield();
  program.send(SIGINT);
  EXPECT_EQ(program.wait().exit_code, 130);
  EXPECT_TRUE(fs::exists(folder / "noise.ply"));
}

}  // namespace
}  // namespace scanknit
