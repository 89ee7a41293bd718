// Pictures without depth: their layouts.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/convert/picture_files.h"
#include "acquire/parse/opengl_pose.h"
#include "acquire/pictures/picture_set.h"
#include "tests/acquire/placed_pictures.h"
#include "tests/core/temporary_folder.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

/// The same with TUM's trajectory, of which more is known than pictures are there.
void write_tum_layout(const fs::path& root) {
  ASSERT_NO_FATAL_FAILURE(write_folder_layout(root));
  fs::remove(root / "trajectory.log");
  std::string text = "# time tx ty tz qx qy qz qw\n";
  for (int i = 0; i < kPictures + 2; ++i) {
    const Pose T = pose_of_picture(i);
    const Eigen::Quaterniond q(T.linear());
    text += fmt::format("{}.0 {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\n", i, T.translation().x(),
                        T.translation().y(), T.translation().z(), q.x(), q.y(), q.z(), q.w());
  }
  put_text(root / "trajectory.txt", text);
}

void write_transforms_layout(const fs::path& root) {
  write_pictures(root / "images");
  write_masks(root / "outlines");
  std::string frames;
  for (int i = 0; i < kPictures; ++i) {
    const Eigen::Matrix4d m = opengl_matrix(pose_of_picture(i));
    std::string rows;
    for (int row = 0; row < 4; ++row) {
      rows += fmt::format("{}[{:.17g},{:.17g},{:.17g},{:.17g}]", row == 0 ? "" : ",", m(row, 0), m(row, 1), m(row, 2),
                          m(row, 3));
    }
    frames +=
        fmt::format(R"({}{{"file_path":"images/{:04}.png","mask_path":"outlines/{:04}.png","transform_matrix":[{}]}})",
                    i == 0 ? "" : ",", i, i, rows);
  }
  put_text(root / "transforms.json",
           fmt::format(R"({{"w":64,"h":48,"fl_x":60,"fl_y":61,"cx":32,"cy":24,"frames":[{}]}})", frames));
}

void write_colmap_layout(const fs::path& root) {
  write_pictures(root / "images");
  write_masks(root / "masks");
  put_text(root / "sparse" / "0" / "cameras.txt", "# Camera list\n7 PINHOLE 64 48 60 61 32 24\n");
  std::string images = "# Image list\n";
  for (int i = 0; i < kPictures; ++i) {
    const Pose T = pose_of_picture(i).inverse();
    const Eigen::Quaterniond q(T.linear());
    images += fmt::format("{} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} 7 {:04}.png\n{}\n", i + 1, q.w(),
                          q.x(), q.y(), q.z(), T.translation().x(), T.translation().y(), T.translation().z(), i,
                          i == 1 ? "1.5 2.5 -1 3.5 4.5 12" : "");
  }
  put_text(root / "sparse" / "0" / "images.txt", images);
}

void write_par_layout(const fs::path& root) {
  write_pictures(root);
  write_masks(root / "silhouettes");
  std::string text = fmt::format("{}\n", kPictures);
  for (int i = 0; i < kPictures; ++i) {
    const Pose T = pose_of_picture(i).inverse();
    text += fmt::format("{:04}.png 60 0 31.5 0 61 23.5 0 0 1", i);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) text += fmt::format(" {:.17g}", T.linear()(row, column));
    }
    text += fmt::format(" {:.17g} {:.17g} {:.17g}\n", T.translation().x(), T.translation().y(), T.translation().z());
  }
  put_text(root / "thing_par.txt", text);
}

std::string error_of(const fs::path& path, const AcquireConfig& config = {}) {
  const auto set = open_pictures(path, config);
  return set ? std::string() : set.error().text();
}

struct PictureLayoutCase {
  const char* name;
  void (*write)(const fs::path&);
};
void PrintTo(const PictureLayoutCase& layout, std::ostream* out) {
  *out << layout.name;
}

class PictureLayouts : public ::testing::TestWithParam<PictureLayoutCase> {};

