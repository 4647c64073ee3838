// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/nodes.h"

#include <cmath>

namespace ovoid::cpu {

namespace {

using Taps = std::array<double, kNodeTaps>;

// Lagrange's weights through all six: exact on polynomials of degree 5.
Taps lagrange(double t) {
  Taps taps{};
  for (int k = 0; k < kNodeTaps; ++k) {
    double weight = 1;
    for (int m = 0; m < kNodeTaps; ++m) {
      if (m != k) weight *= (t - (m - kTapsBefore)) / (k - m);
    }
    taps[static_cast<std::size_t>(k)] = weight;
  }
  return taps;
}

// The published filters, functions of the distance in nodes.
double published(PostConvolution how, double distance) {
  const double x = std::abs(distance);
  if (how == PostConvolution::kBilinear) return std::max(0.0, 1 - x);
  if (how == PostConvolution::kGaussian) return x < 2 ? std::exp(-2 * x * x) : 0.0;
  if (x < 1) return (1.5 * x - 2.5) * x * x + 1;  // Keys, a = -1/2
  return x < 2 ? ((-0.5 * x + 2.5) * x - 4) * x + 2 : 0.0;
}

Taps taps_at(PostConvolution how, double t) {
  if (how == PostConvolution::kAuto) return lagrange(t);
  Taps taps{};
  double sum = 0;
  for (int k = 0; k < kNodeTaps; ++k)
    sum += taps[static_cast<std::size_t>(k)] = published(how, k - kTapsBefore - t);
  for (double& weight : taps) weight /= sum;
  return taps;
}

}  // namespace

NodeSpan nodes_for(double pitch, int first_pixel, int last_pixel) {
  const auto first = static_cast<std::int64_t>(std::floor(first_pixel / pitch)) - kTapsBefore;
  const auto last = static_cast<std::int64_t>(std::floor(last_pixel / pitch)) - kTapsBefore;
  return {first, static_cast<int>(last - first) + kNodeTaps};
}

NodeWeights node_weights(PostConvolution how, double pitch, int first_pixel,
                         std::int64_t first_node) {
  NodeWeights weights{};
  const NodeSpan span = nodes_for(pitch, first_pixel, first_pixel + kTileSize - 1);
  weights.first = static_cast<int>(span.first - first_node);
  weights.count = span.count;
  for (int x = 0; x < kTileSize; ++x) {
    const double at = (first_pixel + x) / pitch;
    const double node = std::floor(at);
    const Taps taps = taps_at(how, at - node);
    const int row = static_cast<int>(static_cast<std::int64_t>(node) - kTapsBefore - span.first);
    weights.taps[static_cast<std::size_t>(x)] = weights.first + row;
    for (int k = 0; k < kNodeTaps; ++k)
      weights.weight[row + k][x] = static_cast<float>(taps[static_cast<std::size_t>(k)]);
  }
  for (std::size_t eight = 0; eight < weights.of_eight.size(); ++eight)
    weights.of_eight[eight] = {weights.taps[8 * eight] - weights.first,
                               weights.taps[8 * eight + 7] - weights.first + kNodeTaps};
  return weights;
}

}  // namespace ovoid::cpu
