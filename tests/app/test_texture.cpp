// `--texture` by the built program: a figurine with fine patterns.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>

#include "synth/scene/scene.h"
#include "tests/app/suite_folder.h"
#include "tests/app/textured_glb.h"
#include "tests/core/welded_mesh.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class Texture : public SuiteFolder {
 protected:
  static void SetUpTestSuite() {
    SuiteFolder::SetUpTestSuite();
    const Outcome synth = scanknit_command(
        {"synth", "turntable", "-o", recording(), "--frames", "16", "--width", "240", "--height", "180", "--quiet"});
    ASSERT_EQ(synth.exit_code, 0) << synth.err;
    ASSERT_EQ(run("plain", {}).exit_code, 0);
    const Outcome textured = run("textured", {"--texture"});
    ASSERT_EQ(textured.exit_code, 0) << textured.err;
    said_ = textured.out;
  }
  [[nodiscard]] static fs::path glb(const std::string& name) { return fs::path(place(name)) / "model.glb"; }

  static Outcome run(const std::string& name, const std::vector<std::string>& more,
                     const std::string& from = recording()) {
    std::vector<std::string> arguments = {"run", from, "-o", place(name), "--set", "fusion.voxel_size=6mm"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scanknit_command(arguments);
  }

  static std::string said_;
};
std::string Texture::said_;

/// x y z and red green blue of a binary PLY of ours with normals, by position.
std::map<std::array<float, 3>, Eigen::Vector3d> vertex_colours(const fs::path& ply) {
  const std::string bytes = read_text(ply);
  constexpr std::string_view kEnd = "end_header\n";
  constexpr std::size_t kStride = 27;
  const std::size_t count = std::stoul(bytes.substr(bytes.find("element vertex ") + 15));
  const char* vertex = bytes.data() + bytes.find(kEnd) + kEnd.size();
  std::map<std::array<float, 3>, Eigen::Vector3d> colours;
  for (std::size_t i = 0; i < count; ++i, vertex += kStride) {
    std::array<float, 3> p{};
    std::memcpy(p.data(), vertex, sizeof(p));
    const auto channel = [&](std::size_t k) { return static_cast<double>(static_cast<unsigned char>(vertex[24 + k])); };
    colours[p] = {channel(0), channel(1), channel(2)};
  }
  return colours;
}

