#include "scan/refine/track_alone.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "tests/fusion/small_world.h"

namespace scanknit {
namespace {

using test::on_circle;

constexpr double kInterval_s = 1.0 / 30;
constexpr double kReadout_s = 0.9 * kInterval_s;
constexpr std::size_t kFrames = 8;

/// 90 degrees a second round the small room, taken with a rolling shutter.
class TurningCamera final : public FrameSource {
 public:
  [[nodiscard]] static FrameMotion motion() {
    return {SteadyMotion::from(on_circle(0).inverse() * on_circle(1)) * (kReadout_s / kInterval_s), {}};
  }
  [[nodiscard]] const RecordingInfo& info() const override { return info_; }
  [[nodiscard]] FrameEvent next(std::stop_token /*stop*/) override {
    if (next_ == kFrames) return EndOfStream{};
    const Pose pose = on_circle(static_cast<int>(next_));
    Frame frame = test::look(test::small_room(), pose, true, test::small_camera(), motion().rows);
    frame.sequence = next_;
    frame.has_clock = true;
    frame.timestamp_ns = static_cast<std::int64_t>((1 + static_cast<double>(next_++) * kInterval_s) * 1e9);
    return frame;
  }

 private:
  RecordingInfo info_;
  std::size_t next_ = 0;
};

/// Of the last frame, in the axes of the first.
double error_m(const FrameMotion& first) {
  ScanConfig config;
  config.fusion.voxel_size_m = 0.02;
  config.acquire.readout_s = kReadout_s;
  TurningCamera camera;
  std::vector<std::uint64_t> sequences(kFrames);
  std::iota(sequences.begin(), sequences.end(), 0);
  const auto poses = track_alone(camera, sequences, first, config, {});
  EXPECT_TRUE(poses && poses->size() == kFrames);
  if (!poses || poses->size() != kFrames) return 1;
  return test::distance_m(poses->back(), on_circle(0).inverse() * on_circle(kFrames - 1));
}

TEST(TrackAlone, TakesTheMotionOutOfTheFirstFrameToo) {
  const double with_m = error_m(TurningCamera::motion());
  EXPECT_LT(with_m, 0.001) << "a twentieth of a voxel";
  EXPECT_GT(error_m({}), 5 * with_m) << "else the first frame's shutter is not seen in this test";
}

}  // namespace
}  // namespace scanknit
