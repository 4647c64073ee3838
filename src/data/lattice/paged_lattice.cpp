// SPDX-License-Identifier: Apache-2.0
#include "data/lattice/paged_lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <type_traits>
#include <utility>

#include "data/kernels/letters.h"
#include "data/lattice/brick_ranges.h"
#include "data/lattice/sample_reader.h"
#include "data/scalar_visit.h"
#include "data/validate.h"
#include "ovoid/error.h"

namespace ovoid {
namespace {

// Bytes of the slab of layers in which ranges are found, at most.
constexpr std::int64_t kMostSlab = std::int64_t{32} << 20;

// Layers of a lattice in memory, as a source that shows no others.
template <class T>
class Slab final : public BrickSource {
 public:
  Slab(const PagedLattice& lattice, ScalarType type, const std::vector<T>& samples,
       std::int64_t first, std::int64_t end)
      : lattice_(lattice), type_(type), samples_(samples), first_(first), end_(end) {}

  const LatticeGeometry& geometry() const noexcept override { return lattice_.geometry(); }
  int brick_edge() const noexcept override { return PagedLattice::kBrickEdge; }
  double value_scale() const noexcept override { return lattice_.value_scale(); }
  double value_offset() const noexcept override { return lattice_.value_offset(); }
  ValueRange brick_range(std::int64_t, std::int64_t, std::int64_t) const noexcept override {
    return {};
  }
  double range_reach() const noexcept override { return 0; }
  bool has_missing(std::int64_t, std::int64_t, std::int64_t) const noexcept override {
    return false;
  }
  BrickView acquire(std::int64_t, std::int64_t, std::int64_t, double) const override {
    const Index3& dims = geometry().dims;
    return {samples_.data(),   type_, {0, 0, first_}, {dims[0], dims[1], end_}, dims[0],
            dims[0] * dims[1], {}};
  }
  std::size_t resident_bytes() const noexcept override { return 0; }

