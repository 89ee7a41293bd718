// A volume that is larger than its memory has the very bits of one that is not.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "fusion/bricks/paged_volume.h"
#include "fusion/integrate/integrate.h"
#include "fusion/volume/block_index.h"
#include "tests/core/temporary_folder.h"
#include "tests/fusion/small_world.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;

constexpr int kSteps = 40;
constexpr double kStep_m = 0.2;
constexpr CameraIntrinsics kPageCamera{160, 120, 130, 130, 79.5, 59.5};

struct Seen {
  Frame frame;
  Pose pose;
};

/// There and back over a floor with balls; half of them are gone on the way back.
std::vector<Seen> walk() {
  World there = World().add_wall({0, 0, 1}, 0), back = there;
  for (int i = 0; i < kSteps; ++i) {
    const Eigen::Vector3d centre(kStep_m * i, 0.05, 0.06);
    there.add_ball(centre, 0.06);
    if (i % 2 == 0) back.add_ball(centre, 0.06);
  }
  std::vector<Seen> seen;
  for (int i = 0; i < 2 * kSteps; ++i) {
    const bool is_back = i >= kSteps;
    Pose pose = looking_at_origin({0.3, 0.2, 0.7});
    pose.pretranslate(Eigen::Vector3d(kStep_m * (is_back ? 2 * kSteps - 1 - i : i), 0, 0));
    seen.push_back({look(is_back ? back : there, pose, /*has_colour=*/true, kPageCamera), pose});
  }
  return seen;
}

FusionConfig paged_fusion(bool carves, std::size_t budget_mib) {
  FusionConfig config;
  config.voxel_size_m = 0.005;
  config.carve_free_space = carves;
  config.memory_budget_mib = budget_mib;
  return config;
}

template <typename Leaf>
bool same_values(const Leaf& a, const Leaf& b) {
  return std::memcmp(a.buffer().data(), b.buffer().data(), kBlockVoxels * sizeof(typename Leaf::ValueType)) == 0 &&
         a.getValueMask() == b.getValueMask();
}

void expect_same(const TsdfVolume& paged, const TsdfVolume& whole) {
  ASSERT_EQ(paged.blocks(), whole.blocks());
  std::size_t differing = 0;
  for (const VolumeBlock& block : whole.index().blocks()) {
    const BlockIndex::Number number = paged.index().find(block.origin);
    ASSERT_NE(number, BlockIndex::kNone);
    const VolumeBlock& other = paged.index().blocks()[number];
    const bool has_colours = has_own_colours(*block.colour);
    const bool is_same = same_values(*block.tsdf, *other.tsdf) && same_values(*block.weight, *other.weight) &&
                         has_colours == has_own_colours(*other.colour) &&
                         (!has_colours || same_values(*block.colour, *other.colour)) && block.is_free == other.is_free;
    differing += is_same ? 0 : 1;
  }
  EXPECT_EQ(differing, 0u);
}

class Pages : public ::testing::TestWithParam<bool> {
 protected:
  TemporaryFolder folder_;
};

TEST_P(Pages, HoldTheBitsOfTheWholeVolume) {
  constexpr std::size_t kBudgetMib = 40;
  const std::vector<Seen> seen = walk();
  auto whole = TsdfVolume::create(paged_fusion(GetParam(), 1000));
  auto paged = PagedVolume::create(paged_fusion(GetParam(), kBudgetMib), folder_.path());
  ASSERT_TRUE(whole && paged);
  for (const Seen& one : seen) {
    ASSERT_TRUE(integrate(one.frame, one.pose, *whole));
    const auto integrated = paged->integrate(one.frame, one.pose);
    ASSERT_TRUE(integrated) << integrated.error().text();
    EXPECT_FALSE(integrated->is_budget_reached);
  }
  ASSERT_GT(whole->memory_bytes(), 2 * kBudgetMib << 20) << "else nothing is paged";
  const auto finished = paged->finish();
  ASSERT_TRUE(finished) << finished.error().text();
  const auto read = finished->read(-(1 << 20), 1 << 20);
  ASSERT_TRUE(read) << read.error().text();
  expect_same(*read, *whole);
}

INSTANTIATE_TEST_SUITE_P(CarvingOffOn, Pages, ::testing::Bool(), ::testing::PrintToStringParamName());

TEST(PagesOnTheDisk, ThatWereChangedAreRefused) {
  const TemporaryFolder folder;
  const std::vector<Seen> seen = walk();
  auto paged = PagedVolume::create(paged_fusion(true, 40), folder.path());
  ASSERT_TRUE(paged);
  Result<IntegrateStats> last = IntegrateStats{};
  for (std::size_t i = 0; i < seen.size() && last; ++i) {
    if (i == kSteps) {
      ASSERT_FALSE(fs::is_empty(folder.path()));
      for (const auto& page : fs::directory_iterator(folder.path())) {
        std::fstream file(page.path(), std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(200);
        file.put('\x5a').put('\x17').put('\x2b');
      }
    }
    last = paged->integrate(seen[i].frame, seen[i].pose);
  }
  ASSERT_FALSE(last);
  EXPECT_EQ(last.error().code, ErrorCode::kOutput) << last.error().text();
}

TEST(PagesOnTheDisk, AreOfNoUseForAFrameThatFillsTheMemory) {
  const TemporaryFolder folder;
  const std::vector<Seen> seen = walk();
  FusionConfig config = paged_fusion(true, 16);
  config.voxel_size_m = 0.002;
  auto paged = PagedVolume::create(config, folder.path());
  ASSERT_TRUE(paged) << paged.error().text();
  const auto integrated = paged->integrate(seen.front().frame, seen.front().pose);
  ASSERT_FALSE(integrated);
  EXPECT_EQ(integrated.error().code, ErrorCode::kBudget);
  EXPECT_NE(integrated.error().text().find("frame 1 "), std::string::npos) << integrated.error().text();
}

}  // namespace
}  // namespace scanknit::test
