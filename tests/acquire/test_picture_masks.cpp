// The masks of pictures without depth, and of frames.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "acquire/convert/picture_files.h"
#include "acquire/frame_source.h"
#include "acquire/masks/frame_mask.h"
#include "acquire/pictures/picture_set.h"
#include "tests/acquire/placed_pictures.h"
#include "tests/core/temporary_folder.h"
#include "tests/support/text.h"

namespace scanknit::test {
namespace {

class PictureMasks : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NO_FATAL_FAILURE(write_folder_layout(folder_.path()));
    fs::remove_all(folder_.path() / "masks");
  }
  [[nodiscard]] Result<MaskedPicture> first(const AcquireConfig& config = {}, std::size_t most_pixels = 1 << 20) const {
    const auto set = open_pictures(folder_.path(), config);
    if (!set) return set.error();
    const auto empty = read_empty_picture(config);
    if (!empty) return empty.error();
    return read_masked_picture(set->pictures[0], *empty, config, most_pixels);
  }
  [[nodiscard]] std::string refused(const AcquireConfig& config = {}) const {
    const auto read = first(config);
    return read ? std::string() : read.error().text();
  }
  void write_mask(const ColourImage& mask, const char* name = "0000.png") const {
    fs::create_directories(folder_.path() / "masks");
    ASSERT_TRUE(write_colour_png(mask, folder_.path() / "masks" / name));
  }
  [[nodiscard]] const fs::path& path() const { return folder_.path(); }

 private:
  TemporaryFolder folder_;
};

TEST_F(PictureMasks, AreNeeded) {
  EXPECT_TRUE(contains(refused(), "no mask of this picture"));
}

TEST_F(PictureMasks, AreFoundByTheWholeNameToo) {
  write_mask(mask_picture(0), "0000.png.png");
  EXPECT_TRUE(first());
}

TEST_F(PictureMasks, OfAClass) {
  write_mask(mask_picture(0, 3));
  AcquireConfig config;
  config.mask_class = 3;
  const auto read = first(config);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->mask.at(25, 20), 255);
  EXPECT_EQ(read->mask.at(0, 0), 0);
  config.mask_class = 4;
  EXPECT_TRUE(contains(refused(config), "the mask is empty"));
}

TEST_F(PictureMasks, AreRefusedIfTheyAreNone) {
  write_mask(ColourImage(64, 48));
  EXPECT_TRUE(contains(refused(), "the mask is empty"));
  write_mask(ColourImage(64, 48, Rgb8{255, 255, 255}));
  EXPECT_TRUE(contains(refused(), "white all over"));
  ColourImage inverted = mask_picture(0);
  for (Rgb8& pixel : inverted.pixels()) pixel = pixel.r == 0 ? Rgb8{255, 255, 255} : Rgb8{};
  write_mask(inverted);
  EXPECT_TRUE(contains(refused(), "inverted"));
  write_mask(ColourImage(32, 24, Rgb8{255, 255, 255}));
  EXPECT_TRUE(contains(refused(), "the mask is 32 x 24, the picture 64 x 48"));
  put_text(path() / "masks" / "0000.png", "no picture");
  EXPECT_TRUE(contains(refused(), "0000.png"));
}

TEST_F(PictureMasks, AreTheDifferenceFromAnEmptyPicture) {
  ASSERT_TRUE(write_colour_png(ColourImage(64, 48, Rgb8{44, 38, 41}), path() / "empty.png"));
  AcquireConfig config;
  config.background = (path() / "empty.png").string();
  const auto read = first(config);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->mask.at(25, 20), 255);
  EXPECT_EQ(read->mask.at(0, 0), 0);
  ASSERT_TRUE(write_colour_png(ColourImage(32, 48, Rgb8{44, 38, 41}), path() / "empty.png"));
  EXPECT_TRUE(contains(refused(config), "the empty picture is 32 x 48, this one 64 x 48"));
}

