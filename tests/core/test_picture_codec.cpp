// The pixels and bytes of OpenCV's imdecode and imencode, which recordings were read and written by before: reports,
// meshes and recorded outputs depend on them.
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/picture/decode_picture.h"
#include "core/picture/jpeg_codec.h"
#include "core/picture/jpeg_structure.h"
#include "core/picture/png_codec.h"
#include "core/picture/png_structure.h"
#include "tests/core/picture_samples.h"

namespace scanknit::test {
namespace {

const std::vector<Size> kSizes = {{1, 1},   {2, 1},   {1, 2},  {3, 5},  {7, 8},   {8, 7},
                                  {16, 16}, {17, 15}, {33, 1}, {1, 33}, {64, 48}, {101, 67}};

cv::Mat opencv_decoded(std::span<const std::byte> bytes, int flags) {
  try {
    const auto* data = reinterpret_cast<const uchar*>(bytes.data());
    return cv::imdecode(std::vector<uchar>(data, data + bytes.size()), flags | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};
  }
}

/// What decode_picture is to give: empty when it is to refuse the file.
ColourImage opencv_picture(std::span<const std::byte> bytes) {
  cv::Mat bgr;
  if (looks_like_jpeg(bytes)) {
    const auto header = check_jpeg(bytes, {});
    if (header) bgr = opencv_decoded(bytes, cv::IMREAD_COLOR);
    if (header && (bgr.cols != header->width || bgr.rows != header->height)) return {};
  } else if (const auto file = check_png(bytes, {})) {
    bgr = opencv_decoded(file->critical, cv::IMREAD_COLOR);
  }
  ColourImage image(bgr.cols, bgr.rows);
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) {
      const auto& pixel = bgr.at<cv::Vec3b>(y, x);
      image.at(x, y) = {pixel[2], pixel[1], pixel[0]};
    }
  }
  return image;
}

struct Counts {
  int accepted = 0;
  int refused = 0;
};

/// Decodes all of `files` by OpenCV and by decode_picture, which also must not print.
Counts expect_opencvs_pixels(const std::vector<Bytes>& files, const std::string& what) {
  testing::internal::CaptureStderr();  // of libjpeg's warnings
  std::vector<ColourImage> expected;
  for (const Bytes& file : files) expected.push_back(opencv_picture(file));
  testing::internal::GetCapturedStderr();
  testing::internal::CaptureStderr();
  std::vector<ColourImage> seen;
  for (const Bytes& file : files) {
    auto image = decode_picture(file, {});
    seen.push_back(image ? *std::move(image) : ColourImage());
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "") << what;
  Counts counts;
  for (std::size_t i = 0; i < files.size(); ++i) {
    ++(expected[i].empty() ? counts.refused : counts.accepted);
    EXPECT_EQ(seen[i].width(), expected[i].width()) << what << ", file " << i;
    EXPECT_TRUE(seen[i] == expected[i]) << what << ", file " << i;
  }
  return counts;
}

template <typename T>
void expect_opencvs_grey(const Bytes& bytes, const std::string& what) {
  const auto file = check_png(bytes, {});
  ASSERT_TRUE(file) << what;
  const auto image = decode_png_grey<T>(*file);
  const cv::Mat expected = opencv_decoded(file->critical, cv::IMREAD_UNCHANGED);
  ASSERT_TRUE(image) << what;
  ASSERT_EQ(expected.type(), cv::traits::Type<T>::value) << what;
  ASSERT_EQ(image->width(), expected.cols) << what;
  ASSERT_EQ(image->height(), expected.rows) << what;
  for (int y = 0; y < expected.rows; ++y) {
    EXPECT_TRUE(std::equal(image->row(y).begin(), image->row(y).end(), expected.ptr<T>(y))) << what << ", row " << y;
  }
}

/// Copies of `file` with one to three bytes of those from `begin` on changed.
std::vector<Bytes> damaged(const Bytes& file, std::size_t begin, int count, std::mt19937& random) {
  std::vector<Bytes> copies;
  std::uniform_int_distribution<std::size_t> place(begin, file.size() - 1);
  for (int i = 0; i < count; ++i) {
    Bytes copy = file;
    for (int flips = 1 + i % 3; flips > 0; --flips) copy[place(random)] ^= static_cast<std::byte>(1 + random() % 255);
    copies.push_back(std::move(copy));
  }
  return copies;
}

