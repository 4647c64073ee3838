// SPDX-License-Identifier: Apache-2.0
#include "render/reference/post_convolution.h"

#include <cassert>
#include <cmath>

namespace ovoid::reference {
namespace {

// Not normalized; `x` the distance in coarse samples.
double filter(PostConvolution how, double x) {
  switch (how) {
    case PostConvolution::kBilinear:
      return x < 1 ? 1 - x : 0;
    case PostConvolution::kGaussian:
      return x < 2 ? std::exp(-2 * x * x) : 0;
    case PostConvolution::kCubic:  // [Keys 1981], a = -1/2
      if (x < 1) return 1.5 * x * x * x - 2.5 * x * x + 1;
      return x < 2 ? -0.5 * x * x * x + 2.5 * x * x - 4 * x + 2 : 0;
    default:
      break;
  }
  assert(false && "not a published way");
  return 0;
}

}  // namespace

FilterTaps taps_at(PostConvolution how, double place) {
  FilterTaps taps{static_cast<std::int64_t>(std::floor(place)) - 2};
  double sum = 0;
  for (std::size_t k = 0; k < taps.weight.size(); ++k) {
    const double number = static_cast<double>(taps.first) + static_cast<double>(k);
    taps.weight[k] = filter(how, std::abs(place - number));
    sum += taps.weight[k];
  }
  for (double& weight : taps.weight) weight /= sum;
  return taps;
}

}  // namespace ovoid::reference
