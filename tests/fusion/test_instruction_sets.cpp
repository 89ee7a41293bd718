// Fusion and tracking give the same bits on every instruction set.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <vector>

#include "fusion/integrate/integrate.h"
#include "fusion/register/icp.h"
#include "fusion/register/picture_shift.h"
#include "fusion/register/surface_pyramid.h"
#include "fusion/track/raycast.h"
#include "fusion/volume/block_index.h"
#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using test::look;
using test::on_circle;
using test::small_camera;
using test::small_room;

struct Results {
  std::vector<float> distances;
  std::vector<WeightCode> weights;
  std::vector<ColourCode> colours;
  ModelView view;
  Eigen::Matrix4d T_model_frame, T_turn;
};

Results fuse_and_register() {
  FusionConfig config;
  config.voxel_size_m = 0.02;
  auto volume = TsdfVolume::create(config);
  EXPECT_TRUE(volume);
  for (const int step : {0, 4}) {
    EXPECT_TRUE(integrate(look(small_room(), on_circle(step)), on_circle(step), *volume));
  }
  Results results;
  for (const VolumeBlock& block : volume->index().blocks()) {
    for (openvdb::Index i = 0; i < TsdfLeaf::SIZE; ++i) {
      results.distances.push_back(block.tsdf->buffer().data()[i]);
      results.weights.push_back(block.weight->buffer().data()[i]);
      results.colours.push_back(colours_of(*block.colour)[i]);
    }
  }
  results.view = raycast(*volume, small_camera(), on_circle(2));
  const SurfacePyramid model = pyramid_of(results.view, config.noise);
  const SurfacePyramid seen = pyramid_of(look(small_room(), on_circle(3)), config.noise);
  results.T_turn = turn_by_shift(seen, model).matrix();
  results.T_model_frame = register_frame(seen, model, Pose::Identity(), {config.noise}).T_model_frame.matrix();
  return results;
}

TEST(InstructionSets, GiveTheSameBits) {
  const Results best = fuse_and_register();
  ASSERT_GT(best.distances.size(), 100'000u);
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    SCOPED_TRACE(hwy::TargetName(target));
    hwy::SetSupportedTargetsForTest(target);
    const Results other = fuse_and_register();
    EXPECT_EQ(other.distances, best.distances);
    EXPECT_EQ(other.weights, best.weights);
    EXPECT_EQ(other.colours, best.colours);
    EXPECT_EQ(other.view.depth_m, best.view.depth_m);
    EXPECT_EQ(other.view.normals, best.view.normals);
    EXPECT_EQ(other.view.intensity, best.view.intensity);
    EXPECT_EQ(other.T_turn, best.T_turn);
    EXPECT_EQ(other.T_model_frame, best.T_model_frame);
  }
  hwy::SetSupportedTargetsForTest(0);
}

}  // namespace
}  // namespace scanknit