TEST(PngDecoder, GivesOpenCvsPixelsForEveryKind) {
  std::mt19937 random(1);
  for (const PngKind& kind : all_png_kinds()) {
    std::vector<Bytes> files;
    for (const Size size : kSizes) files.push_back(png_file(kind, size, random));
    EXPECT_EQ(expect_opencvs_pixels(files, name_of(kind)).refused, 0);
  }
}

TEST(PngDecoder, GivesOpenCvsGreyOfEightAndSixteenBits) {
  std::mt19937 random(2);
  for (const PngKind& kind : all_png_kinds()) {
    if (kind.colour_type != 0 || kind.bit_depth < 8) continue;
    for (const Size size : kSizes) {
      const Bytes file = png_file(kind, size, random);
      if (kind.bit_depth == 8) expect_opencvs_grey<std::uint8_t>(file, name_of(kind));
      if (kind.bit_depth == 16) expect_opencvs_grey<std::uint16_t>(file, name_of(kind));
    }
  }
}

TEST(PngDecoder, AcceptsOfDamagedFilesWhatOpenCvDoes) {
  std::mt19937 random(3);
  Counts all;
  for (const PngKind& kind : all_png_kinds()) {
    const Bytes file = png_file(kind, {19, 13}, random);
    std::vector<Bytes> files = damaged(file, 8, 150, random);
    for (Bytes& copy : files) repair_crcs(copy);
    const Counts counts = expect_opencvs_pixels(files, name_of(kind));
    all.accepted += counts.accepted;
    all.refused += counts.refused;
  }
  EXPECT_GT(all.accepted, 100);
  EXPECT_GT(all.refused, 100);
}

TEST(PngDecoder, RefusesPictureDataThatEndEarly) {
  std::mt19937 random(4);
  const Bytes file = png_file({.colour_type = 2, .bit_depth = 8}, {16, 16}, random);
  constexpr std::size_t kDataAt = 8 + 25;  // the signature and IHDR; then IDAT, then IEND of 12 bytes
  const std::size_t length = file.size() - kDataAt - 12 - 12;
  std::vector<Bytes> files;
  for (std::size_t cut = 1; cut < length; ++cut) {
    Bytes copy = file;
    const auto end = copy.end() - 12 - 4;
    copy.erase(end - static_cast<std::ptrdiff_t>(cut), end);
    for (std::size_t i = 0; i < 4; ++i)
      copy[kDataAt + i] = static_cast<std::byte>((length - cut) >> (24 - 8 * i) & 0xFF);
    repair_crcs(copy);
    ASSERT_TRUE(check_png(copy, {}));
    files.push_back(std::move(copy));
  }
  EXPECT_GT(expect_opencvs_pixels(files, "cut PNG").refused, static_cast<int>(length) / 2);
}

TEST(JpegDecoder, GivesOpenCvsPixelsForEveryKind) {
  std::mt19937 random(5);
  for (const JpegKind& kind : all_jpeg_kinds()) {
    std::vector<Bytes> files;
    for (const Size size : kSizes) {
      for (const int quality : {5, 75, 95, 100}) {
        for (const bool is_smooth : {false, true}) files.push_back(jpeg_file(kind, size, quality, is_smooth, random));
      }
    }
    const Counts counts = expect_opencvs_pixels(files, kind.name);
    EXPECT_EQ(kind.components == 2 ? counts.accepted : counts.refused, 0) << kind.name;
  }
}

TEST(JpegDecoder, GivesOpenCvsPixelsWithoutHuffmanTables) {
  std::mt19937 random(6);
  for (const JpegKind& kind : all_jpeg_kinds()) {
    std::vector<Bytes> files;
    for (const Size size : kSizes) files.push_back(without_huffman_tables(jpeg_file(kind, size, 90, true, random)));
    const Counts counts = expect_opencvs_pixels(files, kind.name);
    const bool is_as_cameras_send = kind.name == "4:2:2";
    EXPECT_TRUE(!is_as_cameras_send || counts.refused == 0);
  }
}

