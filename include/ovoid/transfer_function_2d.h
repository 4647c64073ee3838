// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/transfer_function.h"

namespace OVOID_API ovoid {

// A part of the plane of value and gradient length that has one colour (docs/looks2d.md,
// "Regions").
struct LookRegion {
  enum class Shape {
    kBox,      // as opaque throughout as `opacity` says, but for soft edges and a narrow foot
    kGaussian  // as ParaView's boxes: most opaque in the middle, a fifth of that at the edges
  };
  Shape shape = Shape::kBox;
  std::array<double, 2> values{0, 1};     // from, to; from < to
  std::array<double, 2> gradients{0, 1};  // from, to; value per world length, 0 <= from < to
  Rgb rgb{1, 1, 1};
  double opacity = 0.5;  // in [0, 1], per unit distance
  // kBox. The share of the way from an edge to the middle over which the opacity rises from 0, in
  // [0, 1]; not from the edge at gradient 0, below which there is nothing.
  double softness = 0.5;
  // kBox. The width at the least gradient, as a share of that at the greatest, in [0, 1]: 1 is a
  // box, 0 a triangle on its tip [Levoy 1988] [Kniss 2002], what lies between a trapezoid.
  double foot = 1;
};

// Colour and opacity by value and by the length of the gradient, as a table. Immutable; copies
// share their content, and any number of threads may read at once.
class TransferFunction2D {
 public:
  using Rgba = std::array<float, 4>;  // sRGB-encoded components, not premultiplied; opacity per
                                      // unit distance; all in [0, 1]
  struct Axis {
    double first = 0, last = 1;  // where the first entry lies, and the last; first < last
    int count = 2;               // of entries, in [2, kMaxEntriesAlong]
  };
  static constexpr int kMaxEntriesAlong = 4096;
  static constexpr std::size_t kMaxEntries = std::size_t{1}
                                             << 17;  // so that a look with one fits its file
  static constexpr std::size_t kMaxRegions = 256;

  // `entries`: [gradients.count, values.count], the row of the least gradient first. Values in the
  // data's unit, gradients in value per world length, gradients.first >= 0. Entries without opacity
  // take the colour of their neighbours that have some: their own is never seen. Throws
  // Error(kInvalidArgument) that names what is wrong: sizes, ranges that do not rise, numbers that
  // are not in [0, 1].
  TransferFunction2D(const Axis& values, const Axis& gradients, std::vector<Rgba> entries);

  // Of at least one region; those behind lie over those before: opacities a and b make
  // 1 - (1 - a)(1 - b), and the colour is the latter's as far as it covers. The table has
  // kRegionValues x kRegionGradients entries over all regions and an entry more around them, so
  // that what lies beyond shows nothing. Throws Error(kInvalidArgument) that names the region.
  explicit TransferFunction2D(std::vector<LookRegion> regions);
  static constexpr int kRegionValues = 1024;
  static constexpr int kRegionGradients = 128;

  const Axis& values() const noexcept;
  const Axis& gradients() const noexcept;
  std::span<const Rgba> entries() const noexcept;           // [gradients().count, values().count]
  const std::vector<LookRegion>& regions() const noexcept;  // empty: made of a table

  // Bilinear, each component by itself, in double; beyond the ends as at the ends. Nothing where
  // either is NaN.
  std::array<double, 4> at(double value, double gradient) const;

 private:
  struct Content;
  std::shared_ptr<const Content> content_;
};

}  // namespace ovoid
