// The estimate of a job: what follows from its plan and from measured costs.
#include "scan/job/job_estimate.h"

#include <gtest/gtest.h>

#include "fusion/volume/volume_memory.h"
#include "scan/job/job_costs.h"

namespace scanknit::test {
namespace {

/// Bricks of one region in a row; frame n sees brick n and those beside it.
PlannedScan planned_row(int bricks) {
  PlannedScan planned;
  planned.fusion.memory_budget_mib = 4096;
  planned.trajectory.resize(static_cast<std::size_t>(bricks));
  for (int i = 0; i < bricks; ++i) {
    BrickPart part;
    const openvdb::Coord region(i * kRegionVoxels, 0, 0);
    part.regions.insert(region);
    part.frames = {{static_cast<std::uint32_t>(std::max(1, i)), static_cast<std::uint32_t>(std::min(bricks, i + 2))}};
    VolumeMemory memory;
    for (std::size_t block = 0; block < 10; ++block) memory.add(block_of(region, block));
    part.most_bytes = memory.most_bytes();
    planned.parts.push_back(part);
  }
  return planned;
}

JobCosts some_costs() {
  JobCosts costs;
  costs.plan_s = 3;
  costs.start_s = 0.5;
  costs.frame_s = 2;
  costs.frame_bytes = 1000;
  costs.update_s = 0.1;
  costs.join_start_s = 4;
  costs.join_s_per_byte = 0.01;
  costs.bytes_per_block = 100;
  return costs;
}

TEST(JobEstimate, CountsTheBlocksThatAPlanGivesToABrick) {
  for (const BrickPart& part : planned_row(3).parts) EXPECT_EQ(planned_blocks(part), 10u);
}

TEST(JobEstimate, ABrickTakesItsFramesAndItsUpdates) {
  const JobEstimate all = estimate(planned_row(5), some_costs(), 0);
  ASSERT_EQ(all.bricks.size(), 5u);
  EXPECT_EQ(all.bricks[0].frames, 2u);
  EXPECT_EQ(all.bricks[2].frames, 3u);
  EXPECT_DOUBLE_EQ(all.bricks[2].s, 3 * 2 + 0.1 * 3 * 10);
  EXPECT_DOUBLE_EQ(all.bricks[2].bytes, 1000);
  EXPECT_EQ(all.seams, 4u);
  EXPECT_DOUBLE_EQ(all.seam.s, (13 - 5) * 2.0 / 4) << "13 readings of 5 frames";
}

TEST(JobEstimate, OneWorkerThatKnowsItIsAloneReadsEachFrameOnce) {
  const JobEstimate single = estimate(planned_row(5), some_costs(), 0),
                    at_once = estimate(planned_row(5), some_costs(), 1);
  const double updates_s = 0.1 * 13 * 10;
  EXPECT_DOUBLE_EQ(single.work_s, 0.5 + 13 * 2 + updates_s);
  EXPECT_DOUBLE_EQ(at_once.work_s, 0.5 + 5 * 2 + updates_s);
  EXPECT_DOUBLE_EQ(at_once.join_s, 0.5 + 4 + at_once.join_s_per_byte * 5000);
  EXPECT_DOUBLE_EQ(at_once.wall_s, 3 + at_once.work_s + at_once.join_s) << "nothing is at once";
}

TEST(JobEstimate, MoreWorkersTakeLessTimeAndMoreOfTheProcessors) {
  JobEstimate before = estimate(planned_row(64), some_costs(), 1);
  for (const std::size_t workers : {2u, 4u, 16u, 64u}) {
    const JobEstimate now = estimate(planned_row(64), some_costs(), workers);
    EXPECT_LT(now.wall_s, before.wall_s);
    EXPECT_GT(now.work_s, before.work_s) << "frames are read by several of them";
    EXPECT_GE(static_cast<double>(workers) * (now.wall_s - now.plan_s - now.join_s), now.work_s * (1 - 1e-9));
    before = now;
  }
}

}  // namespace
}  // namespace scanknit::test