/// A green screen that is lit from one side, with noise, behind a thing of other colours, one of them green's
/// neighbour.
TEST_F(PictureMasks, AreWhatIsNotOfTheScreen) {
  ColourImage picture(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const int light = 60 + 3 * x + (7 * x + 13 * y) % 5;
      const auto part = [&](int share) { return static_cast<std::uint8_t>(light * share / 255); };
      picture.at(x, y) = {part(40), part(200), part(70)};
    }
  }
  constexpr std::array kColours = {Rgb8{200, 100, 50}, Rgb8{30, 40, 160},   Rgb8{128, 128, 128},
                                   Rgb8{8, 9, 8},      Rgb8{240, 240, 235}, Rgb8{190, 180, 40}};
  for (std::size_t i = 0; i < kColours.size(); ++i) {
    for (int y = 10; y < 30; ++y) {
      for (int x = 5; x < 10; ++x) picture.at(x + 9 * static_cast<int>(i), y) = kColours[i];
    }
  }
  ASSERT_TRUE(write_colour_png(picture, path() / "color" / "0000.png"));
  AcquireConfig config;
  config.masks = kChromaMasks;
  const auto read = first(config);
  ASSERT_TRUE(read) << read.error().text();
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) {
      const bool is_thing = y >= 10 && y < 30 && x >= 5 && x < 59 && (x - 5) % 9 < 5;
      EXPECT_EQ(read->mask.at(x, y), is_thing ? 255 : 0) << x << ", " << y;
    }
  }
  ASSERT_TRUE(write_colour_png(picture_of(0), path() / "color" / "0000.png"));
  EXPECT_TRUE(contains(refused(config), "not of one strong colour"));
}

/// A striped thing on a table of another colour, both with noise and under light that falls off: to two pixels of its
/// outline, in all but a thousandth of the pixels.
TEST_F(PictureMasks, AreWhatGrabCutCutsOut) {
  constexpr int kWidth = 160, kHeight = 120;
  const auto is_thing = [](int x, int y) { return std::hypot((x - 85) / 40.0, (y - 58) / 30.0) < 1; };
  ColourImage picture(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int light = 190 + x / 4 + (7 * x + 13 * y) % 11;
      const auto part = [&](int share) { return static_cast<std::uint8_t>(light * share / 255); };
      picture.at(x, y) = !is_thing(x, y) ? Rgb8{part(170), part(150), part(120)}
                         : x / 6 % 2 > 0 ? Rgb8{part(40), part(60), part(150)}
                                         : Rgb8{part(30), part(40), part(70)};
    }
  }
  ASSERT_TRUE(write_colour_png(picture, path() / "color" / "0000.png"));
  AcquireConfig config;
  config.masks = kGrabCutMasks;
  config.intrinsics = CameraModel{{kWidth, kHeight, 150, 150, 79.5, 59.5}, {}};
  const auto read = first(config);
  ASSERT_TRUE(read) << read.error().text();
  int wrong = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double out = std::hypot((x - 85) / 40.0, (y - 58) / 30.0);
      if (std::abs(out - 1) * 30 > 2 && (read->mask.at(x, y) >= 128) != is_thing(x, y)) ++wrong;
    }
  }
  EXPECT_LE(wrong, kWidth * kHeight / 1000);
  const auto again = first(config);
  ASSERT_TRUE(again);
  EXPECT_TRUE(std::equal(read->mask.pixels().begin(), read->mask.pixels().end(), again->mask.pixels().begin()));
}

TEST_F(PictureMasks, AreThePicturesOwnAlpha) {
  cv::Mat picture(48, 64, CV_8UC4, cv::Scalar(50, 100, 200, 0));
  picture(cv::Rect(20, 10, 20, 20)).setTo(cv::Scalar(50, 100, 200, 255));
  picture(cv::Rect(40, 10, 1, 20)).setTo(cv::Scalar(50, 100, 200, 77));
  ASSERT_TRUE(cv::imwrite((path() / "color" / "0000.png").string(), picture));
  const auto read = first();
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->mask.at(20, 10), 255);
  EXPECT_EQ(read->mask.at(40, 29), 77);
  EXPECT_EQ(read->mask.at(41, 29), 0);
  EXPECT_EQ(read->colour.at(30, 20), (Rgb8{200, 100, 50}));
}

TEST_F(PictureMasks, AreMadeSmallerWithTheirPicture) {
  write_mask(mask_picture(0));
  const auto read = first({}, 64 * 48 / 4);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->mask.width(), 32);
  EXPECT_EQ(read->colour.height(), 24);
  EXPECT_EQ(read->camera, (CameraIntrinsics{32, 24, 30, 30.5, 15.5, 11.5}));
  EXPECT_EQ(read->mask.at(12, 8), 255);
  EXPECT_EQ(read->colour.at(12, 8), (Rgb8{200, 100, 50}));
}

