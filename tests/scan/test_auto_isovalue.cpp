#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "scan/volume/auto_isovalue.h"

namespace scanknit {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

ValueSource source_of(const std::vector<float>& values) {
  return [&values](const auto& take) -> Result<void> {
    take(values);
    return {};
  };
}

std::vector<float> normal_values(float mean, float sigma, std::size_t count, std::mt19937& random) {
  std::normal_distribution<float> distribution(mean, sigma);
  std::vector<float> values(count);
  for (float& value : values) value = distribution(random);
  return values;
}

std::vector<float> two_classes() {
  std::mt19937 random(1);
  std::vector<float> values = normal_values(-1000, 30, 60'000, random);
  const std::vector<float> matter = normal_values(40, 30, 40'000, random);
  values.insert(values.end(), matter.begin(), matter.end());
  return values;
}

/// The threshold that Otsu's criterion, evaluated from its definition over all borders between values, likes best.
double between_class_variance(const std::vector<float>& values, double threshold) {
  double below = 0, below_sum = 0, above = 0, above_sum = 0;
  for (const float value : values) {
    (value < threshold ? below : above) += 1;
    (value < threshold ? below_sum : above_sum) += static_cast<double>(value);
  }
  if (below == 0 || above == 0) return 0;
  const double difference = above_sum / above - below_sum / below;
  return below * above * difference * difference;
}

TEST(AutoIsovalue, PartsTwoClassesBetweenThem) {
  const auto proposed = propose_isovalue(source_of(two_classes()));
  ASSERT_TRUE(proposed);
  EXPECT_GT(*proposed, -850);
  EXPECT_LT(*proposed, -110);
}

TEST(AutoIsovalue, IsAsGoodByOtsusCriterionAsAnyThreshold) {
  std::mt19937 random(2);
  std::vector<float> values = normal_values(0, 1, 3000, random);
  const std::vector<float> more = normal_values(3, 0.7f, 1000, random);  // the classes overlap
  values.insert(values.end(), more.begin(), more.end());
  const auto proposed = propose_isovalue(source_of(values));
  ASSERT_TRUE(proposed);
  double best = 0;
  for (int step = -300; step <= 600; ++step) best = std::max(best, between_class_variance(values, step / 100.0));
  constexpr double kOutliersAndBins = 0.995;
  EXPECT_GE(between_class_variance(values, *proposed), kOutliersAndBins * best);
}

TEST(AutoIsovalue, OfAMaskIsHalfWay) {
  std::vector<float> mask(1000, 0);
  std::fill(mask.begin(), mask.begin() + 300, 1.0f);
  const auto proposed = propose_isovalue(source_of(mask));
  ASSERT_TRUE(proposed);
  EXPECT_NEAR(*proposed, 0.5, 1e-3);
}

TEST(AutoIsovalue, SeesAnObjectOfAFewVoxels) {
  std::vector<float> values(100'000, 5);
  values[17] = 9;
  const auto proposed = propose_isovalue(source_of(values));
  ASSERT_TRUE(proposed);
  EXPECT_NEAR(*proposed, 7, 0.01);
}

TEST(AutoIsovalue, IsNotMovedByOutliersNaNAndInfinity) {
  std::vector<float> values = two_classes();
  const auto before = propose_isovalue(source_of(values));
  values.insert(values.end(), {1e30f, -1e30f, kNaN, std::numeric_limits<float>::infinity()});
  const auto after = propose_isovalue(source_of(values));
  ASSERT_TRUE(before && after);
  EXPECT_NEAR(*after, *before, 60);  // two sigmas, in a gap of a thousand
}

TEST(AutoIsovalue, OfOneValueOrNoneIsAnError) {
  const auto expect_refused = [](const std::vector<float>& values, const char* part) {
    const auto proposed = propose_isovalue(source_of(values));
    ASSERT_FALSE(proposed);
    EXPECT_EQ(proposed.error().code, ErrorCode::kInput);
    EXPECT_NE(proposed.error().message.find(part), std::string::npos) << proposed.error().message;
  };
  expect_refused(std::vector<float>(100, 7), "extract.isovalue");
  expect_refused({}, "not one finite sample");
  expect_refused({kNaN, std::numeric_limits<float>::infinity()}, "not one finite sample");
}

TEST(ValueCensus, KnowsCountMinimumAndMaximum) {
  ValueCensus census;
  census.add(std::vector<float>{3, kNaN, -2});
  census.add(std::vector<float>{0.5f});
  EXPECT_EQ(census.count(), 3u);
  EXPECT_EQ(census.min(), -2);
  EXPECT_EQ(census.max(), 3);
}

TEST(ValueCensus, LeavesOutTheShareAtBothEnds) {
  std::vector<float> values;
  for (int i = -500; i <= 500; ++i) values.push_back(static_cast<float>(i));
  values[0] = -1e20f;
  values[1000] = 1e20f;
  ValueCensus census;
  census.add(values);
  const auto [low, high] = census.without_outliers(0.01);
  EXPECT_NEAR(low, -490, 5);
  EXPECT_NEAR(high, 490, 5);
}

TEST(Histogram, HoldsBothEndsOfItsRangeAndNothingBeyond) {
  Histogram histogram{10, 20, {}};
  histogram.add(std::vector<float>{10, 20, 9.99f, 20.01f, kNaN});
  EXPECT_EQ(histogram.counts.front(), 1u);
  EXPECT_EQ(histogram.counts.back(), 1u);
}

}  // namespace
}  // namespace scanknit
