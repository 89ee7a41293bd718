// Volumes that Debian packages: mricron-data and invesalius-examples. Skipped where they are not installed.
#include <cstdlib>

#include "written_volume.h"

namespace scanknit {
namespace {

TEST(RealVolumes, ReadsTheHeadOfMricron) {
  const std::filesystem::path path = "/usr/share/mricron/templates/ch2bet.nii.gz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "the Debian package mricron-data is not installed";
  const auto volume = read_file_volume(path);
  ASSERT_TRUE(volume.has_value()) << volume.error().text();
  EXPECT_EQ(volume->header.dims, Eigen::Vector3i(181, 217, 181));
  EXPECT_EQ(volume->header.sample_type, "uint8");
  // MNI space: x grows to the right, the origin lies inside the brain.
  const Eigen::Vector3d origin = volume->header.T_file_index.inverse() * Eigen::Vector3d(0, 0, 0);
  EXPECT_TRUE((origin.array() > 60).all() && (origin.array() < 140).all()) << origin.transpose();
  EXPECT_NEAR(volume->header.T_file_index.linear().determinant(), 1, 1e-6);
  const auto [least, most] = std::ranges::minmax(volume->samples);
  EXPECT_EQ(least, 0);
  EXPECT_GT(most, 100);
}

TEST(RealVolumes, ReadsTheSamplesOfAnInVesaliusProject) {
  const std::filesystem::path project = "/usr/share/doc/invesalius-examples/examples/Cranium.inv3";
  if (!std::filesystem::exists(project)) GTEST_SKIP() << "the Debian package invesalius-examples is not installed";
  const TemporaryFolder folder;
  const std::string command = "tar -xzf '" + project.string() + "' --strip-components=1 --wildcards -C '" +
                              folder.path().string() + "' '*/matrix.dat'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  VolumeOptions options;  // as the project's main.plist says
  options.dims = {256, 256, 108};
  options.type = SampleType::kInt16;
  options.spacing = Eigen::Vector3d(0.957031, 0.957031, 1.5);
  const auto volume = read_file_volume(folder.path() / "matrix.dat", options);
  ASSERT_TRUE(volume.has_value()) << volume.error().text();
  const auto [least, most] = std::ranges::minmax(volume->samples);  // the range of the unpacked matrix.dat
  EXPECT_EQ(least, -1024);
  EXPECT_EQ(most, 2986);
}

}  // namespace
}  // namespace scanknit
