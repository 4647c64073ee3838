// SPDX-License-Identifier: Apache-2.0
#include "data/paged_lattice.h"

#include <algorithm>
#include <type_traits>

#include "data/brick_ranges.h"
#include "data/scalar_visit.h"
#include "data/validate.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

// Bytes of the slab of layers in which ranges are found, at most.
constexpr std::int64_t kMostSlab = std::int64_t{32} << 20;

}  // namespace

PagedLattice::PagedLattice(const LatticeGeometry& geometry, ScalarType type,
                           std::shared_ptr<const StoredSamples> samples,
                           const ResidentLatticeOptions& options)
    : geometry_(geometry),
      type_(type),
      samples_(std::move(samples)),
      range_reach_(options.range_reach),
      value_scale_(options.value_scale),
      value_offset_(options.value_offset) {
  data::validate_geometry(geometry_);
  options.validate();
  if (geometry_.kind != LatticeKind::kCartesian || !ResidentLattice::can_show(type_) ||
      samples_->num_bytes() !=
          num_samples(geometry_.dims) * static_cast<std::int64_t>(size_of(type_))) {
    throw Error(ErrorCode::kInvalidArgument,
                "samples in a file: must be of a Cartesian lattice, all of uint8, int8, uint16, "
                "int16 or float32");
  }
  for (std::size_t a = 0; a < 3; ++a)
    num_bricks_[a] = (geometry_.dims[a] + kBrickEdge - 1) / kBrickEdge;
  pages_along_y_ = (geometry_.dims[1] + kPageEdge - 1) / kPageEdge;
  const std::int64_t page_bytes =
      geometry_.dims[0] * kPageEdge * kPageEdge * static_cast<std::int64_t>(size_of(type_));
  pages_.emplace(static_cast<std::size_t>(
      std::max<std::int64_t>(samples_->memory_for_pages() / page_bytes, 2)));
  ranges_.resize(static_cast<std::size_t>(num_samples(num_bricks_)));
  data::visit_scalar(type_, [&]<class T>(std::type_identity<T>) {
    if constexpr (std::is_same_v<T, float> || (std::is_integral_v<T> && sizeof(T) <= 2))
      find_ranges<T>(options);
  });
}

// Slab by slab of brick layers, each with a brick's layers before and behind it, which is farther
// than kernels reach.
template <class T>
void PagedLattice::find_ranges(const ResidentLatticeOptions& options) {
  const Index3& dims = geometry_.dims;
  const std::int64_t layer = dims[0] * dims[1];
  const auto margin = static_cast<std::int64_t>(std::ceil((range_reach_ + 1) / kBrickEdge));
  const std::int64_t slab_bytes = std::min(kMostSlab, samples_->memory_for_pages() / 2);
  const std::int64_t bricks_in_slab =
      std::max<std::int64_t>(1, slab_bytes / (layer * kBrickEdge * std::int64_t{sizeof(T)}));
  const std::int64_t bricks_in_layer = num_bricks_[0] * num_bricks_[1];
  std::vector<T> slab;
  for (std::int64_t first = 0; first < num_bricks_[2]; first += bricks_in_slab) {
    const std::int64_t last = std::min(first + bricks_in_slab, num_bricks_[2]);
    const std::int64_t from = std::max<std::int64_t>(first - margin, 0);
    const std::int64_t z0 = from * kBrickEdge;
    const std::int64_t z1 = std::min((last + margin) * kBrickEdge, dims[2]);
    slab.resize(static_cast<std::size_t>((z1 - z0) * layer));
    read_rows({0, dims[1], z0, z1}, reinterpret_cast<std::byte*>(slab.data()));
    const data::BrickTable<T> table = data::make_brick_table(
        slab.data(), {dims[0], dims[1], z1 - z0},
        {kBrickEdge, range_reach_, LatticeKind::kCartesian, options.threads, options.stop});
    if (!table.missing.empty()) missing_.resize(ranges_.size());
    const std::int64_t skipped = (first - from) * bricks_in_layer;
    for (std::int64_t i = 0; i < (last - first) * bricks_in_layer; ++i) {
      const auto in_table = static_cast<std::size_t>(skipped + i);
      const auto in_all = static_cast<std::size_t>(first * bricks_in_layer + i);
      if (!table.missing.empty()) missing_[in_all] = table.missing[in_table];
      const data::Extent<T>& stored = table.extents[in_table];
      if (!(stored.lo <= stored.hi)) continue;
      const auto lo = static_cast<float>(stored.lo * value_scale_ + value_offset_);
      const auto hi = static_cast<float>(stored.hi * value_scale_ + value_offset_);
      ranges_[in_all] = value_scale_ > 0 ? ValueRange{lo, hi} : ValueRange{hi, lo};
    }
  }
}

std::size_t PagedLattice::brick_index(std::int64_t bx, std::int64_t by,
                                      std::int64_t bz) const noexcept {
  return static_cast<std::size_t>(bx + num_bricks_[0] * (by + num_bricks_[1] * bz));
}

ValueRange PagedLattice::brick_range(std::int64_t bx, std::int64_t by,
                                     std::int64_t bz) const noexcept {
  return ranges_[brick_index(bx, by, bz)];
}

bool PagedLattice::has_missing(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept {
  return !missing_.empty() && missing_[brick_index(bx, by, bz)] != 0;
}

PagedLattice::PageBox PagedLattice::box_of(std::int64_t number) const noexcept {
  const std::int64_t y0 = number % pages_along_y_ * kPageEdge;
  const std::int64_t z0 = number / pages_along_y_ * kPageEdge;
  return {y0, std::min(y0 + kPageEdge, geometry_.dims[1]), z0,
          std::min(z0 + kPageEdge, geometry_.dims[2])};
}

// Rows of a layer lie behind each other.
void PagedLattice::read_rows(const PageBox& box, std::byte* to) const {
  const auto row = static_cast<std::int64_t>(size_of(type_)) * geometry_.dims[0];
  const std::int64_t count = (box.y1 - box.y0) * row;
  for (std::int64_t z = box.z0; z < box.z1; ++z, to += count)
    samples_->read((z * geometry_.dims[1] + box.y0) * row, {to, static_cast<std::size_t>(count)});
}

BrickView PagedLattice::acquire(std::int64_t /*bx*/, std::int64_t by, std::int64_t bz,
                                double /*time*/) const {
  constexpr std::int64_t kBricks = kPageEdge / kBrickEdge;
  const std::int64_t number = by / kBricks + pages_along_y_ * (bz / kBricks);
  const PageBox box = box_of(number);
  const std::int64_t rows = box.y1 - box.y0;
  std::shared_ptr<const Page> page = pages_->get(number, [&] {
    // From operator new: aligned for every type.
    Page samples(
        new std::byte[static_cast<std::size_t>(geometry_.dims[0] * rows * (box.z1 - box.z0)) *
                      size_of(type_)]);
    read_rows(box, samples.get());
    return samples;
  });
  BrickView view;
  view.data = page->get();
  view.type = type_;
  view.lo = {0, box.y0, box.z0};
  view.hi = {geometry_.dims[0], box.y1, box.z1};
  view.stride_y = geometry_.dims[0];
  view.stride_z = geometry_.dims[0] * rows;
  view.pin = std::move(page);
  return view;
}

std::size_t PagedLattice::resident_bytes() const noexcept {
  return ranges_.size() * sizeof(ValueRange) + missing_.size() +
         pages_->count() * static_cast<std::size_t>(geometry_.dims[0]) * kPageEdge * kPageEdge *
             size_of(type_);
}

}  // namespace ovoid
