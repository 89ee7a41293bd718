#include <gtest/gtest.h>
#include <openvdb/io/File.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <vector>

#include "core/files/read_file.h"
#include "fusion/integrate/integrate.h"
#include "fusion/volume/block_index.h"
#include "fusion/volume/tsdf_volume.h"
#include "fusion/volume/volume_memory.h"
#include "tests/fusion/analytic_frames.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

class VolumeFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(::testing::TempDir()) / ("scanknit_volume_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  static TsdfVolume small_volume() {
    FusionConfig config;
    config.voxel_size_m = 0.02;
    auto volume = TsdfVolume::create(config);
    Frame frame = test::plane_frame(test::small_camera(), {0, 0, -1}, -0.8);
    frame.colour = ColourFrame{ColourImage(160, 120, Rgb8{255, 0, 51}), test::small_camera(), Pose::Identity()};
    EXPECT_TRUE(integrate(frame, Pose::Identity(), volume.value()));
    return std::move(volume).value();
  }

  fs::path folder_;
};

TEST_F(VolumeFile, GivesBackTheThreeGrids) {
  const TsdfVolume volume = small_volume();
  ASSERT_TRUE(volume.save(folder_ / "volume.vdb"));
  const auto loaded = load_volume(folder_ / "volume.vdb");
  ASSERT_TRUE(loaded) << loaded.error().text();
  ASSERT_TRUE(loaded->weight);
  ASSERT_TRUE(loaded->colour);
  EXPECT_TRUE(loaded->is_signed_distance);
  EXPECT_EQ(loaded->field->activeVoxelCount(), volume.active_voxels());
  EXPECT_EQ(loaded->field->transform(), volume.tsdf().transform());
  const auto field = loaded->field->getConstAccessor();
  const auto colour = loaded->colour->getConstAccessor();
  const auto weight = loaded->weight->getConstAccessor();
  for (auto voxel = volume.tsdf().cbeginValueOn(); voxel; ++voxel) {
    ASSERT_EQ(field.getValue(voxel.getCoord()), *voxel);
    const Voxel original = volume.voxel(voxel.getCoord());
    ASSERT_EQ(weight.getValue(voxel.getCoord()), original.weight);
    const openvdb::Vec3s loaded_colour = colour.getValue(voxel.getCoord());
    if (original.colour) {
      ASSERT_EQ(loaded_colour, openvdb::Vec3s(original.colour->r, original.colour->g, original.colour->b) / 255.0f);
    } else {
      ASSERT_LT(loaded_colour.x(), 0);
    }
  }
}

TEST_F(VolumeFile, IsTheSameBytesEachTimeButForItsUniqueId) {
  const TsdfVolume volume = small_volume();
  ASSERT_TRUE(volume.save(folder_ / "a.vdb"));
  ASSERT_TRUE(volume.save(folder_ / "b.vdb"));
  const auto a = read_text_file(folder_ / "a.vdb", 1u << 28);
  const auto b = read_text_file(folder_ / "b.vdb", 1u << 28);
  ASSERT_TRUE(a && b);
  // OpenVDB's header: magic number 8 bytes, version 4, library version 8, flag 1, then the id as 36 characters.
  constexpr std::size_t kAfterTheId = 8 + 4 + 8 + 1 + 36;
  ASSERT_GT(a->size(), kAfterTheId);
  EXPECT_EQ(a->substr(kAfterTheId), b->substr(kAfterTheId));
}

TEST_F(VolumeFile, ReadsALevelSetOfAnotherProgram) {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(3.0f);
  grid->setName("surface");
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  grid->tree().setValue(openvdb::Coord(1, 2, 3), -1.0f);
  openvdb::io::File((folder_ / "other.vdb").string()).write({grid});
  const auto loaded = load_volume(folder_ / "other.vdb");
  ASSERT_TRUE(loaded) << loaded.error().text();
  EXPECT_TRUE(loaded->is_signed_distance);
  EXPECT_FALSE(loaded->weight);
  EXPECT_EQ(loaded->field->activeVoxelCount(), 1u);
}