TEST(JpegDecoder, AcceptsOfDamagedFilesWhatOpenCvDoes) {
  std::mt19937 random(7);
  Counts all;
  for (const JpegKind& kind : all_jpeg_kinds()) {
    const Bytes file = jpeg_file(kind, {37, 29}, 80, true, random);
    const Counts counts = expect_opencvs_pixels(damaged(file, 2, 500, random), kind.name);
    all.accepted += counts.accepted;
    all.refused += counts.refused;
  }
  EXPECT_GT(all.accepted, 1000);
  EXPECT_GT(all.refused, 1000);
}

TEST(JpegDecoder, GivesOpenCvsPixelsForFilesThatEndEarly) {
  std::mt19937 random(8);
  for (const JpegKind& kind : all_jpeg_kinds()) {
    const Bytes file = jpeg_file(kind, {37, 29}, 80, false, random);
    std::vector<Bytes> files;
    for (std::size_t size = 2; size < file.size(); size += 1 + file.size() / 500) {
      files.emplace_back(file.begin(), file.begin() + static_cast<std::ptrdiff_t>(size));
      files.push_back(files.back());
      files.back().insert(files.back().end(), {std::byte{0xFF}, std::byte{0xD9}});  // an end that check_jpeg accepts
    }
    EXPECT_GT(expect_opencvs_pixels(files, kind.name).refused, 0) << kind.name;
  }
}

std::vector<std::uint8_t> opencv_encoded(const cv::Mat& picture, const char* extension,
                                         const std::vector<int>& options) {
  std::vector<uchar> bytes;
  EXPECT_TRUE(cv::imencode(extension, picture, bytes, options));
  return bytes;
}

cv::Mat bgr_of(const ColourImage& image) {
  cv::Mat bgr(image.height(), image.width(), CV_8UC3);
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) {
      const Rgb8 c = image.at(x, y);
      bgr.at<cv::Vec3b>(y, x) = {c.b, c.g, c.r};
    }
  }
  return bgr;
}

const std::vector<std::pair<PngEffort, std::vector<int>>> kEfforts = {
    {PngEffort::kFast, {}},
    {PngEffort::kMedium, {cv::IMWRITE_PNG_COMPRESSION, 3}},
    {PngEffort::kSmall, {cv::IMWRITE_PNG_COMPRESSION, 6}},
};

std::vector<Size> sizes_to_encode() {
  std::vector<Size> sizes = kSizes;
  sizes.push_back({640, 480});
  return sizes;
}

TEST(PngEncoder, WritesOpenCvsBytes) {
  std::mt19937 random(9);
  for (const Size size : sizes_to_encode()) {
    for (const bool is_smooth : {false, true}) {
      const auto colour = colour_sample(size, is_smooth, random);
      auto depth = depth_sample(size, is_smooth, random);
      const cv::Mat raw(depth.height(), depth.width(), CV_16UC1, depth.pixels().data());
      for (const auto& [effort, options] : kEfforts) {
        EXPECT_EQ(*encode_png(colour, effort), opencv_encoded(bgr_of(colour), ".png", options)) << size.width;
        EXPECT_EQ(*encode_png(depth, effort), opencv_encoded(raw, ".png", options)) << size.width;
      }
    }
  }
}

TEST(JpegEncoder, WritesOpenCvsBytes) {
  std::mt19937 random(10);
  for (const Size size : sizes_to_encode()) {
    for (const bool is_smooth : {false, true}) {
      const auto colour = colour_sample(size, is_smooth, random);
      for (const int quality : {0, 1, 50, 80, 85, 92, 95, 100}) {
        EXPECT_EQ(*encode_jpeg(colour, quality),
                  opencv_encoded(bgr_of(colour), ".jpg", {cv::IMWRITE_JPEG_QUALITY, quality}))
            << size.width << " x " << size.height << ", quality " << quality;
      }
    }
  }
}

TEST(PictureEncoders, RefuseWhatTheirFormatsCannotHold) {
  EXPECT_EQ(encode_jpeg(ColourImage(), 90).error().code, ErrorCode::kOutput);
  EXPECT_EQ(encode_png(ColourImage(), PngEffort::kFast).error().code, ErrorCode::kOutput);
  EXPECT_EQ(encode_jpeg(ColourImage(65501, 1), 90).error().message, "the picture could not be encoded as JPEG");
  EXPECT_EQ(encode_png(ColourImage(1'000'001, 1), PngEffort::kFast).error().message,
            "the picture could not be encoded as PNG");
}

}  // namespace
}  // namespace scanknit::test