/// The same folder with depth.
class MaskedDepth : public PictureMasks {
 protected:
  void SetUp() override {
    ASSERT_NO_FATAL_FAILURE(PictureMasks::SetUp());
    fs::create_directories(path() / "depth");
    for (int i = 0; i < kPictures; ++i) {
      const Image<std::uint16_t> depth(kPictureCamera.width, kPictureCamera.height, 1500);
      ASSERT_TRUE(write_depth_png(depth, path() / "depth" / fmt::format("{:04}.png", i)));
    }
    config_.masks = "masks";
  }
  [[nodiscard]] FrameEvent first_frame() const {
    const auto source = open_recording(path(), config_);
    if (!source) return source.error();
    return (*source)->next({});
  }
  [[nodiscard]] std::string warnings() const {
    const auto source = open_recording(path(), config_);
    std::string text;
    if (source) {
      for (const std::string& warning : (*source)->info().warnings) text += warning + "\n";
    }
    return text;
  }
  AcquireConfig config_;
};

TEST_F(MaskedDepth, IsLeftWithinTheMaskAndItsRim) {
  write_mask(mask_picture(0));
  const FrameEvent event = first_frame();
  const auto* frame = std::get_if<Frame>(&event);
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->sequence, 0u);
  for (int y = 0; y < kPictureCamera.height; ++y) {
    for (int x = 0; x < kPictureCamera.width; ++x) {
      const bool is_within = x >= 21 && x < 39 && y >= 11 && y < 29;
      ASSERT_EQ(frame->depth_m.at(x, y), is_within ? 1.5f : 0) << x << ' ' << y;
    }
  }
}

TEST_F(MaskedDepth, TakesAMaskOfAnotherSizeAndOfAClass) {
  ColourImage half(32, 24);
  for (int y = 5; y < 15; ++y) {
    for (int x = 10; x < 20; ++x) half.at(x, y) = Rgb8{7, 7, 7};
  }
  write_mask(half);
  config_.mask_class = 7;
  const FrameEvent event = first_frame();
  const auto* frame = std::get_if<Frame>(&event);
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->depth_m.at(21, 11), 1.5f);
  EXPECT_EQ(frame->depth_m.at(38, 28), 1.5f);
  EXPECT_EQ(frame->depth_m.at(19, 20), 0);
  EXPECT_EQ(frame->depth_m.at(40, 20), 0);
}

TEST_F(MaskedDepth, CountsLessNearTheRim) {
  write_mask(mask_picture(0));
  const FrameEvent event = first_frame();
  const auto* frame = std::get_if<Frame>(&event);
  ASSERT_NE(frame, nullptr);
  EXPECT_TRUE(frame->outside_m.empty());
  EXPECT_TRUE(frame->labels.empty());
  const std::array expected = {0, 0, 16, 64, 143, 255, 255};
  for (int x = 19; x < 26; ++x) {
    EXPECT_EQ(frame->weights.at(x, 20), expected[static_cast<std::size_t>(x - 19)]) << x;
    EXPECT_EQ(frame->weights.at(59 - x, 20), expected[static_cast<std::size_t>(x - 19)]) << 59 - x;
  }
  EXPECT_EQ(frame->weights.at(30, 11), 16);
  EXPECT_EQ(frame->weights.at(30, 28), 16);
}

TEST_F(MaskedDepth, OutsideIsKeptApartWhereItMeansFreeSpace) {
  write_mask(mask_picture(0));
  config_.mask_means = MaskMeans::kFree;
  const FrameEvent event = first_frame();
  const auto* frame = std::get_if<Frame>(&event);
  ASSERT_NE(frame, nullptr);
  for (int y = 0; y < kPictureCamera.height; ++y) {
    for (int x = 0; x < kPictureCamera.width; ++x) {
      ASSERT_EQ(frame->depth_m.at(x, y) + frame->outside_m.at(x, y), 1.5f) << x << ' ' << y;
    }
  }
  EXPECT_EQ(frame->depth_m.at(30, 20), 1.5f);
  EXPECT_EQ(frame->outside_m.at(5, 5), 1.5f);
}

TEST_F(MaskedDepth, StaysWholeWithItsLabels) {
  write_mask(mask_picture(0, 3));
  config_.keeps_labels = true;
  const FrameEvent event = first_frame();
  const auto* frame = std::get_if<Frame>(&event);
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->depth_m.at(0, 0), 1.5f);
  EXPECT_TRUE(frame->weights.empty());
  EXPECT_EQ(frame->labels.at(0, 0), 0);
  EXPECT_EQ(frame->labels.at(30, 20), 3);
  const Frame part = frame_of_class(*frame, 3, MaskMeans::kUnknown);
  EXPECT_EQ(part.depth_m.at(30, 20), 1.5f);
  EXPECT_EQ(part.depth_m.at(20, 20), 0);
  EXPECT_EQ(part.weights.at(30, 20), 255);
  EXPECT_EQ(frame_of_class(*frame, 4, MaskMeans::kUnknown).depth_m.at(30, 20), 0);
}

