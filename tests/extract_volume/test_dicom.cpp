#include "written_volume.h"

namespace scanknit {
namespace {

struct DicomSlice {
  std::string series = "1.2.3";
  std::string position = "0\\0\\0";
  std::string orientation = "1\\0\\0\\0\\1\\0";
  std::string rescale_slope = {};
  std::uint16_t columns = 4, rows = 3, samples_per_pixel = 1;
  std::string frames = {};
  bool is_big = false;
  std::size_t first_sample = 0;
};

// Explicit VR, the data set in either byte order; the meta header is always little endian.
void append_element(std::string& bytes, std::uint16_t group, std::uint16_t element, const std::string& vr,
                    std::string value, ByteOrder order) {
  if (value.size() % 2 == 1) value += vr == "UI" ? '\0' : ' ';
  append(bytes, group, order);
  append(bytes, element, order);
  bytes += vr;
  if (vr == "OW" || vr == "OB") {
    append(bytes, std::uint16_t{0}, order);
    append(bytes, static_cast<std::uint32_t>(value.size()), order);
  } else {
    append(bytes, static_cast<std::uint16_t>(value.size()), order);
  }
  bytes += value;
}

std::string dicom(const DicomSlice& slice) {
  const ByteOrder order = slice.is_big ? ByteOrder::kBig : ByteOrder::kLittle;
  const auto number = [&](auto value) {
    std::string bytes;
    append(bytes, value, order);
    return bytes;
  };
  std::string meta, set;
  append_element(meta, 2, 0x02, "UI", "1.2.840.10008.5.1.4.1.1.2", ByteOrder::kLittle);
  append_element(meta, 2, 0x03, "UI", "1.2.3.4", ByteOrder::kLittle);
  append_element(meta, 2, 0x10, "UI", slice.is_big ? "1.2.840.10008.1.2.2" : "1.2.840.10008.1.2.1", ByteOrder::kLittle);
  std::string length;
  append(length, static_cast<std::uint32_t>(meta.size()));
  std::string head;
  append_element(head, 2, 0, "UL", length, ByteOrder::kLittle);
  const auto add = [&](std::uint16_t group, std::uint16_t element, const char* vr, const std::string& value) {
    append_element(set, group, element, vr, value, order);
  };
  add(0x08, 0x16, "UI", "1.2.840.10008.5.1.4.1.1.2");
  add(0x08, 0x60, "CS", "CT");
  add(0x20, 0x0e, "UI", slice.series);
  add(0x20, 0x32, "DS", slice.position);
  add(0x20, 0x37, "DS", slice.orientation);
  add(0x28, 0x02, "US", number(slice.samples_per_pixel));
  add(0x28, 0x04, "CS", slice.samples_per_pixel == 1 ? "MONOCHROME2" : "RGB");
  if (!slice.frames.empty()) add(0x28, 0x08, "IS", slice.frames);
  add(0x28, 0x10, "US", number(slice.rows));
  add(0x28, 0x11, "US", number(slice.columns));
  add(0x28, 0x30, "DS", "3\\2");
  add(0x28, 0x100, "US", number(std::uint16_t{16}));
  add(0x28, 0x101, "US", number(std::uint16_t{16}));
  add(0x28, 0x102, "US", number(std::uint16_t{15}));
  add(0x28, 0x103, "US", number(std::uint16_t{1}));
  if (!slice.rescale_slope.empty()) {
    add(0x28, 0x1052, "DS", "-1024");
    add(0x28, 0x1053, "DS", slice.rescale_slope);
  }
  std::string pixels;
  for (std::size_t n = 0; n < 12; ++n) {
    append(pixels, static_cast<std::int16_t>(expected_sample(slice.first_sample + n)), order);
  }
  add(0x7fe0, 0x10, "OW", pixels);
  return std::string(128, '\0') + "DICM" + head + meta + set;
}

// Two slices whose names are in the wrong order.
void write_series(const TemporaryFolder& folder, DicomSlice slice = {}) {
  folder.write("b.dcm", dicom(slice));
  slice.position = "0\\0\\5";
  slice.first_sample = 12;
  folder.write("a.dcm", dicom(slice));
}

TEST(Dicom, SortsSlicesAlongTheNormal) {
  const TemporaryFolder folder;
  write_series(folder);
  for (const auto& path : {folder.path(), folder.path() / "a.dcm"}) {
    const auto volume = read_file_volume(path);
    expect_test_volume(volume);
    EXPECT_EQ(volume->header.format, "DICOM");
    EXPECT_EQ(volume->header.sample_type, "int16");
    EXPECT_TRUE(volume->header.T_file_index.linear().diagonal().isApprox(Eigen::Vector3d(2, 3, 5)));
    EXPECT_TRUE(volume->header.warnings.empty());
  }
}

TEST(Dicom, AppliesTheRescaleOfEachSlice) {
  const TemporaryFolder folder;
  DicomSlice slice;
  slice.rescale_slope = "2.5";
  write_series(folder, slice);
  expect_test_volume(read_file_volume(folder.path()), 2.5, -1024);
}

TEST(Dicom, ReadsBigEndian) {
  const TemporaryFolder folder;
  DicomSlice slice;
  slice.is_big = true;
  write_series(folder, slice);
  expect_test_volume(read_file_volume(folder.path()));
}

TEST(Dicom, FollowsOrientationAndTilt) {
  const TemporaryFolder folder;
  DicomSlice slice;
  slice.orientation = "0\\1\\0\\0\\0\\-1";  // the normal is -x
  slice.position = "7\\8\\9";
  folder.write("1", dicom(slice));
  slice.position = "3\\9\\9";
  slice.first_sample = 12;
  folder.write("2", dicom(slice));
  const auto volume = read_file_volume(folder.path());
  expect_test_volume(volume);
  const Eigen::Vector3d p = volume->header.T_file_index * Eigen::Vector3d(1, 10, 1);
  EXPECT_TRUE(p.isApprox(Eigen::Vector3d(7 - 4, 8 + 2 + 1, 9 - 30))) << p.transpose();
}

TEST(Dicom, TakesTheLargestSeriesAndNamesTheOthers) {
  const TemporaryFolder folder;
  write_series(folder);
  DicomSlice other;
  other.series = "9.9";
  folder.write("0.dcm", dicom(other));
  folder.write("readme.txt", "not DICOM");
  const auto volume = read_file_volume(folder.path());
  expect_test_volume(volume);
  ASSERT_EQ(volume->header.warnings.size(), 2u);
  EXPECT_NE(volume->header.warnings[0].find("series 9.9, 1 slices"), std::string::npos) << volume->header.warnings[0];
  EXPECT_NE(volume->header.warnings[1].find("readme.txt"), std::string::npos) << volume->header.warnings[1];
}

TEST(Dicom, WarnsOfUnevenSpacingAndRefusesTwoSlicesAtOnePlace) {
  const TemporaryFolder folder;
  write_series(folder);
  DicomSlice slice;
  slice.position = "0\\0\\10.2";
  folder.write("c.dcm", dicom(slice));
  const auto volume = read_file_volume(folder.path());
  ASSERT_TRUE(volume.has_value()) << volume.error().text();
  ASSERT_EQ(volume->header.warnings.size(), 1u);
  EXPECT_NE(volume->header.warnings[0].find("5.2"), std::string::npos) << volume->header.warnings[0];
  slice.position = "0\\0\\5";
  folder.write("c.dcm", dicom(slice));
  expect_error(read_file_volume(folder.path()), ErrorCode::kInput, "same plane");
}

TEST(Dicom, RefusesColourFramesAndSingleSlices) {
  const TemporaryFolder folder;
  DicomSlice slice;
  expect_error(read_file_volume(folder.write("a.dcm", dicom(slice))), ErrorCode::kInput, "at least 2");
  slice.samples_per_pixel = 3;
  expect_error(read_file_volume(folder.write("a.dcm", dicom(slice))), ErrorCode::kInput, "colour");
  slice.samples_per_pixel = 1;
  slice.frames = "5";
  expect_error(read_file_volume(folder.write("a.dcm", dicom(slice))), ErrorCode::kInput, "multi-frame");
}

TEST(Dicom, SurvivesTruncationAtEveryByte) {
  const TemporaryFolder folder;
  write_series(folder);
  const std::string whole = dicom({.position = "0\\0\\5", .first_sample = 12});
  for (std::size_t length = 0; length < whole.size(); ++length) {
    folder.write("a.dcm", whole.substr(0, length));
    const auto volume = read_file_volume(folder.path());
    ASSERT_FALSE(volume.has_value()) << length;
    EXPECT_EQ(volume.error().code, ErrorCode::kInput);
  }
}

TEST(Dicom, SurvivesChangedBytes) {
  const TemporaryFolder folder;
  write_series(folder);
  const std::string whole = dicom({.position = "0\\0\\5", .first_sample = 12});
  for (std::size_t at = 128; at < whole.size() - 24; ++at) {
    for (const char replacement : {'\0', '\xff', '\x7f'}) {
      std::string changed = whole;
      changed[at] = replacement;
      folder.write("a.dcm", changed);
      const auto volume = read_file_volume(folder.path());
      if (!volume) {
        EXPECT_EQ(volume.error().code, ErrorCode::kInput) << volume.error().text();
      }
    }
  }
}

}  // namespace
}  // namespace scanknit
