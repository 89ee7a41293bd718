// Signs of samples, and all that is built on them, are the same bits for every instruction set.
#include "extract/blocks/sign_bytes.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <vector>

#include "tests/extract/volumes.h"
#include "tests/support/instruction_sets.h"

namespace scanknit {
namespace {

using test::for_each_instruction_set;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kDenormal = std::numeric_limits<float>::denorm_min();
constexpr std::size_t kGroup = 8;

struct Signs {
  std::vector<std::uint8_t> high;
  std::vector<std::uint8_t> missing;
  bool operator==(const Signs&) const = default;
};

Signs signs_of(const std::vector<float>& samples, float isovalue) {
  const std::size_t groups = samples.size() / kGroup;
  Signs signs{std::vector<std::uint8_t>(groups, 0xAA), std::vector<std::uint8_t>(groups, 0x55)};
  sign_bytes(samples.data(), groups, isovalue, signs.high.data(), signs.missing.data());
  return signs;
}

Signs expected_signs(const std::vector<float>& samples, float isovalue) {
  Signs signs{std::vector<std::uint8_t>(samples.size() / kGroup), std::vector<std::uint8_t>(samples.size() / kGroup)};
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto bit = static_cast<std::uint8_t>(1u << (i % kGroup));
    const bool is_finite = std::isfinite(samples[i]);
    if (!is_finite) signs.missing[i / kGroup] |= bit;
    if (is_finite && samples[i] >= isovalue) signs.high[i / kGroup] |= bit;
  }
  return signs;
}

/// Every kind of float in every one of the eight places.
std::vector<float> mixed_samples(std::size_t groups, unsigned seed) {
  const std::array<float, 16> special{0.0f,
                                      -0.0f,
                                      test::kNaN,
                                      -test::kNaN,
                                      kInfinity,
                                      -kInfinity,
                                      kDenormal,
                                      -kDenormal,
                                      std::numeric_limits<float>::min(),
                                      -std::numeric_limits<float>::min(),
                                      std::numeric_limits<float>::max(),
                                      std::numeric_limits<float>::lowest(),
                                      1.0f,
                                      std::nextafter(1.0f, 0.0f),
                                      std::nextafter(1.0f, 2.0f),
                                      std::numeric_limits<float>::signaling_NaN()};
  std::mt19937 random(seed);
  std::vector<float> samples(kGroup * groups);
  for (float& sample : samples) {
    const auto bits = static_cast<std::uint32_t>(random());
    sample = random() % 2 == 0 ? special[bits % special.size()] : std::bit_cast<float>(bits);
  }
  return samples;
}

TEST(SignBytes, AreThoseOfOneComparisonAfterTheOther) {
  const std::vector<float> samples = mixed_samples(1000, 1);
  for_each_instruction_set([&] {
    for (const float isovalue : {0.0f, -0.0f, 1.0f, -1.0f, kDenormal, -kDenormal, 3e38f, kInfinity, -kInfinity})
      EXPECT_EQ(signs_of(samples, isovalue), expected_signs(samples, isovalue)) << isovalue;
  });
}

TEST(SignBytes, TakeAnyNumberOfGroups) {
  for_each_instruction_set([] {
    for (std::size_t groups = 0; groups < 20; ++groups) {
      const std::vector<float> samples = mixed_samples(groups, 2);
      EXPECT_EQ(signs_of(samples, 0.5f), expected_signs(samples, 0.5f)) << groups;
    }
  });
}

TEST(SignBytes, TakeSamplesThatAreNotAligned) {
  const std::vector<float> samples = mixed_samples(10, 3);
  for_each_instruction_set([&] {
    for (std::size_t shift = 0; shift < kGroup; ++shift) {
      const auto first = samples.begin() + static_cast<std::ptrdiff_t>(shift);
      const std::vector<float> shifted(first, first + 9 * kGroup);
      Signs signs{std::vector<std::uint8_t>(9), std::vector<std::uint8_t>(9)};
      sign_bytes(samples.data() + shift, 9, 0, signs.high.data(), signs.missing.data());
      EXPECT_EQ(signs, expected_signs(shifted, 0)) << shift;
    }
  });
}

TEST(SignBytes, MinusZeroIsHighAtIsovalueZero) {
  const std::vector<float> samples(kGroup, -0.0f);
  for_each_instruction_set([&] { EXPECT_EQ(signs_of(samples, 0).high[0], 0xFF); });
}

TEST(SignBytes, DenormalsAreNotFlushedToZero) {
  const std::vector<float> samples{kDenormal, -kDenormal, 0, -0.0f, kDenormal, -kDenormal, 0, -0.0f};
  for_each_instruction_set([&] {
    EXPECT_EQ(signs_of(samples, 0).high[0], 0b11011101);
    EXPECT_EQ(signs_of(samples, kDenormal).high[0], 0b00010001);
  });
}

TEST(SignBytes, MeshIsTheSameForEveryInstructionSet) {
  test::Box box({37, 18, 11});
  const test::Dense noise = test::white_noise(37, 4);
  std::copy_n(noise.samples.begin(), box.samples.size(), box.samples.begin());
  for (std::size_t i = 0; i < box.samples.size(); i += 41) box.samples[i] = test::kNaN;
  const Mesh expected = test::extract(box).mesh;
  ASSERT_FALSE(expected.empty());
  for_each_instruction_set([&] { test::expect_same_bits(test::extract(box).mesh, expected); });
}

}  // namespace
}  // namespace scanknit