TEST(TextureColours, AreNearerTheTrueOnesThanThoseOfTheVertices) {
  const TempFolder folder;
  const std::string recording = folder / "recording";
  ASSERT_EQ(scanknit_command({"synth", "turntable", "-o", recording, "--frames", "36", "--quiet"}).exit_code, 0);
  const Outcome run = scanknit_command(
      {"run", recording, "-o", folder / "out", "--texture", "--quiet", "--set", "fusion.voxel_size=4mm"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto scene = make_scene("turntable");
  ASSERT_TRUE(scene);
  const test::TexturedMesh textured = test::read_textured_glb(fs::path(folder / "out") / "model.glb");
  const auto colours = vertex_colours(fs::path(folder / "out") / "model.ply");
  double of_texture = 0, of_vertices = 0;
  std::size_t points = 0;
  for (const Triangle& t : textured.mesh.triangles) {
    constexpr std::array<float, 3> kWeights = {0.2f, 0.3f, 0.5f};
    Eigen::Vector3d p = Eigen::Vector3d::Zero(), of_corners = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3f& q = textured.mesh.positions_m.at(t[k]);
      p += double{kWeights[k]} * q.cast<double>();
      const auto found = colours.find({q.x(), q.y(), q.z()});
      ASSERT_NE(found, colours.end()) << q.transpose();
      of_corners += double{kWeights[k]} * found->second;
    }
    const Eigen::Vector3d truth = 255 * (*scene)->colour((*scene)->nearest(p));
    of_texture += (textured.texture_colour(t, kWeights) - truth).squaredNorm() / 3;
    of_vertices += (of_corners - truth).squaredNorm() / 3;
    ++points;
  }
  const double texture_rms = std::sqrt(of_texture / static_cast<double>(points));
  const double vertices_rms = std::sqrt(of_vertices / static_cast<double>(points));
  std::cout << "rms difference from the true colours, of 255: texture " << texture_rms << ", vertices " << vertices_rms
            << " (" << points << " points)\n";
  EXPECT_LT(texture_rms, 0.65 * vertices_rms);
}

TEST_F(Texture, TheReportTellsOfIt) {
  const Json texture = report("textured")["texture"];
  std::cout << texture.dump(1) << "\n";
  EXPECT_EQ(texture["refused"], "");
  EXPECT_EQ(texture["frames"], 16);
  EXPECT_GT(texture["seen_share"].get<double>(), 0.9);
  EXPECT_GT(report("textured")["stages"]["texture"]["total_ms"].get<double>(), 0);
  EXPECT_TRUE(report("plain")["texture"].is_null());
  EXPECT_NE(said_.find("Texture  "), std::string::npos) << said_;
}

TEST_F(Texture, TheOtherFilesAreAsWithoutIt) {
  for (const char* name : {"model.ply", "preview.png", "trajectory.txt"}) {
    EXPECT_EQ(read_text(fs::path(place("textured")) / name), read_text(fs::path(place("plain")) / name)) << name;
  }
}

TEST_F(Texture, WeldedTheMeshIsThatOfThePly) {
  const test::TexturedMesh textured = test::read_textured_glb(glb("textured"));
  const Json mesh = report("textured")["mesh"];
  const MeshCheck check = check_mesh(test::welded(textured.mesh));
  EXPECT_EQ(check.vertices, mesh["vertices"].get<std::size_t>());
  EXPECT_EQ(check.triangles, mesh["triangles"].get<std::size_t>());
  EXPECT_EQ(check.euler, mesh["euler"].get<long long>());
  EXPECT_EQ(check.is_closed(), mesh["is_closed"].get<bool>());
  EXPECT_EQ(check.is_manifold(), mesh["is_manifold"].get<bool>());
  EXPECT_EQ(check.boundary_edges, mesh["boundary_edges"].get<std::size_t>());
  EXPECT_LT(textured.mesh.positions_m.size(), 1.35 * static_cast<double>(check.vertices));
}

TEST_F(Texture, IsTheSameBytesForAnyNumberOfThreads) {
  ASSERT_EQ(run("one.glb", {"--texture", "--threads", "1"}).exit_code, 0);
  EXPECT_EQ(read_text(place("one.glb")), read_text(glb("textured")));
}

TEST_F(Texture, ATurnedAndMovedMeshIsTexturedAllTheSame) {
  const Outcome outcome = run("placed", {"--texture", "--set", "finish.origin=ground"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NEAR(report("placed")["texture"]["seen_share"].get<double>(),
              report("textured")["texture"]["seen_share"].get<double>(), 0.005);
}

TEST_F(Texture, WarnsWhenNoTextureCanBeBakedAndWritesTheMesh) {
  const Outcome outcome = run("refused", {"--texture", "--set", "export.texel_size=0.05mm"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("export.texel_size"), std::string::npos) << outcome.err;
  EXPECT_NE(report("refused")["texture"]["refused"], "");
  EXPECT_EQ(read_text(glb("refused")), read_text(glb("plain")));
}

TEST_F(Texture, OfARecordingWithoutColourThereIsNone) {
  const fs::path grey = place("grey");
  fs::copy(recording(), grey, fs::copy_options::recursive);
  fs::remove_all(grey / "color");
  const Outcome outcome = run("colourless", {"--texture"}, grey.string());
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("none of the frames has colour"), std::string::npos) << outcome.err;
  EXPECT_TRUE(fs::exists(glb("colourless")));
}

TEST_F(Texture, TheProgramReadsItsColours) {
  const Outcome info = scanknit_command({"info", glb("textured").string(), "--json"});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  EXPECT_EQ(Json::parse(info.out)["has_colours"], true);
  EXPECT_EQ(Json::parse(info.out)["warnings"], Json::array());
}

TEST_F(Texture, InfoLooksAwayFromItsSeams) {
  const auto told = [](const fs::path& file) {
    const Outcome info = scanknit_command({"info", file.string(), "--json"});
    EXPECT_EQ(info.exit_code, 0) << info.err;
    return Json::parse(info.out);
  };
  const Json textured = told(glb("textured")), plain = told(glb("plain"));
  for (const char* key : {"triangles", "components", "boundary_edges", "non_manifold_edges", "non_manifold_vertices",
                          "misoriented_edges", "euler", "is_closed", "is_manifold"}) {
    EXPECT_EQ(textured[key], plain[key]) << key;
  }
  EXPECT_GT(textured["seam_vertices"].get<int>(), 0);
  EXPECT_EQ(plain["seam_vertices"], 0);
  EXPECT_EQ(textured["vertices"].get<int>() - textured["seam_vertices"].get<int>(), plain["vertices"].get<int>());
}

TEST_F(Texture, OneThatIsDamagedIsToldByInfo) {
  std::string bytes = read_text(glb("textured"));
  char& inside = bytes.at(bytes.rfind("IDAT") + 8);
  inside = static_cast<char>(inside ^ 1);
  std::ofstream(place("damaged.glb"), std::ios::binary) << bytes;
  const Outcome info = scanknit_command({"info", place("damaged.glb"), "--json"});
  ASSERT_EQ(info.exit_code, 0) << info.err;
  EXPECT_EQ(Json::parse(info.out)["has_colours"], false);
  ASSERT_EQ(Json::parse(info.out)["warnings"].size(), 1u);
}

TEST_F(Texture, TexelsOfTenCentimetresAreCalledThat) {
  const Outcome outcome = run("coarse", {"--texture", "--set", "export.texel_size=10cm"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("texels of 100 mm"), std::string::npos) << outcome.out;
}

TEST_F(Texture, WithoutAGlbThereIsNone) {
  const Outcome outcome = run("model.ply", {"--texture"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("export.texture has no effect"), std::string::npos) << outcome.err;
}

TEST_F(Texture, CommandsWithoutFramesRefuseIt) {
  for (const char* command : {"extract", "align"}) {
    const Outcome outcome =
        scanknit_command({command, recording(), "-o", place("none.glb"), "--set", "export.texture=png"});
    EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
    EXPECT_NE(outcome.err.find("export.texture"), std::string::npos) << outcome.err;
    const Outcome by_option = scanknit_command({command, recording(), "-o", place("none.glb"), "--texture"});
    EXPECT_EQ(by_option.exit_code, 3) << by_option.err;
    EXPECT_EQ(by_option.err, outcome.err);
    EXPECT_EQ(scanknit_command({command, "--help"}).out.find("--texture"), std::string::npos);
  }
}

TEST_F(Texture, ACaptureWithoutARecordingRefusesItBeforeTheScan) {
  const Outcome outcome = scanknit_command({"capture", "-o", place("captured"), "--texture", "--no-recording"});
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_NE(outcome.err.find("have one made"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace scanknit