TEST_F(VolumeFile, NamesTheGridsWhenNoneIsOfFloats) {
  openvdb::initialize();
  auto grid = openvdb::BoolGrid::create(false);
  grid->setName("mask");
  openvdb::io::File((folder_ / "mask.vdb").string()).write({grid});
  const auto loaded = load_volume(folder_ / "mask.vdb");
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kInput);
  EXPECT_NE(loaded.error().message.find("mask (bool)"), std::string::npos) << loaded.error().message;
}

TEST_F(VolumeFile, RefusesWhatIsNotThere) {
  const auto loaded = load_volume(folder_ / "nothing.vdb");
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kInput);
}

TEST_F(VolumeFile, RefusesATextFile) {
  std::ofstream(folder_ / "text.vdb") << "this is not a volume";
  const auto loaded = load_volume(folder_ / "text.vdb");
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kInput);
}

TEST_F(VolumeFile, RefusesATruncatedFile) {
  ASSERT_TRUE(small_volume().save(folder_ / "whole.vdb"));
  const auto size = fs::file_size(folder_ / "whole.vdb");
  for (int tenth = 0; tenth < 10; ++tenth) {
    const fs::path path = folder_ / "part.vdb";
    fs::copy_file(folder_ / "whole.vdb", path, fs::copy_options::overwrite_existing);
    fs::resize_file(path, size * static_cast<std::uintmax_t>(tenth) / 10);
    const auto loaded = load_volume(path);
    ASSERT_FALSE(loaded) << tenth;
    EXPECT_EQ(loaded.error().code, ErrorCode::kInput);
  }
}

/// Peak resident memory so far of this process and of its children, bytes.
std::size_t peak_memory_bytes() {
  constexpr std::size_t kKibibyte = 1024;  // Linux counts these
  rusage own{}, children{};
  getrusage(RUSAGE_SELF, &own);
  getrusage(RUSAGE_CHILDREN, &children);
  return static_cast<std::size_t>(std::max(own.ru_maxrss, children.ru_maxrss)) * kKibibyte;
}

TEST_F(VolumeFile, DamagedAnywhereIsReadOrRefusedInLittleMemory) {
  ASSERT_TRUE(small_volume().save(folder_ / "whole.vdb"));
  const auto whole = read_file(folder_ / "whole.vdb", 1u << 24);
  ASSERT_TRUE(whole);
  const std::size_t before = peak_memory_bytes();
  std::mt19937 random(34);
  int refused = 0;
  for (int copy = 0; copy < 300; ++copy) {
    std::vector<std::byte> damaged = *whole;
    const std::size_t part = copy % 2 == 0 ? damaged.size() : damaged.size() / 16;  // counts lie near the beginning
    for (int flips = 1 + copy % 4; flips > 0; --flips) {
      damaged[random() % part] ^= static_cast<std::byte>(1u << (random() % 8));
    }
    const fs::path path = folder_ / "damaged.vdb";
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(damaged.data()), static_cast<std::streamsize>(damaged.size()));
    const auto loaded = load_volume(path);
    if (loaded) continue;
    ++refused;
    EXPECT_EQ(loaded.error().code, ErrorCode::kInput) << loaded.error().text();
    EXPECT_EQ(loaded.error().where, path.string());
  }
  EXPECT_GT(refused, 50);
  EXPECT_LT(peak_memory_bytes() - before, std::size_t{512} << 20);
}

TEST_F(VolumeFile, KeepsTheOldFileWhenTheNewOneCannotBeWritten) {
  const fs::path below_a_file = folder_ / "file" / "volume.vdb";
  std::ofstream(folder_ / "file") << "x";
  const auto saved = small_volume().save(below_a_file);
  ASSERT_FALSE(saved);
  EXPECT_EQ(saved.error().code, ErrorCode::kOutput);
}

/// A wall before each side of the origin, so that inner nodes on all sides of it are needed.
TsdfVolume walls_all_round(const FusionConfig& config, bool are_coloured = false) {
  auto volume = TsdfVolume::create(config);
  EXPECT_TRUE(volume);
  for (const double turn : {0.0, 1.6, 3.1, 4.7}) {
    const Pose pose(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()));
    Frame wall = test::plane_frame(test::small_camera(), {0, 0, -1}, -0.8);
    if (are_coloured)
      wall.colour = ColourFrame{ColourImage(160, 120, Rgb8{255, 0, 51}), test::small_camera(), Pose::Identity()};
    EXPECT_TRUE(integrate(wall, pose, volume.value()));
  }
  return std::move(volume).value();
}

