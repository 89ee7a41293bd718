#include "written_volume.h"

namespace scanknit {
namespace {

template <typename T>
void put(std::string& header, std::size_t offset, T value, ByteOrder order = ByteOrder::kLittle) {
  std::string bytes;
  append(bytes, value, order);
  header.replace(offset, bytes.size(), bytes);
}

struct NiftiType {
  SampleType type;
  std::int16_t code;
};
constexpr std::array kNiftiTypes = {NiftiType{SampleType::kUint8, 2},    NiftiType{SampleType::kInt16, 4},
                                    NiftiType{SampleType::kInt32, 8},    NiftiType{SampleType::kFloat, 16},
                                    NiftiType{SampleType::kDouble, 64},  NiftiType{SampleType::kInt8, 256},
                                    NiftiType{SampleType::kUint16, 512}, NiftiType{SampleType::kUint32, 768},
                                    NiftiType{SampleType::kInt64, 1024}, NiftiType{SampleType::kUint64, 1280}};

// A header of nifti1.h with its 4 bytes of "no extension".
std::string nifti(NiftiType type = {SampleType::kInt16, 4}, ByteOrder order = ByteOrder::kLittle) {
  std::string header(352, '\0');
  put(header, 0, std::int32_t{348}, order);
  const std::array<std::int16_t, 8> dim = {3, 4, 3, 2, 1, 1, 1, 1};
  for (std::size_t n = 0; n < 8; ++n) put(header, 40 + 2 * n, dim[n], order);
  put(header, 70, type.code, order);
  put(header, 72, static_cast<std::int16_t>(8 * bytes_per_sample(type.type)), order);
  for (std::size_t n = 0; n < 8; ++n) put(header, 76 + 4 * n, 1.0f, order);
  put(header, 108, 352.0f, order);
  put(header, 123, std::uint8_t{2}, order);
  header.replace(344, 4, std::string("n+1\0", 4));
  return header;
}

// A quarter turn about z, spacing 2, 3, 4 and the third axis flipped.
void put_qform(std::string& header) {
  put(header, 252, std::int16_t{1});
  put(header, 76, -1.0f);
  put(header, 80, 2.0f);
  put(header, 84, 3.0f);
  put(header, 88, 4.0f);
  put(header, 264, std::sqrt(0.5f));
  put(header, 268, 10.0f);
  put(header, 272, 20.0f);
  put(header, 276, 30.0f);
}

void put_sform(std::string& header, const std::array<float, 12>& rows) {
  put(header, 254, std::int16_t{1});
  for (std::size_t n = 0; n < rows.size(); ++n) put(header, 280 + 4 * n, rows[n]);
}

TEST(Nifti, ReadsEveryTypeInBothByteOrdersPlainAndCompressed) {
  const TemporaryFolder folder;
  for (const NiftiType& type : kNiftiTypes) {
    for (const ByteOrder order : kBothOrders) {
      const std::string file = nifti(type, order) + sample_bytes(type.type, order);
      const auto plain = read_file_volume(folder.write("a.nii", file));
      expect_test_volume(plain);
      if (plain) {
        EXPECT_EQ(plain->header.sample_type, sample_type_name(type.type));
      }
      expect_test_volume(read_file_volume(folder.write("a.nii.gz", deflated(file, true))));
    }
  }
}

TEST(Nifti, KeepsRasCoordinatesOfTheQform) {
  const TemporaryFolder folder;
  std::string header = nifti();
  put_qform(header);
  for (const bool is_packed : {false, true}) {
    const std::string file = header + sample_bytes();
    const auto volume =
        read_file_volume(is_packed ? folder.write("a.nii.gz", deflated(file, true)) : folder.write("a.nii", file));
    expect_test_volume(volume);
    const Eigen::Vector3d p = volume->header.T_file_index * Eigen::Vector3d(1, 10, 100);
    EXPECT_TRUE(p.isApprox(Eigen::Vector3d(10 - 30, 20 + 2, 30 - 400), 1e-6)) << p.transpose();
    EXPECT_LT(volume->header.T_file_index.linear().determinant(), 0);
  }
}

TEST(Nifti, PrefersTheSformAndReadsItsUnit) {
  const TemporaryFolder folder;
  std::string header = nifti();
  put_qform(header);
  put_sform(header, {0, -3, 0, 1, 2, 0, 0, 2, 0, 0, 4, 3});
  put(header, 123, std::uint8_t{3});
  const auto volume = read_file_volume(folder.write("a.nii", header + sample_bytes()));
  expect_test_volume(volume);
  const Eigen::Vector3d p = volume->header.T_file_index * Eigen::Vector3d(1, 10, 100);
  EXPECT_TRUE(p.isApprox(Eigen::Vector3d(1 - 30, 2 + 2, 3 + 400), 1e-6)) << p.transpose();
  EXPECT_EQ(volume->header.metres_per_unit, 1e-6);
}

TEST(Nifti, KeepsAShearedSform) {
  const TemporaryFolder folder;
  std::string header = nifti();
  put_sform(header, {1, 0.5f, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0});
  const auto volume = read_file_volume(folder.write("a.nii", header + sample_bytes()));
  expect_test_volume(volume);
  EXPECT_EQ(volume->header.T_file_index.linear()(0, 1), 0.5);
  const auto packed = read_file_volume(folder.write("a.nii.gz", deflated(header + sample_bytes(), true)));
  expect_test_volume(packed);
}

TEST(Nifti, AppliesTheSlopeOnce) {
  const TemporaryFolder folder;
  std::string header = nifti();
  put(header, 112, 2.5f);
  put(header, 116, -10.0f);
  expect_test_volume(read_file_volume(folder.write("a.nii", header + sample_bytes())), 2.5, -10);
  expect_test_volume(read_file_volume(folder.write("a.nii.gz", deflated(header + sample_bytes(), true))), 2.5, -10);
}

TEST(Nifti, ReadsAPairByEitherName) {
  const TemporaryFolder folder;
  std::string header = nifti().substr(0, 348);
  header.replace(344, 4, std::string("ni1\0", 4));
  put(header, 108, 0.0f);
  folder.write("a.hdr", header);
  expect_error(read_file_volume(folder.path() / "a.hdr"), ErrorCode::kInput, ".img, is missing");
  folder.write("a.img", sample_bytes());
  expect_test_volume(read_file_volume(folder.path() / "a.hdr"));
  expect_test_volume(read_file_volume(folder.path() / "a.img"));
}

TEST(Nifti, FindsNamesInCapitals) {
  const TemporaryFolder folder;
  const std::string single = nifti() + sample_bytes();
  expect_test_volume(read_file_volume(folder.write("A.NII", single)));
  expect_test_volume(read_file_volume(folder.write("A.NII.GZ", deflated(single, true))));
  std::string header = nifti().substr(0, 348);
  header.replace(344, 4, std::string("ni1\0", 4));
  put(header, 108, 0.0f);
  folder.write("B.HDR", header);
  folder.write("B.IMG", sample_bytes());
  folder.write("C.HDR.GZ", deflated(header, true));
  folder.write("C.IMG.GZ", deflated(sample_bytes(), true));
  for (const char* name : {"B.HDR", "B.IMG", "C.HDR.GZ", "C.IMG.GZ"}) {
    SCOPED_TRACE(name);
    expect_test_volume(read_file_volume(folder.path() / name));
  }
  expect_error(read_file_volume(folder.write("D.IMG", sample_bytes())), ErrorCode::kInput, ".hdr, is missing");
}

TEST(Nifti, TakesAVoxOffsetOfZeroAsTheEndOfTheHeader) {
  const TemporaryFolder folder;
  std::string file = nifti() + sample_bytes();
  put(file, 108, 0.0f);
  expect_test_volume(read_file_volume(folder.write("a.nii", file)));
  expect_test_volume(read_file_volume(folder.write("a.nii.gz", deflated(file, true))));
  std::string longer = nifti() + std::string(16, 'x') + sample_bytes();
  put(longer, 108, 368.0f);
  expect_test_volume(read_file_volume(folder.write("b.nii", longer)));
}

TEST(Nifti, RefusesAVoxOffsetWhereNoSamplesCanBe) {
  const TemporaryFolder folder;
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const float offset : {std::nanf(""), kInfinity, -kInfinity, -8.0f, 3e38f, 352.5f, 1.0f, 348.0f, 351.0f}) {
    std::string file = nifti() + sample_bytes() + std::string(64, '\0');
    put(file, 108, offset);
    for (const auto& path : {folder.write("a.nii", file), folder.write("a.nii.gz", deflated(file, true))}) {
      expect_error(read_file_volume(path), ErrorCode::kInput, "vox_offset");
    }
  }
  std::string pair = nifti().substr(0, 348);
  pair.replace(344, 4, std::string("ni1\0", 4));
  folder.write("b.img", sample_bytes());
  for (const float offset : {std::nanf(""), -1.0f}) {
    put(pair, 108, offset);
    expect_error(read_file_volume(folder.write("b.hdr", pair)), ErrorCode::kInput, "vox_offset");
  }
}

TEST(Nifti, RefusesTimeColourAndAnalyze) {
  const TemporaryFolder folder;
  std::string time = nifti();
  put(time, 40, std::int16_t{4});
  put(time, 48, std::int16_t{5});
  expect_error(read_file_volume(folder.write("a.nii", time)), ErrorCode::kInput, "dim[4] (time) = 5");
  std::string colour = nifti();
  put(colour, 70, std::int16_t{128});
  expect_error(read_file_volume(folder.write("a.nii", colour)), ErrorCode::kInput, "datatype 128");
  std::string analyze = nifti();
  put(analyze, 344, std::int32_t{0});
  expect_error(read_file_volume(folder.write("a.hdr", analyze)), ErrorCode::kInput, "Analyze");
}

TEST(Nifti, RefusesHugeVolumesBeforeAllocating) {
  const TemporaryFolder folder;
  std::string header = nifti();
  for (const std::size_t offset : {42, 44, 46}) put(header, offset, std::int16_t{32767});
  expect_error(read_file_volume(folder.write("a.nii", header)), ErrorCode::kInput, "the file has");
  expect_error(read_file_volume(folder.write("a.nii.gz", deflated(header, true))), ErrorCode::kInput, "cannot hold");
}

TEST(Nifti, SurvivesTruncationAndAnyChangedByte) {
  const std::string file = nifti() + sample_bytes();
  expect_safe_at_every_length("a.nii", file);
  expect_safe_at_every_length("a.nii.gz", deflated(file, true));
  expect_safe_with_any_byte_changed("a.nii", file, 352);
}

TEST(Nifti, SurvivesAnyChangedHeaderByteWhenCompressed) {
  const TemporaryFolder folder;
  const std::string file = nifti() + sample_bytes();
  VolumeOptions options;
  options.memory_budget_bytes = std::size_t{16} << 20;
  for (std::size_t at = 0; at < 352; ++at) {
    for (const char replacement : {'\x7f', '\xff', '\x01'}) {
      std::string changed = file;
      changed[at] = replacement;
      (void)open_volume(folder.write("a.nii.gz", deflated(changed, true)), options).has_value();
    }
  }
}

TEST(Nifti, SurvivesRandomChanges) {
  std::string header = nifti();
  put_qform(header);
  expect_safe_with_random_changes("a.nii", header, sample_bytes(), false);
}

TEST(Nifti, NoticesACompressedVolumeThatWasCutShort) {
  const TemporaryFolder folder;
  const std::string packed = deflated(nifti() + sample_bytes(), true);
  for (std::size_t cut = 1; cut <= 8; ++cut) {
    expect_error(read_file_volume(folder.write("a.nii.gz", packed.substr(0, packed.size() - cut))), ErrorCode::kInput,
                 "truncated");
  }
}

}  // namespace
}  // namespace scanknit
