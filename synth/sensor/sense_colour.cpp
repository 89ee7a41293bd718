#include "synth/sensor/sense_colour.h"

#include <tbb/parallel_for.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/counter_random.h"

namespace scanknit {
namespace {

std::uint8_t to_byte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

Eigen::Vector3d values(const Rgb8& colour) {
  return {static_cast<double>(colour.r), static_cast<double>(colour.g), static_cast<double>(colour.b)};
}

/// Factors for the three channels that take the picture's mean brightness to a middle grey, and its colours to grey.
Eigen::Vector3d gains(const ColourImage& picture, const ColourModel& model) {
  constexpr double kMiddleGrey = 110;  // of 255
  constexpr double kHighestGain = 4;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double lit = 0;
  for (const Rgb8& colour : picture.pixels()) {
    sum += values(colour);
    lit += colour == Rgb8{} ? 0 : 1;  // black where there is no surface: not a part of the scene
  }
  if (!(lit > 0) || !(sum.minCoeff() > 0)) return Eigen::Vector3d::Ones();
  const Eigen::Vector3d mean = sum / lit;
  const double gain = std::pow(kMiddleGrey / mean.mean(), model.adaptation);
  Eigen::Vector3d factors;
  for (int c = 0; c < 3; ++c) factors[c] = gain * std::pow(mean.mean() / mean[c], model.white_balance);
  return factors.cwiseMax(1 / kHighestGain).cwiseMin(kHighestGain);
}

}  // namespace

ColourImage blurred(const std::vector<ColourImage>& moments) {
  SCANKNIT_CHECK(!moments.empty());
  if (moments.size() == 1) return moments.front();
  const auto count = static_cast<double>(moments.size());
  ColourImage mean(moments.front().width(), moments.front().height());
  tbb::parallel_for(0, mean.height(), [&](int y) {
    for (int x = 0; x < mean.width(); ++x) {
      Eigen::Vector3d light = Eigen::Vector3d::Zero();
      for (const ColourImage& moment : moments) light += values(moment.at(x, y)).cwiseAbs2();
      const Eigen::Vector3d value = (light / count).cwiseSqrt();
      mean.at(x, y) = {to_byte(value.x()), to_byte(value.y()), to_byte(value.z())};
    }
  });
  return mean;
}

ColourImage sense_colour(const ColourImage& exact, const ColourModel& model, std::uint64_t seed, std::uint64_t frame) {
  if (model.adaptation == 0 && model.white_balance == 0 && model.noise == 0) return exact;
  constexpr std::uint64_t kColourStream = 0xC0'10E5;
  const Eigen::Vector3d factors = gains(exact, model);
  ColourImage sensed(exact.width(), exact.height());
  tbb::parallel_for(0, exact.height(), [&](int y) {
    for (int x = 0; x < exact.width(); ++x) {
      const auto pixel =
          static_cast<std::uint64_t>(y) * static_cast<std::uint64_t>(exact.width()) + static_cast<std::uint64_t>(x);
      CounterRandom random(seed, mix64(kColourStream) + frame, pixel);
      Eigen::Vector3d value = values(exact.at(x, y)).cwiseProduct(factors);
      if (model.noise > 0) {
        for (int c = 0; c < 3; ++c) value[c] += 255 * model.noise * std::sqrt(factors[c]) * random.gaussian();
      }
      sensed.at(x, y) = {to_byte(value.x()), to_byte(value.y()), to_byte(value.z())};
    }
  });
  return sensed;
}

}  // namespace scanknit
