// Masks of depth recordings that are found in their colour pictures: the difference from an empty picture, and alpha.
#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <variant>

#include "acquire/convert/picture_files.h"
#include "acquire/frame_source.h"
#include "tests/core/temporary_folder.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

constexpr CameraIntrinsics kMaskedCamera{64, 48, 60, 60, 31.5, 23.5};
constexpr Rgb8 kEmptyPlace{40, 40, 40}, kThing{200, 100, 50};

bool is_thing(int x, int y) {
  return x >= 20 && x < 40 && y >= 10 && y < 30;
}

/// Its outermost pixels have no weight: keep_within().
bool is_within_rim(int x, int y) {
  return is_thing(x - 1, y) && is_thing(x + 1, y) && is_thing(x, y - 1) && is_thing(x, y + 1);
}

ColourImage picture_with_thing() {
  ColourImage picture(kMaskedCamera.width, kMaskedCamera.height, kEmptyPlace);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      if (is_thing(x, y)) picture.at(x, y) = kThing;
    }
  }
  return picture;
}

/// One frame, with depth at every pixel.
class FoundMasks : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* part : {"depth", "color"}) fs::create_directories(folder_ / part);
    const Image<std::uint16_t> depth(kMaskedCamera.width, kMaskedCamera.height, 1000);
    ASSERT_TRUE(write_depth_png(depth, folder_ / "depth/000000.png"));
    ASSERT_TRUE(write_colour_png(picture_with_thing(), colour()));
    ASSERT_TRUE(write_camera_json(kMaskedCamera, 1000, folder_ / "camera_intrinsic.json"));
    config_.poses = PoseMode::kStill;
  }
  [[nodiscard]] fs::path colour() const { return folder_ / "color/000000.png"; }

  /// The picture with alpha, 255 where the thing is.
  void give_colour_alpha() const {
    const ColourImage picture = picture_with_thing();
    cv::Mat with_alpha(picture.height(), picture.width(), CV_8UC4);
    for (int y = 0; y < picture.height(); ++y) {
      for (int x = 0; x < picture.width(); ++x) {
        const Rgb8 c = picture.at(x, y);
        with_alpha.at<cv::Vec4b>(y, x) = {c.b, c.g, c.r, static_cast<std::uint8_t>(is_thing(x, y) ? 255 : 0)};
      }
    }
    ASSERT_TRUE(cv::imwrite(colour().string(), with_alpha));
  }
  void write_empty(int width, int height) {
    const fs::path empty = folder_ / "EMPTY.png";
    ASSERT_TRUE(write_colour_png(ColourImage(width, height, kEmptyPlace), empty));
    config_.background = empty.string();
  }

  [[nodiscard]] FrameEvent frame() const {
    auto recording = open_recording(folder_.path(), config_);
    EXPECT_TRUE(recording) << recording.error().text();
    return (*recording)->next({});
  }
  void expect_the_thing_alone() const {
    const FrameEvent event = frame();
    const auto* frame = std::get_if<Frame>(&event);
    ASSERT_NE(frame, nullptr);
    for (int y = 0; y < kMaskedCamera.height; ++y) {
      for (int x = 0; x < kMaskedCamera.width; ++x) {
        ASSERT_EQ(frame->depth_m.at(x, y) > 0, is_within_rim(x, y)) << x << ' ' << y;
      }
    }
  }
  void expect_dropped(const std::string& why) const {
    const FrameEvent event = frame();
    const auto* dropped = std::get_if<FrameDropped>(&event);
    ASSERT_NE(dropped, nullptr);
    EXPECT_NE(dropped->error.message.find(why), std::string::npos) << dropped->error.message;
  }

  TemporaryFolder folder_;
  AcquireConfig config_;
};

TEST_F(FoundMasks, AreWhatDiffersFromTheEmptyPicture) {
  ASSERT_NO_FATAL_FAILURE(write_empty(kMaskedCamera.width, kMaskedCamera.height));
  expect_the_thing_alone();
}

TEST_F(FoundMasks, AreTheAlphaOfThePictures) {
  ASSERT_NO_FATAL_FAILURE(give_colour_alpha());
  config_.masks = "alpha";
  expect_the_thing_alone();
}

TEST_F(FoundMasks, NeedAnEmptyPictureOfTheirSize) {
  ASSERT_NO_FATAL_FAILURE(write_empty(kMaskedCamera.width / 2, kMaskedCamera.height));
  expect_dropped("the empty picture is 32 x 48, this one 64 x 48");
}

TEST_F(FoundMasks, NeedPicturesWithAlpha) {
  config_.masks = "alpha";
  expect_dropped("the picture has no alpha");
}

TEST_F(FoundMasks, NeedColourPictures) {
  ASSERT_NO_FATAL_FAILURE(write_empty(kMaskedCamera.width, kMaskedCamera.height));
  fs::remove(colour());
  expect_dropped("needs a colour picture");
}

TEST_F(FoundMasks, OfAnEmptyPictureThatIsMissingAreAnError) {
  config_.background = (folder_ / "nowhere.png").string();
  const auto recording = open_recording(folder_.path(), config_);
  ASSERT_FALSE(recording);
  EXPECT_NE(recording.error().text().find("nowhere.png"), std::string::npos) << recording.error().text();
}

}  // namespace
}  // namespace scanknit::test