TEST_P(PictureLayouts, SayTheSameCamerasPosesAndMasks) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(GetParam().write(folder.path()));
  const auto set = open_pictures(folder.path(), {});
  ASSERT_TRUE(set) << set.error().text();
  EXPECT_EQ(set->layout, GetParam().name);
  EXPECT_TRUE(set->warnings.empty());
  ASSERT_EQ(set->pictures.size(), static_cast<std::size_t>(kPictures));
  for (int i = 0; i < kPictures; ++i) {
    const PlacedPicture& picture = set->pictures[static_cast<std::size_t>(i)];
    EXPECT_LT((picture.T_world_camera.matrix() - pose_of_picture(i).matrix()).cwiseAbs().maxCoeff(), 1e-12);
    const auto read = read_masked_picture(picture, {}, {}, 1 << 20);
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(read->camera, kPictureCamera);
    EXPECT_EQ(read->colour, picture_of(i));
    EXPECT_EQ(read->mask.at(20, 10), 255);
    EXPECT_EQ(read->mask.at(39 + i, 29), 255);
    EXPECT_EQ(read->mask.at(40 + i, 29), 0);
  }
}

std::string name_of_case(const ::testing::TestParamInfo<PictureLayoutCase>& layout) {
  const std::string name = layout.param.name;
  return name.substr(0, name.find('.'));
}

INSTANTIATE_TEST_SUITE_P(Every, PictureLayouts,
                         ::testing::Values(PictureLayoutCase{"folder", write_folder_layout},
                                           PictureLayoutCase{"tum", write_tum_layout},
                                           PictureLayoutCase{"transforms.json", write_transforms_layout},
                                           PictureLayoutCase{"colmap", write_colmap_layout},
                                           PictureLayoutCase{"par", write_par_layout}),
                         name_of_case);

/// Each text file of a layout, cut at every seventh byte, and with single bytes changed: an error, or pictures whose
/// numbers are finite.
TEST_P(PictureLayouts, SurviveDamagedTexts) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(GetParam().write(folder.path()));
  for (const auto& entry : fs::recursive_directory_iterator(folder.path())) {
    const std::string ending = entry.path().extension().string();
    if (ending != ".txt" && ending != ".json" && ending != ".log") continue;
    std::ifstream in(entry.path(), std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    const auto check = [&](const std::string& text) {
      std::ofstream(entry.path(), std::ios::binary) << text;
      const auto set = open_pictures(folder.path(), {});
      if (!set) {
        EXPECT_FALSE(set.error().message.empty());
        return;
      }
      for (const PlacedPicture& picture : set->pictures) {
        EXPECT_TRUE(is_rigid(picture.T_world_camera));
        EXPECT_TRUE(picture.camera.intrinsics.fx != 0 && std::isfinite(picture.camera.intrinsics.fx));
      }
    };
    for (std::size_t length = 0; length < whole.size(); length += 7) check(whole.substr(0, length));
    for (std::size_t at = 0; at < whole.size(); at += 11) {
      std::string changed = whole;
      changed[at] = static_cast<char>(changed[at] ^ (1 << at % 7));
      check(changed);
    }
    std::ofstream(entry.path(), std::ios::binary) << whole;
  }
}

TEST(PictureSets, AreSeenByTheColourCameraOfAScannersCalibration) {
  ScannerCamera camera{.file = "CAMERA.yaml"};
  camera.colour = CameraModel{{64, 48, 55, 56, 30, 20}, {0.1, 0, 0, 0, 0}};
  camera.depth = CameraModel{{32, 24, 20, 20, 15.5, 11.5}, {}};
  AcquireConfig config;
  config.camera = std::make_shared<const ScannerCamera>(camera);
  for (const auto& write : {write_folder_layout, write_transforms_layout, write_colmap_layout, write_par_layout}) {
    const TemporaryFolder folder;
    ASSERT_NO_FATAL_FAILURE(write(folder.path()));
    const auto set = open_pictures(folder.path(), config);
    ASSERT_TRUE(set) << set.error().text();
    ASSERT_EQ(set->pictures.size(), static_cast<std::size_t>(kPictures));
    for (const PlacedPicture& picture : set->pictures) EXPECT_EQ(picture.camera, *camera.colour);
  }
}