TEST_F(MaskedDepth, TakesLabelsNamedAsLabelFusionNamesThem) {
  fs::rename(path() / "depth/0000.png", path() / "depth/0000_depth.png");
  write_mask(mask_picture(0, 3), "0000_labels.png");
  config_.mask_class = 3;
  const FrameEvent event = first_frame();
  const auto* frame = std::get_if<Frame>(&event);
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->depth_m.at(30, 20), 1.5f);
  EXPECT_EQ(frame->depth_m.at(0, 0), 0);
  EXPECT_EQ(find_mask(path() / "masks", "0000_rgb.png"), path() / "masks" / "0000_labels.png");
  EXPECT_TRUE(find_mask(path() / "masks", "0000_color.png").empty());
}

TEST_F(MaskedDepth, TakesOneMaskOfEachThingAsBopHasThem) {
  ColourImage other(64, 48);
  other.at(5, 5) = Rgb8{255, 255, 255};
  write_mask(mask_picture(0), "0000_000000.png");
  write_mask(other, "0000_000001.png");
  config_.keeps_labels = true;
  const FrameEvent event = first_frame();
  const auto* frame = std::get_if<Frame>(&event);
  ASSERT_NE(frame, nullptr);
  EXPECT_EQ(frame->labels.at(30, 20), 1);
  EXPECT_EQ(frame->labels.at(5, 5), 2);
  EXPECT_EQ(frame->labels.at(0, 0), 0);
  for (const auto& [label, is_in] : {std::pair{std::optional<int>(), true}, {1, true}, {2, false}}) {
    config_.keeps_labels = false;
    config_.mask_class = label;
    const FrameEvent masked = first_frame();
    const auto* part = std::get_if<Frame>(&masked);
    if (part == nullptr) {
      EXPECT_FALSE(is_in);
      continue;
    }
    EXPECT_EQ(part->depth_m.at(30, 20) > 0, is_in);
  }
  write_mask(ColourImage(20, 20), "0000_000001.png");
  const FrameEvent wrong = first_frame();
  const auto* dropped = std::get_if<FrameDropped>(&wrong);
  ASSERT_NE(dropped, nullptr);
  EXPECT_TRUE(contains(dropped->error.text(), "another size")) << dropped->error.text();
}

/// Of the whole recording: two masks have each fault.
TEST_F(MaskedDepth, WarnsOnceOfFaultyMasks) {
  const auto write_both = [&](const ColourImage& mask) {
    write_mask(mask, "0000.png");
    write_mask(mask, "0001.png");
  };
  const auto warned_once = [&](const std::string& words) {
    const std::string text = warnings();
    const std::size_t first = text.find(words);
    return first != std::string::npos && text.find(words, first + 1) == std::string::npos && contains(text, "0000.png");
  };
  write_both(mask_picture(0));
  EXPECT_EQ(warnings(), "");
  write_both(ColourImage(64, 48));
  EXPECT_TRUE(warned_once("the mask is empty")) << warnings();
  write_both(ColourImage(64, 48, Rgb8{255, 255, 255}));
  EXPECT_TRUE(warned_once("nothing is left out")) << warnings();
  ColourImage inverted = mask_picture(0);
  for (Rgb8& pixel : inverted.pixels()) pixel = pixel.r == 0 ? Rgb8{255, 255, 255} : Rgb8{};
  write_both(inverted);
  EXPECT_TRUE(warned_once("most likely inverted")) << warnings();
  ColourImage square(48, 48);
  square.at(20, 20) = Rgb8{255, 255, 255};
  write_both(square);
  EXPECT_TRUE(warned_once("48 x 48 instead of 64 x 48")) << warnings();
  write_both(mask_picture(0, 3));
  config_.mask_class = 4;
  EXPECT_TRUE(warned_once("no pixel of the mask is 4 (acquire.mask_class)")) << warnings();
  EXPECT_TRUE(contains(warnings(), "its values are 0, 3")) << warnings();
}

TEST_F(MaskedDepth, DropsAFrameWithoutAMask) {
  write_mask(mask_picture(1), "0001.png");
  const FrameEvent event = first_frame();
  const auto* dropped = std::get_if<FrameDropped>(&event);
  ASSERT_NE(dropped, nullptr);
  EXPECT_EQ(dropped->reason, DropReason::kMissingFile);
  EXPECT_TRUE(contains(dropped->error.message, "no mask of this frame")) << dropped->error.message;
}

}  // namespace
}  // namespace scanknit::test
