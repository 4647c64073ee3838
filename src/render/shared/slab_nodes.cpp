// SPDX-License-Identifier: Apache-2.0
#include "render/shared/slab_nodes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ovoid {
namespace {

// On [-1/2, 1/2], by Newton's method on the Legendre polynomials.
SlabNodes gauss_legendre(int count) {
  SlabNodes nodes;
  nodes.count = count;
  for (int i = 0; i < count; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5));
    double slope = 1;
    for (int step = 0; step < 20; ++step) {
      double p = 1;
      double before = 0;
      for (int n = 0; n < count; ++n) {
        const double next = ((2 * n + 1) * x * p - n * before) / (n + 1);
        before = p;
        p = next;
      }
      slope = count * (x * p - before) / (x * x - 1);
      x -= p / slope;
    }
    nodes.nodes[static_cast<std::size_t>(i)] = {
        static_cast<float>(x / 2), static_cast<float>(1 / ((1 - x * x) * slope * slope))};
  }
  return nodes;
}

}  // namespace

// Four per two sigmas of the narrowest kernel.
SlabNodes slab_nodes(const LatticeField& field, const view::ViewLattice& lattice) {
  double longest = 0;  // slab in index units
  const view::SheetMap here = lattice.index_map(0);
  const view::SheetMap next = lattice.index_map(1);
  for (const double x : {0.0, lattice.width() - 1.0}) {
    for (const double y : {0.0, lattice.height() - 1.0}) {
      longest = std::max(longest, (next.at(x, y) - here.at(x, y)).norm());
    }
  }
  return gauss_legendre(std::clamp(
      2 + static_cast<int>(std::ceil(2 * longest / field.index_kernel().sigma)), 4, kMaxSlabNodes));
}

}  // namespace ovoid