std::size_t counted_by_openvdb(const TsdfVolume& volume) {
  return volume.tsdf().memUsage() + volume.weight().memUsage() + volume.colour().memUsage();
}

TEST(VolumeMemory, IsWhatOpenVdbCountsAndTheIndex) {
  for (const double voxel_size_m : {0.004, 0.02}) {
    for (const bool are_coloured : {false, true}) {
      FusionConfig config;
      config.voxel_size_m = voxel_size_m;
      const TsdfVolume volume = walls_all_round(config, are_coloured);
      const auto counted = static_cast<double>(counted_by_openvdb(volume));
      const auto told = static_cast<double>(volume.memory_bytes());
      EXPECT_GE(told, counted) << voxel_size_m << are_coloured;
      EXPECT_LE(told, 1.1 * counted) << voxel_size_m << are_coloured;
    }
  }
}

TEST(VolumeMemory, IsTakenForColoursWhereSomeWereSeen) {
  const auto share_with_colours = [](const TsdfVolume& volume) {
    const auto blocks = volume.index().blocks();
    const auto with = std::count_if(blocks.begin(), blocks.end(),
                                    [](const VolumeBlock& block) { return has_own_colours(*block.colour); });
    return static_cast<double>(with) / static_cast<double>(blocks.size());
  };
  FusionConfig config;
  TsdfVolume volume = walls_all_round(config);
  EXPECT_EQ(share_with_colours(volume), 0);
  volume = walls_all_round(config, /*are_coloured=*/true);
  EXPECT_GT(share_with_colours(volume), 0.3);
  EXPECT_LT(share_with_colours(volume), 0.9);  // in front of the inner half of the band there are none
}

TEST(VolumeMemory, ReadsAsNoColourWhereNoneIs) {
  const TsdfVolume volume = walls_all_round(FusionConfig());
  const auto colours = volume.colour().getConstAccessor();  // it has memory made for them
  for (const VolumeBlock& block : volume.index().blocks()) {
    for (openvdb::Index i = 0; i < ColourLeaf::SIZE; ++i) {
      ASSERT_FALSE(has_colour(colours_of(*block.colour)[i]));
      ASSERT_FALSE(has_colour(colours.getValue(block.tsdf->offsetToGlobalCoord(i))));
    }
  }
}

TEST(VolumeMemory, KeepsWithinSmallBudgets) {
  for (const std::size_t budget_mib : {8, 9, 10, 15, 20}) {
    FusionConfig config;
    config.memory_budget_mib = budget_mib;
    const TsdfVolume volume = walls_all_round(config);
    EXPECT_TRUE(volume.is_budget_reached) << budget_mib;
    EXPECT_GT(volume.active_voxels(), 0u) << budget_mib;
    EXPECT_LE(counted_by_openvdb(volume), budget_mib << 20) << budget_mib;
    EXPECT_LE(volume.memory_bytes(), budget_mib << 20) << budget_mib;
  }
}

TEST(VolumeMemory, RefusesABudgetThatHoldsNothingAndNamesTheLeast) {
  FusionConfig config;
  config.memory_budget_mib = 7;
  const auto volume = TsdfVolume::create(config);
  ASSERT_FALSE(volume);
  EXPECT_EQ(volume.error().code, ErrorCode::kConfig);
  EXPECT_NE(volume.error().message.find("expected 8 MiB or more"), std::string::npos) << volume.error().message;
}

TEST(FusionVolume, RefusesAVoxelSizeOfZero) {
  FusionConfig config;
  config.voxel_size_m = 0;
  const auto volume = TsdfVolume::create(config);
  ASSERT_FALSE(volume);
  EXPECT_EQ(volume.error().code, ErrorCode::kConfig);
}

}  // namespace
}  // namespace scanknit