TEST(PictureSets, RefuseACalibrationThatDoesNotStateTheirCameraOnce) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(write_folder_layout(folder.path()));
  const auto refusal = [&](const ScannerCamera& camera, const std::optional<CameraModel>& intrinsics) {
    AcquireConfig config;
    config.intrinsics = intrinsics;
    config.camera = std::make_shared<const ScannerCamera>(camera);
    const auto set = open_pictures(folder.path(), config);
    EXPECT_FALSE(set);
    return set ? Error{} : set.error();
  };
  const CameraModel good{kPictureCamera, {}};
  ScannerCamera camera{.file = "CAMERA.yaml"};
  camera.depth = good;
  Error error = refusal(camera, {});
  EXPECT_EQ(error.code, ErrorCode::kConfig);
  EXPECT_TRUE(contains(error.text(), "CAMERA.yaml: acquire.camera: silhouettes are seen in colour pictures"));
  camera.depth.reset();
  camera.colour = good;
  error = refusal(camera, good);
  EXPECT_EQ(error.code, ErrorCode::kConfig);
  EXPECT_TRUE(contains(error.text(), "both state the pictures' camera")) << error.text();
  camera.colour->distortion[0] = NAN;
  EXPECT_TRUE(contains(refusal(camera, {}).text(), "expected finite numbers"));
}

TEST(PictureSets, LeaveOutPicturesWithoutAPoseOfTheirTime) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(write_tum_layout(folder.path()));
  fs::rename(folder.path() / "color" / "0001.png", folder.path() / "color" / "0001.3.png");
  const auto set = open_pictures(folder.path(), {});
  ASSERT_TRUE(set) << set.error().text();
  EXPECT_EQ(set->pictures.size(), static_cast<std::size_t>(kPictures - 1));
  ASSERT_EQ(set->warnings.size(), 1u);
  EXPECT_TRUE(contains(set->warnings[0], "1 of 4 pictures have no valid pose"));
  put_text(folder.path() / "trajectory.txt", "100 0 0 0 0 0 0 1\n");
  EXPECT_TRUE(contains(error_of(folder.path()), "no picture has a pose"));
}

/// NeRF's synthetic sets: no size, no ending, another name, and masks in alpha.
TEST(PictureSets, AreReadAsNerfPublishedThem) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(write_pictures(folder.path() / "train"));
  put_text(folder.path() / "transforms_train.json",
           R"({"camera_angle_x":1.0,"frames":[{"file_path":"./train/0000","transform_matrix":)"
           R"([[1,0,0,0],[0,1,0,0],[0,0,1,4],[0,0,0,1]]}]})");
  const auto set = open_pictures(folder.path(), {});
  ASSERT_TRUE(set) << set.error().text();
  ASSERT_EQ(set->pictures.size(), 1u);
  EXPECT_EQ(set->pictures[0].picture.filename(), "0000.png");
  const CameraIntrinsics& camera = set->pictures[0].camera.intrinsics;
  EXPECT_EQ(camera.width, 64);
  EXPECT_EQ(camera.height, 48);
  EXPECT_NEAR(camera.fx, 32 / std::tan(0.5), 1e-9);
}

TEST(PictureSets, KeepToTheirFolder) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(write_par_layout(folder.path()));
  std::ifstream in(folder.path() / "thing_par.txt");
  std::string text{std::istreambuf_iterator<char>(in), {}};
  text.replace(text.find("0002.png"), 8, "../0.png");
  put_text(folder.path() / "thing_par.txt", text);
  EXPECT_TRUE(contains(error_of(folder.path()), "thing_par.txt:4")) << error_of(folder.path());
}

TEST(PictureSets, SayWhichLensesAreRead) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(write_colmap_layout(folder.path()));
  put_text(folder.path() / "sparse" / "0" / "cameras.txt", "7 OPENCV_FISHEYE 64 48 60 61 32 24 0 0 0 0\n");
  const std::string error = error_of(folder.path());
  EXPECT_TRUE(contains(error, "OPENCV_FISHEYE is not read")) << error;
  EXPECT_TRUE(contains(error, "cameras.txt:1")) << error;
}

TEST(PictureSets, TakeThoseThatAreAskedFor) {
  const TemporaryFolder folder;
  ASSERT_NO_FATAL_FAILURE(write_folder_layout(folder.path()));
  AcquireConfig config;
  config.from = 1;
  config.every = 2;
  const auto set = open_pictures(folder.path(), config);
  ASSERT_TRUE(set);
  ASSERT_EQ(set->pictures.size(), 2u);
  EXPECT_EQ(set->pictures[0].picture.filename(), "0001.png");
  EXPECT_EQ(set->pictures[1].picture.filename(), "0003.png");
  fs::remove(folder.path() / "color" / "0000.png");
  EXPECT_TRUE(contains(error_of(folder.path()), "3 pictures, but 4 poses"));
}

}  // namespace
}  // namespace scanknit::test