 private:
  const PagedLattice& lattice_;
  ScalarType type_;
  const std::vector<T>& samples_;
  std::int64_t first_, end_;
};

}  // namespace

PagedLattice::PagedLattice(const LatticeGeometry& geometry, ScalarType type,
                           std::shared_ptr<const StoredSamples> samples,
                           const ResidentLatticeOptions& options, std::shared_ptr<KernelTeam> team)
    : geometry_(geometry),
      type_(type),
      samples_(std::move(samples)),
      range_reach_(options.range_reach),
      value_scale_(options.value_scale),
      value_offset_(options.value_offset),
      team_(std::move(team)) {
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
  if (team_ != nullptr) require_one_file();
  data::SampleSurvey survey(geometry_.dims);
  data::visit_scalar(type_, [&]<class T>(std::type_identity<T>) {
    if constexpr (std::is_same_v<T, float> || (std::is_integral_v<T> && sizeof(T) <= 2))
      look_at_samples<T>(options, survey);
  });
  if (team_ != nullptr) {
    take_ranges_of_all();
    survey.join(*team_);
  }
  field_samples_ = survey.samples();
  labels_ = data::labels_told_by(survey, *this);
}

const std::vector<data::RiseSample>& PagedLattice::rises() const {
  std::call_once(has_rises_, [this] {
    rises_ = data::find_rises(*this);
    rises_.shrink_to_fit();
  });
  return rises_;
}

data::SharedLayers PagedLattice::layers() const noexcept {
  if (team_ == nullptr) return {0, geometry_.dims[2], nullptr};
  const std::int64_t num_pages = (geometry_.dims[2] + kPageEdge - 1) / kPageEdge;
  const auto begin_of = [&](std::int64_t process) {
    return std::min(num_pages * process / team_->count() * kPageEdge, geometry_.dims[2]);
  };
  return {begin_of(team_->number()), begin_of(team_->number() + 1), team_.get()};
}

// Slab by slab of brick layers, each with a brick's layers before and behind it, which is farther
// than kernels reach.
template <class T>
void PagedLattice::look_at_samples(const ResidentLatticeOptions& options,
                                   data::SampleSurvey& survey) {
  const Index3& dims = geometry_.dims;
  const std::int64_t layer = dims[0] * dims[1];
  const auto margin = static_cast<std::int64_t>(std::ceil((range_reach_ + 1) / kBrickEdge));
  const std::int64_t slab_bytes = std::min(kMostSlab, samples_->memory_for_pages() / 2);
  const std::int64_t bricks_in_slab =
      std::max<std::int64_t>(1, slab_bytes / (layer * kBrickEdge * std::int64_t{sizeof(T)}));
  const std::int64_t bricks_in_layer = num_bricks_[0] * num_bricks_[1];
  const data::SharedLayers own = layers();
  const std::int64_t end = (own.end + kBrickEdge - 1) / kBrickEdge;
  std::vector<T> slab;
  for (std::int64_t first = own.first / kBrickEdge; first < end; first += bricks_in_slab) {
    const std::int64_t last = std::min(first + bricks_in_slab, end);
    const std::int64_t from = std::max<std::int64_t>(first - margin, 0);
    const std::int64_t z0 = from * kBrickEdge;
    const std::int64_t z1 = std::min((last + margin) * kBrickEdge, dims[2]);
    slab.resize(static_cast<std::size_t>((z1 - z0) * layer));
    read_rows({0, dims[1], z0, z1}, reinterpret_cast<std::byte*>(slab.data()));
    const Slab<T> shown(*this, type_, slab, z0, z1);
    data::SampleReader reader(shown);
    const std::int64_t first_layer = first * kBrickEdge;
    const std::int64_t end_layer = std::min(last * kBrickEdge, dims[2]);
    survey.take_samples(reader, first_layer, end_layer);
    survey.take_rows(reader, first_layer, end_layer);
    survey.find_integers(reader, first_layer, end_layer);
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

// Nobody reads the whole file: a few rows of it tell files apart.
void PagedLattice::require_one_file() const {
  constexpr std::uint64_t kRows = 256;
  const Index3& dims = geometry_.dims;
  std::vector<std::byte> row(static_cast<std::size_t>(dims[0]) * size_of(type_));
  std::uint64_t sum = 0;
  for (std::uint64_t i = 0; i < kRows; ++i) {
    const auto number = static_cast<std::int64_t>(data::scrambled(i) %
                                                  static_cast<std::uint64_t>(dims[1] * dims[2]));
    const std::int64_t y = number % dims[1], z = number / dims[1];
    read_rows({y, y + 1, z, z + 1}, row.data());
    for (const std::byte byte : row)
      sum = data::scrambled(sum ^ std::to_integer<std::uint64_t>(byte));
  }
  const std::vector<std::uint64_t> sums =
      data::joined(*team_, std::span<const std::uint64_t>(&sum, 1));
  for (std::size_t process = 0; process < sums.size(); ++process) {
    if (sums[process] == sums[0]) continue;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("process {} of {}: its file has other samples than that of process 0",
                            process, sums.size()));
  }
}

// Each has found those of its own layers of bricks.
void PagedLattice::take_ranges_of_all() {
  const data::SharedLayers own = layers();
  const std::int64_t in_layer = num_bricks_[0] * num_bricks_[1];
  const auto first = static_cast<std::size_t>(own.first / kBrickEdge * in_layer);
  const auto end = static_cast<std::size_t>((own.end + kBrickEdge - 1) / kBrickEdge * in_layer);
  ranges_ = data::joined(*team_, std::span<const ValueRange>(ranges_).subspan(first, end - first));
  missing_.resize(ranges_.size());
  missing_ =
      data::joined(*team_, std::span<const std::uint8_t>(missing_).subspan(first, end - first));
  if (std::find(missing_.begin(), missing_.end(), 1) == missing_.end()) missing_.clear();
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
