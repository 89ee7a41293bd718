// Raw samples and stacks of images.
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "extract/volume/natural_order.h"
#include "written_volume.h"

namespace scanknit {
namespace {

VolumeOptions raw_options(SampleType type, ByteOrder order = ByteOrder::kLittle) {
  VolumeOptions options;
  options.dims = kDims;
  options.type = type;
  options.byte_order = order;
  options.spacing = Eigen::Vector3d(0.5, 1, 2);
  return options;
}

TEST(RawSamples, ReadsEveryTypeInBothByteOrders) {
  const TemporaryFolder folder;
  for (const SampleType type : kAllTypes) {
    for (const ByteOrder order : kBothOrders) {
      const auto path = folder.write("a b.dat", "head" + sample_bytes(type, order));
      VolumeOptions options = raw_options(type, order);
      options.header_bytes = 4;
      const auto volume = read_file_volume(path, options);
      expect_test_volume(volume);
      EXPECT_TRUE(volume->header.T_file_index.linear().diagonal().isApprox(*options.spacing));
    }
  }
}

TEST(RawSamples, RefusesAnySizeThatIsNotTheFiles) {
  const TemporaryFolder folder;
  const auto path = folder.write("a.raw", sample_bytes());
  for (const Eigen::Vector3i& dims :
       {Eigen::Vector3i(4, 3, 3), Eigen::Vector3i(3, 3, 2), Eigen::Vector3i(4, 3, 1), Eigen::Vector3i(-4, -3, 2),
        Eigen::Vector3i(2147483647, 2147483647, 2147483647)}) {
    VolumeOptions options = raw_options(SampleType::kInt16);
    options.dims = dims;
    expect_error(read_file_volume(path, options), ErrorCode::kInput, "samples");
  }
  VolumeOptions options = raw_options(SampleType::kInt16);
  options.header_bytes = ~std::uint64_t{0};
  expect_error(read_file_volume(path, options), ErrorCode::kInput, "the file has");
}

TEST(RawSamples, AsksForWhatIsMissing) {
  const TemporaryFolder folder;
  const auto path = folder.write("a.raw", sample_bytes());
  VolumeOptions options = raw_options(SampleType::kInt16);
  options.spacing.reset();
  expect_error(read_file_volume(path, options), ErrorCode::kUsage, "spacing");
  expect_error(read_file_volume(path), ErrorCode::kInput, "raw samples with their dims");
}

TEST(RawSamples, AreNeverInfinite) {
  const TemporaryFolder folder;
  std::string bytes;
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double value : {1e300, -1e300, infinity, -infinity, std::nan(""), 0.1, 16777217.0, -3.4e38})
    append(bytes, value);
  VolumeOptions options = raw_options(SampleType::kDouble);
  options.dims = {2, 2, 2};
  const auto volume = read_file_volume(folder.write("a.raw", bytes), options);
  ASSERT_TRUE(volume.has_value()) << volume.error().text();
  for (std::size_t n = 0; n < 5; ++n) EXPECT_TRUE(std::isnan(volume->samples[n])) << n;
  EXPECT_EQ(volume->samples[5], 0.1f);
  EXPECT_EQ(volume->samples[6], 16777216.0f);
  EXPECT_EQ(volume->samples[7], -3.4e38f);
}

TEST(RawSamples, WarnOfTypesThatFloatsCannotHold) {
  const TemporaryFolder folder;
  for (const SampleType type : kAllTypes) {
    const auto volume = read_file_volume(folder.write("a.raw", sample_bytes(type)), raw_options(type));
    ASSERT_TRUE(volume.has_value()) << volume.error().text();
    const bool is_wide = bytes_per_sample(type) > 2 && type != SampleType::kFloat;
    ASSERT_EQ(volume->header.warnings.size(), is_wide ? 1u : 0u) << sample_type_name(type);
    if (!is_wide) continue;
    const std::string& warning = volume->header.warnings[0];
    EXPECT_TRUE(warning.starts_with("samples of " + volume->header.sample_type + " become 32-bit floats")) << warning;
  }
}

TEST(RawSamples, NoticesThatTheFileShrank) {
  const TemporaryFolder folder;
  const auto path = folder.write("a.raw", sample_bytes());
  auto reader = open_volume(path, raw_options(SampleType::kInt16));
  ASSERT_TRUE(reader.has_value());
  std::filesystem::resize_file(path, 40);
  expect_error(read_volume(**reader), ErrorCode::kInput, "slice 1");
}

TEST(ReadVolume, RefusesMoreThanTheBudget) {
  const TemporaryFolder folder;
  auto reader = open_volume(folder.write("a.raw", sample_bytes()), raw_options(SampleType::kInt16));
  ASSERT_TRUE(reader.has_value());
  expect_error(read_volume(**reader, 95), ErrorCode::kBudget, "needs 96 bytes");
  EXPECT_TRUE(read_volume(**reader, 96).has_value());
}

TEST(OpenVolume, RefusesWhatIsNoVolume) {
  const TemporaryFolder folder;
  expect_error(read_file_volume(folder.path() / "gone.nrrd"), ErrorCode::kInput, "no such file");
  expect_error(read_file_volume(folder.path()), ErrorCode::kInput, "no PNG, TIFF or DICOM");
  expect_error(read_file_volume(folder.write("a.nrrd", "")), ErrorCode::kInput, "not NRRD");
  expect_error(read_file_volume(folder.write("a.txt", "hello")), ErrorCode::kInput, "unknown format");
  expect_error(read_file_volume("/dev/zero"), ErrorCode::kInput, "neither a file");
}

TEST(NaturalOrder, CountsNumbers) {
  EXPECT_TRUE(is_naturally_before("slice_2.png", "slice_10.png"));
  EXPECT_FALSE(is_naturally_before("slice_10.png", "slice_2.png"));
  EXPECT_TRUE(is_naturally_before("a9", "a99999999999999999999999999"));
  EXPECT_TRUE(is_naturally_before("a2b10", "a2b11"));
  EXPECT_TRUE(is_naturally_before("a", "a1"));
  EXPECT_NE(is_naturally_before("a01", "a1"), is_naturally_before("a1", "a01"));
  EXPECT_FALSE(is_naturally_before("a1", "a1"));
}

VolumeOptions stack_options() {
  VolumeOptions options;
  options.spacing = Eigen::Vector3d(1, 1, 3);
  return options;
}

template <typename Pixel>
void write_image(const std::filesystem::path& path, float offset) {
  cv::Mat_<Pixel> image(3, 4);
  for (int n = 0; n < 12; ++n) image(n / 4, n % 4) = static_cast<Pixel>(offset + static_cast<float>(n));
  ASSERT_TRUE(cv::imwrite(path.string(), image));
}

template <typename Pixel>
void expect_stack_of(const std::string& extension) {
  const TemporaryFolder folder;
  for (const int k : {10, 9, 2})
    write_image<Pixel>(folder.path() / ("slice_" + std::to_string(k) + extension), static_cast<float>(k));
  folder.write("notes.txt", "not a slice");
  const auto volume = read_file_volume(folder.path(), stack_options());
  ASSERT_TRUE(volume.has_value()) << volume.error().text();
  EXPECT_EQ(volume->header.dims, Eigen::Vector3i(4, 3, 3));
  EXPECT_EQ(volume->at(0, 0, 0), 2);
  EXPECT_EQ(volume->at(0, 0, 1), 9);
  EXPECT_EQ(volume->at(1, 2, 2), 10 + 9);
}

TEST(ImageStack, ReadsGreySlicesInNaturalOrder) {
  expect_stack_of<std::uint8_t>(".png");
  expect_stack_of<std::uint16_t>(".png");
  expect_stack_of<std::uint8_t>(".tif");
  expect_stack_of<std::uint16_t>(".tiff");
  expect_stack_of<float>(".tif");
}

TEST(ImageStack, TakesTheLuminanceOfColour) {
  const TemporaryFolder folder;
  for (const char* name : {"1.png", "2.png"}) {
    ASSERT_TRUE(cv::imwrite((folder.path() / name).string(), cv::Mat(3, 4, CV_8UC3, cv::Scalar(10, 100, 200))));
  }
  const auto volume = read_file_volume(folder.path(), stack_options());
  ASSERT_TRUE(volume.has_value()) << volume.error().text();
  EXPECT_NEAR(volume->samples[0], 0.114 * 10 + 0.587 * 100 + 0.299 * 200, 1e-3);
  EXPECT_EQ(volume->header.warnings.size(), 1u);
}

TEST(ImageStack, NeedsSpacingAndTwoEqualSlices) {
  const TemporaryFolder folder;
  write_image<std::uint8_t>(folder.path() / "1.png", 0);
  expect_error(read_file_volume(folder.path()), ErrorCode::kUsage, "spacing");
  expect_error(read_file_volume(folder.path(), stack_options()), ErrorCode::kInput, "at least 2 slices");
  expect_error(read_file_volume(folder.path() / "1.png"), ErrorCode::kInput, "folder of all slices");
  write_image<std::uint16_t>(folder.path() / "2.png", 0);
  expect_error(read_file_volume(folder.path(), stack_options()), ErrorCode::kInput, "2.png: differs");
}

TEST(ImageStack, NamesTheFirstMissingNumber) {
  const auto warnings_of = [](const std::vector<std::string>& names) {
    const TemporaryFolder folder;
    for (const std::string& name : names) write_image<std::uint8_t>(folder.path() / name, 0);
    const auto volume = read_file_volume(folder.path(), stack_options());
    return volume ? volume->header.warnings : std::vector<std::string>{volume.error().text()};
  };
  const auto gap = warnings_of({"slice_001.png", "slice_002.png", "slice_004.png", "slice_009.png"});
  ASSERT_EQ(gap.size(), 1u);
  EXPECT_TRUE(gap[0].starts_with("no slice number 3: slice_004.png follows slice_002.png")) << gap[0];
  EXPECT_EQ(warnings_of({"slice_001.png", "slice_003.png"}).size(), 1u);
  EXPECT_EQ(warnings_of({"8.png", "9.png", "10.png", "11.png"}), std::vector<std::string>{});
  EXPECT_EQ(warnings_of({"a.png", "b.png", "z.png"}), std::vector<std::string>{});
  EXPECT_EQ(warnings_of({"1_8bit.png", "2_8bit.png", "5_9bit.png"}), std::vector<std::string>{});
}

TEST(SkippedNumber, IsTheOneAfterTheFirstNames) {
  EXPECT_EQ(skipped_number("s_099.png", "s_101.png"), 100u);
  EXPECT_EQ(skipped_number("s_9.png", "s_11.png"), 10u);
  EXPECT_EQ(skipped_number("1_16bit.png", "3_16bit.png"), 2u);
  EXPECT_EQ(skipped_number("s_9.png", "s_10.png"), std::nullopt);
  EXPECT_EQ(skipped_number("s_1.png", "s_01.png"), std::nullopt);
  EXPECT_EQ(skipped_number("s_1.png", "s_3.tif"), std::nullopt);
  EXPECT_EQ(skipped_number("", "3"), std::nullopt);
  EXPECT_EQ(skipped_number("1", "99999999999999999999"), std::nullopt);
}

TEST(ImageStack, NamesTheFormatsThatAreRead) {
  const TemporaryFolder folder;
  for (const char* name : {"1.jpg", "2.jpg"}) folder.write(name, "\xff\xd8\xff");
  expect_error(read_file_volume(folder.path(), stack_options()), ErrorCode::kInput,
               "1.jpg; of images only PNG and TIFF");
  expect_error(read_file_volume(folder.path()), ErrorCode::kInput, "no PNG, TIFF or DICOM slices");
}

/// A TIFF of 4 x 3 pixels whose second page is of `kind` (NewSubfileType).
std::string tiff_of_two_pages(std::uint32_t kind) {
  std::string file("II*\0", 4);
  append(file, std::uint32_t{20});
  file += std::string(12, '\7');
  for (const std::uint32_t page : {0u, 1u}) {
    const std::vector<std::array<std::uint32_t, 2>> entries = {{254, page == 0 ? 0 : kind},
                                                               {256, 4},
                                                               {257, 3},
                                                               {258, 8},
                                                               {259, 1},
                                                               {262, 1},
                                                               {273, 8},
                                                               {277, 1},
                                                               {278, 3},
                                                               {279, 12}};
    append(file, static_cast<std::uint16_t>(entries.size()));
    for (const auto& [tag, value] : entries) {
      append(file, static_cast<std::uint16_t>(tag));
      append(file, std::uint16_t{4});  // LONG
      append(file, std::uint32_t{1});
      append(file, value);
    }
    append(file, page == 0 ? static_cast<std::uint32_t>(file.size() + 4) : 0u);
  }
  return file;
}

TEST(ImageStack, RefusesTiffsOfSeveralPagesButNotTheirThumbnails) {
  const TemporaryFolder folder;
  folder.write("1.tif", tiff_of_two_pages(0));
  expect_error(read_file_volume(folder.path(), stack_options()), ErrorCode::kInput, "several pages");
  expect_error(read_file_volume(folder.path() / "1.tif"), ErrorCode::kInput, "several pages");
  folder.write("2.tif", tiff_of_two_pages(0));
  expect_error(read_file_volume(folder.path(), stack_options()), ErrorCode::kInput, "1.tif: a TIFF of several pages");
  constexpr std::uint32_t kThumbnail = 1;
  for (const char* name : {"1.tif", "2.tif"}) folder.write(name, tiff_of_two_pages(kThumbnail));
  const auto volume = read_file_volume(folder.path(), stack_options());
  ASSERT_TRUE(volume.has_value()) << volume.error().text();
  EXPECT_EQ(volume->at(3, 2, 1), 7);
}

TEST(ImageStack, SurvivesTruncationAtEveryByte) {
  for (const std::string extension : {".png", ".tif"}) {
    const TemporaryFolder folder;
    write_image<std::uint16_t>(folder.path() / ("1" + extension), 0);
    write_image<std::uint16_t>(folder.path() / ("2" + extension), 0);
    const auto whole = std::filesystem::file_size(folder.path() / ("2" + extension));
    for (std::uintmax_t length = whole; length-- > 0;) {
      std::filesystem::resize_file(folder.path() / ("2" + extension), length);
      const auto volume = read_file_volume(folder.path(), stack_options());
      if (!volume) {
        EXPECT_EQ(volume.error().code, ErrorCode::kInput);
      }
    }
  }
}

TEST(ImageStack, RefusesAnImageThatClaimsTooManyPixels) {
  const TemporaryFolder folder;
  write_image<std::uint8_t>(folder.path() / "1.png", 0);
  std::ifstream file(folder.path() / "1.png", std::ios::binary);
  std::string png((std::istreambuf_iterator<char>(file)), {});
  png[17] = png[21] = '\x10';  // a megapixel along each side
  folder.write("1.png", png);
  folder.write("2.png", png);
  expect_error(read_file_volume(folder.path(), stack_options()), ErrorCode::kInput, "not of 1 to 64000000 pixels");
}

}  // namespace
}  // namespace scanknit
