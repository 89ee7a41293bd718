// NRRD and MetaImage: text headers.
#include "written_volume.h"

namespace scanknit {
namespace {

std::string nrrd(const std::string& fields, const std::string& data = sample_bytes()) {
  return "NRRD0004\n# a comment\n" + fields + "\n" + data;
}
const std::string kCommon = "type: short\ndimension: 3\nsizes: 4 3 2\nendian: little\n";

TEST(Nrrd, ReadsEveryTypeInBothByteOrders) {
  constexpr std::array kNames = {"int8", "uchar",    "short",  "ushort", "int",
                                 "uint", "longlong", "uint64", "float",  "double"};
  const TemporaryFolder folder;
  for (std::size_t n = 0; n < kAllTypes.size(); ++n) {
    for (const ByteOrder order : kBothOrders) {
      const std::string fields = std::string("type: ") + kNames[n] +
                                 "\ndimension: 3\nsizes: 4 3 2\nencoding: raw\nendian: " +
                                 (order == ByteOrder::kLittle ? "little\n" : "big\n");
      const auto volume = read_file_volume(folder.write("a.nrrd", nrrd(fields, sample_bytes(kAllTypes[n], order))));
      expect_test_volume(volume);
      if (volume) {
        EXPECT_EQ(volume->header.sample_type, sample_type_name(kAllTypes[n]));
      }
    }
  }
}

TEST(Nrrd, DecodesGzipAndText) {
  const TemporaryFolder folder;
  const std::string packed = deflated(sample_bytes(), true);
  expect_test_volume(read_file_volume(folder.write("z.nrrd", nrrd(kCommon + "encoding: gzip\n", packed))));
  const std::string big = deflated(sample_bytes(SampleType::kInt16, ByteOrder::kBig), true);
  expect_test_volume(read_file_volume(
      folder.write("b.nrrd", nrrd("type: short\ndimension: 3\nsizes: 4 3 2\nendian: big\nencoding: gz\n", big))));
  std::string text;
  for (std::size_t n = 0; n < kSamples; ++n) text += std::to_string(static_cast<int>(expected_sample(n))) + "\n";
  expect_test_volume(read_file_volume(folder.write("t.nrrd", nrrd(kCommon + "encoding: ascii\n", text))));
}

TEST(Nrrd, KeepsTheFilesOwnCoordinatesInRas) {
  const TemporaryFolder folder;
  const auto volume = read_file_volume(folder.write(
      "a.nrrd",
      nrrd(kCommon + "encoding: raw\nspace: right-anterior-superior\nspace directions: (0,2,0) (-3,0,0) (0,0.5,4)\n"
                     "space origin: (10,20,30)\nspace units: \"cm\" \"cm\" \"cm\"\n")));
  ASSERT_TRUE(volume.has_value()) << volume.error().text();
  const Eigen::Vector3d p = volume->header.T_file_index * Eigen::Vector3d(1, 10, 100);
  EXPECT_TRUE(p.isApprox(Eigen::Vector3d(10 - 30, 20 + 2 + 50, 30 + 400))) << p.transpose();
  EXPECT_EQ(volume->header.metres_per_unit, 1e-2);
}

TEST(Nrrd, ReadsSpacingsAndTheCentreOfTheFirstCell) {
  const TemporaryFolder folder;
  const auto volume = read_file_volume(folder.write(
      "a.nrrd", nrrd(kCommon + "encoding: raw\nspacings: 1 2 3\naxis mins: 5 5 5\ncenters: node cell cell\n")));
  ASSERT_TRUE(volume.has_value()) << volume.error().text();
  EXPECT_TRUE(volume->header.T_file_index.translation().isApprox(Eigen::Vector3d(5, 6, 6.5)));
  EXPECT_TRUE(volume->header.T_file_index.linear().diagonal().isApprox(Eigen::Vector3d(1, 2, 3)));
}

TEST(Nrrd, ReadsADetachedFileWithSkips) {
  const TemporaryFolder folder;
  folder.write("the data.raw", "line one\nline two\nXY" + sample_bytes());
  const std::string fields = kCommon + "encoding: raw\ndata file: the data.raw\n";
  expect_test_volume(read_file_volume(folder.write("a.nhdr", nrrd(fields + "line skip: 2\nbyte skip: 2\n", ""))));
  expect_test_volume(read_file_volume(folder.write("b.nhdr", nrrd(fields + "byte skip: -1\n", ""))));
}

TEST(Nrrd, NamesTheMissingDataFile) {
  const TemporaryFolder folder;
  const std::string fields = kCommon + "encoding: raw\ndata file: gone.raw\n";
  expect_error(read_file_volume(folder.write("a.nhdr", nrrd(fields, ""))), ErrorCode::kInput, "gone.raw");
}

TEST(Nrrd, RefusesVectorsAndTime) {
  const TemporaryFolder folder;
  const std::string four = "type: uchar\ndimension: 4\nencoding: raw\n";
  expect_error(
      read_file_volume(folder.write("a.nrrd", nrrd(four + "sizes: 3 2 2 2\nkinds: vector domain domain domain\n"))),
      ErrorCode::kInput, "axis 0 (vector)");
  expect_error(read_file_volume(folder.write("b.nrrd", nrrd(four + "sizes: 2 2 2 3\n"))), ErrorCode::kInput, "axis 3");
}

TEST(Nrrd, DropsAnAxisOfOneEntry) {
  const TemporaryFolder folder;
  expect_test_volume(read_file_volume(folder.write(
      "a.nrrd", nrrd("type: short\ndimension: 4\nsizes: 1 4 3 2\nendian: little\nencoding: raw\nspace dimension: 3\n"
                     "space directions: none (1,0,0) (0,1,0) (0,0,1)\n"))));
}

TEST(Nrrd, RefusesFlatAndHugeVolumesBeforeAllocating) {
  const TemporaryFolder folder;
  const auto sized = [&](const std::string& sizes, const std::string& encoding) {
    return read_file_volume(folder.write("a.nrrd", nrrd("type: double\ndimension: 3\nendian: little\nsizes: " + sizes +
                                                        "\nencoding: " + encoding + "\n")));
  };
  expect_error(sized("4 3 1", "raw"), ErrorCode::kInput, "at least 2");
  for (const std::string encoding : {"raw", "gzip", "ascii"}) {
    expect_error(sized("2000000000 2000000000 2000000000", encoding), ErrorCode::kInput, "too large");
    expect_error(sized("100000 100000 2000", encoding), ErrorCode::kInput, "file");
  }
}

TEST(Nrrd, SaysWhatTheBudgetLacksForACompressedVolume) {
  const TemporaryFolder folder;
  const std::string fields = "type: uchar\ndimension: 3\nsizes: 100 100 100\nencoding: gzip\n";
  VolumeOptions options;
  options.memory_budget_bytes = 999'999;
  const auto path = folder.write("a.nrrd", nrrd(fields, deflated(std::string(1'000'000, '\0'), true)));
  expect_error(read_file_volume(path, options), ErrorCode::kBudget, "save the volume uncompressed");
  EXPECT_TRUE(read_file_volume(path).has_value());
}

TEST(Nrrd, SurvivesTruncationAtEveryByte) {
  expect_safe_at_every_length("a.nrrd", nrrd(kCommon + "encoding: raw\nspacings: 1 1 1\n"));
  expect_safe_at_every_length("a.nrrd", nrrd(kCommon + "encoding: gzip\n", deflated(sample_bytes(), true)));
}

TEST(Nrrd, SurvivesAnyChangedByte) {
  const std::string header = nrrd(kCommon + "encoding: gzip\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n", "");
  expect_safe_with_any_byte_changed("a.nrrd", header + deflated(sample_bytes(), true), header.size());
}

TEST(Nrrd, SurvivesRandomChanges) {
  const std::string geometry =
      "space: right-anterior-superior\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nspace origin: (1,2,3)\n"
      "space units: \"mm\" \"mm\" \"mm\"\nkinds: domain domain domain\nlabels: \"i\" \"j\" \"k\"\nkey:=value\n";
  expect_safe_with_random_changes("a.nrrd", nrrd(kCommon + geometry + "encoding: raw\n", ""), sample_bytes(), true);
  expect_safe_with_random_changes("a.nrrd", nrrd(kCommon + "encoding: gzip\nspacings: 1 2 3\naxis mins: 0 0 0\n", ""),
                                  deflated(sample_bytes(), true), true);
}

TEST(Nrrd, TakesLongKeysAndCommentsButNoLongField) {
  const TemporaryFolder folder;
  const std::string text(100'000, 'x');
  const std::string keys = "key:=" + text + ": " + text + "\n# " + text + "\n";
  expect_test_volume(read_file_volume(folder.write("a.nrrd", nrrd(kCommon + keys + "encoding: raw\n"))));
  expect_error(read_file_volume(folder.write("a.nrrd", nrrd(kCommon + "units: " + text + "\nencoding: raw\n"))),
               ErrorCode::kInput, "512 bytes");
  expect_error(
      read_file_volume(folder.write("a.nrrd", nrrd(kCommon + "# hidden\runits: " + text + "\nencoding: raw\n"))),
      ErrorCode::kInput, "512 bytes");
}

TEST(Nrrd, TakesLinesThatEndAsInWindows) {
  const TemporaryFolder folder;
  std::string header;
  for (const char c : nrrd(kCommon + "encoding: raw\n", ""))
    header += c == '\n' ? std::string("\r\n") : std::string(1, c);
  expect_test_volume(read_file_volume(folder.write("a.nrrd", header + sample_bytes())));
}

TEST(Nrrd, RefusesSamplesInSeveralFiles) {
  const TemporaryFolder folder;
  folder.write("1.raw", sample_bytes());
  for (const std::string list : {"LIST\n1.raw\n1.raw\n", "%d.raw 1 1 1\n"}) {
    expect_error(read_file_volume(folder.write("a.nhdr", "NRRD0004\n" + kCommon + "encoding: raw\ndata file: " + list)),
                 ErrorCode::kInput, "several files");
  }
}

TEST(Nrrd, NamesTheEncodingsThatAreRead) {
  const TemporaryFolder folder;
  for (const std::string encoding : {"bzip2", "hex"}) {
    const auto path = folder.write("a.nrrd", nrrd(kCommon + "encoding: " + encoding + "\n"));
    expect_error(read_file_volume(path), ErrorCode::kInput, "encoding " + encoding + ", expected raw, gzip or ascii");
  }
}

TEST(Nrrd, FindsNamesInCapitals) {
  const TemporaryFolder folder;
  expect_test_volume(read_file_volume(folder.write("A.NRRD", nrrd(kCommon + "encoding: raw\n"))));
  folder.write("A.RAW", sample_bytes());
  expect_test_volume(read_file_volume(folder.write("A.NHDR", nrrd(kCommon + "encoding: raw\ndata file: A.RAW\n", ""))));
}

TEST(Nrrd, SkipsBytesOfWhatAGzipStreamHolds) {
  const TemporaryFolder folder;
  const std::string packed = deflated("skipped" + sample_bytes(), true);
  expect_test_volume(
      read_file_volume(folder.write("a.nrrd", nrrd(kCommon + "encoding: gzip\nbyte skip: 7\n", packed))));
}

TEST(Nrrd, ChecksTheSumAtTheEndOfAGzipStream) {
  const TemporaryFolder folder;
  const std::string fields = kCommon + "encoding: gzip\n";
  std::string packed = deflated(sample_bytes(), true);
  packed[packed.size() - 8] = static_cast<char>(packed[packed.size() - 8] ^ 1);
  expect_error(read_file_volume(folder.write("a.nrrd", nrrd(fields, packed))), ErrorCode::kInput, "corrupt");
  const std::string two = deflated(sample_bytes().substr(0, 11), true) + deflated(sample_bytes().substr(11), true);
  expect_test_volume(read_file_volume(folder.write("a.nrrd", nrrd(fields, two))));
}

TEST(Nrrd, StreamsOnlyWhatIsNotCompressed) {
  const TemporaryFolder folder;
  const auto raw = open_volume(folder.write("a.nrrd", nrrd(kCommon + "encoding: raw\n")), {});
  const auto packed =
      open_volume(folder.write("b.nrrd", nrrd(kCommon + "encoding: gzip\n", deflated(sample_bytes(), true))), {});
  ASSERT_TRUE(raw.has_value() && packed.has_value());
  EXPECT_TRUE((*raw)->is_streamed());
  EXPECT_FALSE((*packed)->is_streamed());
}

TEST(SliceReader, ReadsSlicesInAnyOrder) {
  const TemporaryFolder folder;
  auto reader = open_volume(folder.write("a.nrrd", nrrd(kCommon + "encoding: raw\n")), {});
  ASSERT_TRUE(reader.has_value());
  std::array<float, 12> slice;
  for (const int k : {1, 0, 1}) {
    ASSERT_TRUE((*reader)->read_slice(k, slice).has_value());
    for (std::size_t n = 0; n < 12; ++n) EXPECT_EQ(slice[n], expected_sample(n + 12 * static_cast<std::size_t>(k)));
  }
}

const std::string kMeta = "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n";

TEST(MetaImage, ReadsAttachedDetachedAndCompressed) {
  const TemporaryFolder folder;
  expect_test_volume(read_file_volume(folder.write("a.mha", kMeta + "ElementDataFile = LOCAL\n" + sample_bytes())));
  folder.write("a b.raw", "skipped" + sample_bytes(SampleType::kInt16, ByteOrder::kBig));
  expect_test_volume(read_file_volume(
      folder.write("b.mhd", kMeta + "ElementByteOrderMSB = True\nHeaderSize = 7\nElementDataFile = a b.raw\n")));
  expect_test_volume(read_file_volume(
      folder.write("c.mhd", kMeta + "BinaryDataByteOrderMSB = True\nHeaderSize = -1\nElementDataFile = a b.raw\n")));
  const std::string packed = deflated(sample_bytes(), false);
  expect_test_volume(read_file_volume(
      folder.write("d.mha", kMeta + "CompressedData = True\nCompressedDataSize = " + std::to_string(packed.size()) +
                                "\nElementDataFile = LOCAL\n" + packed)));
}

TEST(MetaImage, FindsNamesInCapitals) {
  const TemporaryFolder folder;
  expect_test_volume(read_file_volume(folder.write("A.MHA", kMeta + "ElementDataFile = LOCAL\n" + sample_bytes())));
  folder.write("A.RAW", sample_bytes());
  expect_test_volume(read_file_volume(folder.write("A.MHD", kMeta + "ElementDataFile = A.RAW\n")));
}

TEST(MetaImage, ReadsDirectionsAsTheFileSays) {
  const TemporaryFolder folder;
  const auto volume = read_file_volume(
      folder.write("a.mha", kMeta +
                                "TransformMatrix = 0 1 0 -1 0 0 0 0 -1\nOffset = 1 2 3\nElementSpacing = 2 3 4\n"
                                "ElementDataFile = LOCAL\n" +
                                sample_bytes()));
  ASSERT_TRUE(volume.has_value()) << volume.error().text();
  const Eigen::Vector3d p = volume->header.T_file_index * Eigen::Vector3d(1, 10, 100);
  EXPECT_TRUE(p.isApprox(Eigen::Vector3d(1 - 30, 2 + 2, 3 - 400))) << p.transpose();
  EXPECT_LT(volume->header.T_file_index.linear().determinant(), 0);
}

TEST(MetaImage, RefusesChannelsTimeAndLists) {
  const TemporaryFolder folder;
  const auto with = [&](const std::string& header) { return read_file_volume(folder.write("a.mha", header)); };
  expect_error(with(kMeta + "ElementNumberOfChannels = 3\nElementDataFile = LOCAL\n"), ErrorCode::kInput, "1 number");
  expect_error(with("NDims = 4\nDimSize = 4 3 2 5\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"),
               ErrorCode::kInput, "dimension 4 has 5");
  expect_error(with(kMeta + "ElementDataFile = LIST\na.raw\n"), ErrorCode::kInput, "join listed files");
  expect_error(with(kMeta + "ElementDataFile = gone.raw\n"), ErrorCode::kInput, "gone.raw");
}

TEST(MetaImage, SurvivesTruncationAndAnyChangedByte) {
  const std::string packed = deflated(sample_bytes(), false);
  const std::string header =
      kMeta + "ElementSpacing = 1 1 1\nCompressedData = True\nCompressedDataSize = " + std::to_string(packed.size()) +
      "\nElementDataFile = LOCAL\n";
  expect_safe_at_every_length("a.mha", kMeta + "ElementDataFile = LOCAL\n" + sample_bytes());
  expect_safe_at_every_length("a.mha", header + packed);
  expect_safe_with_any_byte_changed("a.mha", header + packed, header.size());
}

TEST(MetaImage, SurvivesRandomChanges) {
  const std::string geometry =
      "Comment = none\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 1 1 1\n"
      "DistanceUnits = mm\nAnatomicalOrientation = RAI\nHeaderSize = 0\nElementNumberOfChannels = 1\n";
  expect_safe_with_random_changes("a.mha", kMeta + geometry + "ElementDataFile = LOCAL\n", sample_bytes(), true);
}

TEST(MetaImage, RefusesWhatWouldOverrunMetaIO) {
  const TemporaryFolder folder;
  const std::string text(255, 'x');
  for (const std::string& line : {"Comment = " + text, "Name = " + text, std::string("NDims = 5000"),
                                  std::string("NDims = 1e9"), std::string("NDims"), std::string("Name = \x01")}) {
    expect_error(
        read_file_volume(folder.write("a.mha", line + "\n" + kMeta + "ElementDataFile = LOCAL\n" + sample_bytes())),
        ErrorCode::kInput, "not MetaImage");
  }
}

TEST(MetaImage, ReadsUnitsAndSpacingsToTheLastDigit) {
  const TemporaryFolder folder;
  const auto volume = read_file_volume(folder.write(
      "a.mha", kMeta +
                   "ElementSpacing = 0.1234567890123456 1 1\nOffset = 1.234567890123456 0 0\nDistanceUnits = um\n"
                   "ElementDataFile = LOCAL\n" +
                   sample_bytes()));
  expect_test_volume(volume);
  EXPECT_EQ(volume->header.T_file_index(0, 0), 0.1234567890123456);
  EXPECT_EQ(volume->header.T_file_index(0, 3), 1.234567890123456);
  EXPECT_EQ(volume->header.metres_per_unit, 1e-6);
  EXPECT_TRUE(volume->header.warnings.empty());
}

}  // namespace
}  // namespace scanknit
