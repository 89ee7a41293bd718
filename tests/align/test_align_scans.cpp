// Partial scans of one thing find their places, and scans of two sides of it find none.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Geometry>
#include <iostream>
#include <random>

#include "core/rotation.h"
#include "fusion/align/align_scans.h"
#include "fusion/range/range_surface.h"
#include "synth/render.h"
#include "synth/scene/camera_paths.h"
#include "synth/scene/scene.h"

namespace scanknit {
namespace {

constexpr CameraIntrinsics kCamera{320, 240, 380, 380, 159.5, 119.5};

/// A scan, and where its frame truly is.
struct PlacedScan {
  ScanModel model;
  Pose T_world_scan;
};

Pose random_pose(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> side(-1, 1);
  Pose pose = Pose::Identity();
  pose.linear() =
      Eigen::Quaterniond(side(random), side(random), side(random), side(random)).normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(side(random), side(random), side(random));
  return pose;
}

/// The figurine of the scene `turntable` as a camera sees it from one side, with a millimetre fifth of noise, in a
/// frame that is turned and moved at random.
PlacedScan scan_from(const SyntheticScene& scene, double azimuth_degrees, unsigned seed) {
  const double angle = azimuth_degrees * kDegree;
  const Pose T_world_camera = look_at({0.5 * std::cos(angle), 0.5 * std::sin(angle), 0.2}, Eigen::Vector3d::Zero());
  const RenderedView view = render(scene, kCamera, T_world_camera);
  std::mt19937 random(seed);
  std::normal_distribution<float> noise(0, 0.0002f);
  RangeScan scan;
  scan.points_m = Image<Eigen::Vector3f>(kCamera.width, kCamera.height, kNoReturn);
  for (int y = 0; y < kCamera.height; ++y) {
    for (int x = 0; x < kCamera.width; ++x) {
      const float z = view.depth_m.at(x, y);
      if (z > 0) scan.points_m.at(x, y) = kCamera.unproject(x, y, z + noise(random)).cast<float>();
    }
  }
  scan.sight = {.kind = SightLines::Kind::kSphere, .pole = 1};
  PlacedScan placed{model_of(scan, find_surface(scan)), Pose::Identity()};
  const Pose T_scan_camera = random_pose(seed);
  for (Eigen::Vector3f& p : placed.model.all.points_m) p = (T_scan_camera * p.cast<double>()).cast<float>();
  for (Eigen::Vector3f& n : placed.model.all.normals) n = (T_scan_camera.linear() * n.cast<double>()).cast<float>();
  placed.model.sights[0].T_scan_view = T_scan_camera;
  placed.model.name = std::to_string(azimuth_degrees);
  placed.T_world_scan = T_world_camera * T_scan_camera.inverse();
  return placed;
}

struct Scans {
  std::vector<ScanModel> models;
  std::vector<Pose> T_world_scan;
};

Scans scans_from(const std::vector<double>& azimuths, unsigned seed = 1) {
  const auto scene = make_scene("turntable");
  EXPECT_TRUE(scene);
  Scans scans;
  for (const double azimuth : azimuths) {
    PlacedScan scan = scan_from(**scene, azimuth, seed++);
    scans.models.push_back(std::move(scan.model));
    scans.T_world_scan.push_back(scan.T_world_scan);
  }
  return scans;
}

/// How far a scan's middle is from where it belongs, relative to the first scan, and by how much it is turned.
struct Off {
  double metres, degrees;
};
Off off_of(const Alignment& found, const Scans& truth, std::size_t scan) {
  const Pose T_0_found = found.T_world_scan[0].inverse() * found.T_world_scan[scan];
  const Pose T_0_true = truth.T_world_scan[0].inverse() * truth.T_world_scan[scan];
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3f& p : truth.models[scan].all.points_m) middle += p.cast<double>();
  middle /= static_cast<double>(truth.models[scan].all.size());
  const Pose between = T_0_true.inverse() * T_0_found;
  return {(between * middle - middle).norm(), Eigen::AngleAxisd(between.linear()).angle() / kDegree};
}

void print(const Alignment& alignment) {
  for (const AlignedPair& pair : alignment.pairs) {
    std::cout << pair.from << " " << pair.to << ": overlap " << pair.measure.overlap << ", residual "
              << 1000 * pair.measure.residual_m << " mm (spacing " << 1000 * alignment.scale.fine_m << "), in the way "
              << pair.measure.contradicted << ", missing " << pair.measure.missing << ", strength "
              << pair.measure.least_strength << ", " << to_string(pair.start) << ": "
              << to_string(pair.judgement.verdict) << " " << pair.judgement.reason << "\n";
  }
}

TEST(AlignScans, ThreePartialScansFromAnywhereAreWithin1mmAnd0p2Degrees) {
  const Scans scans = scans_from({0, 45, 90});
  const Alignment found = align_scans(scans.models, {}).value();
  print(found);
  for (std::size_t scan = 1; scan < 3; ++scan) {
    ASSERT_TRUE(found.is_placed[scan]);
    const Off off = off_of(found, scans, scan);
    std::cout << "scan " << scan << ": " << 1000 * off.metres << " mm, " << off.degrees << " degrees\n";
    EXPECT_LT(off.metres, 0.001);
    EXPECT_LT(off.degrees, 0.2);
  }
}

/// What truly overlaps, by the measure that the verdicts go by.
double true_overlap(const Scans& scans) {
  AlignPriors truth;
  for (const Pose& pose : scans.T_world_scan) truth.T_world_scan.emplace_back(pose);
  truth.are_final = true;
  return align_scans(scans.models, truth)->pairs.at(0).measure.overlap;
}

TEST(AlignScans, ThirtyPercentOverlapIsEnough) {
  const Scans scans = scans_from({0, 108}, 11);
  const double overlap = true_overlap(scans);
  std::cout << "overlap " << overlap << "\n";
  EXPECT_GT(overlap, 0.25);
  EXPECT_LT(overlap, 0.35);
  const Alignment found = align_scans(scans.models, {}).value();
  print(found);
  ASSERT_TRUE(found.is_placed[1]);
  const Off off = off_of(found, scans, 1);
  std::cout << 1000 * off.metres << " mm, " << off.degrees << " degrees\n";
  EXPECT_LT(off.metres, 0.001);
  EXPECT_LT(off.degrees, 0.2);
}

TEST(AlignScans, WithoutOverlapNothingIsPlaced) {
  // Its front and its back are nearly the same: these fit worst to best.
  for (const auto& [first, second] :
       {std::pair(0.0, 180.0), std::pair(45.0, 185.0), std::pair(90.0, 270.0), std::pair(105.0, 285.0)}) {
    const Scans scans = scans_from({first, second}, static_cast<unsigned>(first) + 21);
    const Alignment found = align_scans(scans.models, {}).value();
    print(found);
    EXPECT_FALSE(found.is_placed[1]);
    EXPECT_EQ(found.pairs.at(0).judgement.verdict, PairVerdict::kUnacceptable);
    EXPECT_FALSE(found.pairs.at(0).judgement.reason.empty());
  }
}

TEST(AlignScans, AScanOfSomethingElseIsRefused) {
  Scans scans = scans_from({0, 45}, 51);
  const auto other = make_scene("sphere");
  ASSERT_TRUE(other);
  PlacedScan ball = scan_from(**other, 0, 53);
  scans.models.push_back(std::move(ball.model));
  const Alignment found = align_scans(scans.models, {}).value();
  print(found);
  EXPECT_TRUE(found.is_placed[1]);
  EXPECT_FALSE(found.is_placed[2]);
}

// Two views of a ball fit in any turn of it.
TEST(AlignScans, WhatCouldSlideIsRefused) {
  const auto scene = make_scene("sphere");
  ASSERT_TRUE(scene);
  std::vector<ScanModel> models;
  for (const unsigned seed : {61u, 62u}) models.push_back(scan_from(**scene, 30.0 * (seed - 60u), seed).model);
  const Alignment found = align_scans(models, {}).value();
  print(found);
  EXPECT_FALSE(found.is_placed[1]);
}

// ... unless markers say how it is turned.
TEST(AlignScans, WhatCouldSlideIsHeldByMarkersAtBestAcceptably) {
  const auto scene = make_scene("sphere");
  ASSERT_TRUE(scene);
  Scans scans;
  for (const unsigned seed : {63u, 64u}) {
    PlacedScan scan = scan_from(**scene, 30.0 * (seed - 63u), seed);
    scans.models.push_back(std::move(scan.model));
    scans.T_world_scan.push_back(scan.T_world_scan);
  }
  AlignPriors markers;
  markers.T_from_to[{0, 1}] = scans.T_world_scan[0].inverse() * scans.T_world_scan[1];
  const Alignment held = align_scans(scans.models, markers).value();
  print(held);
  ASSERT_TRUE(held.is_placed[1]);
  EXPECT_EQ(held.pairs[0].judgement.verdict, PairVerdict::kAcceptable);
  EXPECT_NE(held.pairs[0].judgement.reason.find("held by the markers"), std::string::npos);
  const Off off = off_of(held, scans, 1);
  EXPECT_LT(off.metres, 0.001);
  EXPECT_LT(off.degrees, 0.2);

  // Poses that are only a beginning do not hold it; stated ones do.
  AlignPriors poses;
  for (const Pose& pose : scans.T_world_scan) poses.T_world_scan.emplace_back(pose);
  EXPECT_FALSE(align_scans(scans.models, poses)->is_placed[1]);
  poses.may_fix_motion = {true, true};
  EXPECT_TRUE(align_scans(scans.models, poses)->is_placed[1]);
}

TEST(AlignScans, PriorsAreRefinedAndTheWorldIsTheirs) {
  const Scans scans = scans_from({0, 60}, 71);
  AlignPriors priors;
  for (std::size_t i = 0; i < 2; ++i) {
    Pose off = scans.T_world_scan[i];
    if (i == 1) off = Eigen::Translation3d(0.004, -0.003, 0.002) * off;
    priors.T_world_scan.emplace_back(off);
  }
  const Alignment found = align_scans(scans.models, priors).value();
  print(found);
  ASSERT_TRUE(found.is_placed[1]);
  EXPECT_EQ(found.pairs.at(0).start, PairStart::kPrior);
  EXPECT_LT((found.T_world_scan[0].translation() - scans.T_world_scan[0].translation()).norm(), 1e-9);
  EXPECT_LT(off_of(found, scans, 1).metres, 0.001);
}

TEST(AlignScans, GivesTheSameBitsForAnyNumberOfThreads) {
  const Scans scans = scans_from({0, 50}, 81);
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return align_scans(scans.models, {})->T_world_scan[1].matrix();
  };
  const Eigen::Matrix4d one = with(1);
  EXPECT_EQ(one, with(2));
  EXPECT_EQ(one, with(8));
}

}  // namespace
}  // namespace scanknit
