// SPDX-License-Identifier: Apache-2.0
// Lattices: a cell is a box of whole samples, whose extinctions are averaged. Slabs of cells are
// shared among threads, and each slab reads its samples in a fixed order. Kernel sets: kernels,
// widened to half a cell, are added to the cells' middles that they reach, and their sum is
// classified there; each slab goes through the kernels in their order. So the number of threads
// cannot be seen in the numbers.
#include "render/light/extinction_lattice.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "data/field_samples.h"
#include "data/kernels/kernel_shape.h"
#include "data/kernels/letters.h"
#include "data/parallel.h"
#include "data/scalar_visit.h"
#include "view/look/field_samples.h"
#include "view/look/look_table.h"

namespace ovoid {

double ExtinctionLattice::cell_edge() const {
  return world_from_cell.linear().colwise().norm().mean();
}

namespace {

// Per length, of an opacity over the look's unit distance.
double extinction_of_opacity(const Look& look, double opacity) {
  const double per_unit =
      opacity < 1 ? std::min(-std::log1p(-opacity), kOpaqueExtinction) : kOpaqueExtinction;
  return per_unit / look.unit_distance;
}

}  // namespace

double extinction_of(const Look& look, double value) {
  return extinction_of_opacity(look, look.transfer_function.opacity_at(value));
}

namespace {

// Of an isosurface the side that the field's faces do not lie on is solid; of a set of kernels,
// which has no faces, the greater values.
bool is_solid_above(const Field& field, double isovalue) {
  if (field.lattice() == nullptr) return true;
  const std::vector<float> faces = data::take_samples(field.lattice()->samples()).on_faces;
  return faces.empty() || view::quantile(faces, 0.5) < isovalue;
}

// Extinction by value, from a table.
class Absorber {
 public:
  Absorber(const Field& field, const Look& look)
      : table_(look.transfer_function),
        is_surface_(look.mode == Mode::kIsosurface),
        iso_(static_cast<float>(look.isovalue)),
        solid_(static_cast<float>(kOpaqueExtinction / look.unit_distance)) {
    if (is_surface_) {
      is_above_ = is_solid_above(field, look.isovalue);
      return;
    }
    entries_.resize(view::LookTable::kEntries);
    for (int i = 0; i < view::LookTable::kEntries; ++i) {
      entries_[static_cast<std::size_t>(i)] =
          static_cast<float>(extinction_of_opacity(look, table_.opacity()[i]));
    }
  }

  bool absorbs(const ValueRange& range) const {
    if (range.is_empty()) return false;
    if (is_surface_) return is_above_ ? range.hi >= iso_ : range.lo < iso_;
    return table_.any_opacity(range.lo, range.hi);
  }

  // 0 of what is no number.
  float operator()(float value) const {
    if (!std::isfinite(value)) return 0;
    if (is_surface_) return (value >= iso_) == is_above_ ? solid_ : 0;
    const float place = table_.axis().place(value);
    constexpr auto kLast = static_cast<float>(view::LookTable::kCells);
    return entries_[static_cast<std::size_t>(std::lround(std::clamp(place, 0.0F, kLast)))];
  }

 private:
  view::LookTable table_;
  bool is_surface_;
  bool is_above_ = true;
  float iso_, solid_;
  std::vector<float> entries_;
};

std::size_t num_cells(const Index3& dims) { return static_cast<std::size_t>(num_samples(dims)); }

int wanted_cells(double num_samples_along) {
  const double quarter =
      std::clamp(num_samples_along / 4, 1.0 * kLeastLightCells, 1.0 * kMostLightCells);
  return static_cast<int>(std::max(1.0, std::min(quarter, num_samples_along)));
}

// Cells of a lattice are `edge` cells of its axis vectors long.
struct Blocks {
  Index3 edge{1, 1, 1};
  Index3 count{1, 1, 1};
};

Blocks blocks_of(const LatticeGeometry& geometry) {
  const Index3 cells = geometry.cells();
  Vec3 sides, axes;
  for (int a = 0; a < 3; ++a) {
    axes[a] = geometry.world_from_index.linear().col(a).norm();
    sides[a] = axes[a] * static_cast<double>(cells[static_cast<std::size_t>(a)]);
  }
  const double longest = sides.maxCoeff();
  const double target = longest / wanted_cells(longest / axes.minCoeff());
  Blocks blocks;
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    blocks.edge[i] = std::max<std::int64_t>(1, std::llround(target / axes[a]));
    blocks.count[i] = (cells[i] + blocks.edge[i] - 1) / blocks.edge[i];
  }
  return blocks;
}

ExtinctionLattice lattice_around(const LatticeGeometry& geometry, const Blocks& blocks) {
  ExtinctionLattice out;
  Vec3 edge;
  for (std::size_t a = 0; a < 3; ++a) {
    out.dims[a] = blocks.count[a] + 2;
    edge[static_cast<int>(a)] = static_cast<double>(blocks.edge[a]);
  }
  // The first block begins where the box of the samples does; cell 1 is its.
  const Vec3 first = geometry.index_bounds().min() - 0.5 * edge;
  out.world_from_cell =
      geometry.world_from_index * (Eigen::Translation3d(first) * Eigen::Scaling(edge));
  out.extinction.assign(num_cells(out.dims), 0.0F);
  return out;
}

// One slab of blocks: the mean over the samples that its blocks would have if all were there.
class SlabOfBlocks {
 public:
  SlabOfBlocks(const BrickSource& source, const Absorber& absorber, const Blocks& blocks,
               ExtinctionLattice& out)
      : source_(source),
        geometry_(source.geometry()),
        absorber_(absorber),
        blocks_(blocks),
        out_(out),
        inverse_count_(
            1.0F / static_cast<float>(num_samples(blocks.edge) * geometry_.num_sublattices())) {}

  void add(std::int64_t slab) const {
    const std::int64_t first = slab * blocks_.edge[2];
    const std::int64_t last = std::min(first + blocks_.edge[2], geometry_.cells()[2]);
    const std::int64_t edge = source_.brick_edge();
    const Index3 cells = geometry_.cells();
    for (std::int64_t bz = first / edge; bz * edge < last; ++bz) {
      for (std::int64_t by = 0; by * edge < cells[1]; ++by) {
        for (std::int64_t bx = 0; bx * edge < cells[0]; ++bx) {
          if (!absorber_.absorbs(source_.brick_range(bx, by, bz))) continue;
          const Index3 lo{bx * edge, by * edge, std::max(first, bz * edge)};
          const Index3 hi{std::min(lo[0] + edge, cells[0]), std::min(lo[1] + edge, cells[1]),
                          std::min(last, (bz + 1) * edge)};
          add_brick(source_.acquire(bx, by, bz, 0), slab, lo, hi);
        }
      }
    }
  }

 private:
  void add_brick(const BrickView& view, std::int64_t slab, const Index3& lo,
                 const Index3& hi) const {
    data::visit_scalar(view.type, [&]<class T>(std::type_identity<T>) {
      const std::int64_t layers = geometry_.num_sublattices();
      const std::int64_t end = std::min(hi[2] * layers, geometry_.dims[2]);
      for (std::int64_t k = lo[2] * layers; k < end; ++k) {
        for (std::int64_t y = lo[1]; y < hi[1]; ++y) {
          const T* const row = static_cast<const T*>(view.data) + (lo[0] - view.lo[0]) +
                               (y - view.lo[1]) * view.stride_y + (k - view.lo[2]) * view.stride_z;
          add_row(row, hi[0] - lo[0], lo[0], y, slab);
        }
      }
    });
  }

  template <class T>
  void add_row(const T* row, std::int64_t count, std::int64_t x0, std::int64_t y,
               std::int64_t slab) const {
    const auto scale = static_cast<float>(source_.value_scale());
    const auto offset = static_cast<float>(source_.value_offset());
    const std::int64_t block_y = y / blocks_.edge[1] + 1;
    float* const cells =
        out_.extinction.data() + ((slab + 1) * out_.dims[1] + block_y) * out_.dims[0] + 1;
    for (std::int64_t i = 0; i < count;) {
      const std::int64_t block = (x0 + i) / blocks_.edge[0];
      const std::int64_t end = std::min(count, (block + 1) * blocks_.edge[0] - x0);
      float sum = 0;
      for (; i < end; ++i) sum += absorber_(static_cast<float>(row[i]) * scale + offset);
      cells[block] += sum * inverse_count_;
    }
  }

  const BrickSource& source_;
  const LatticeGeometry& geometry_;
  const Absorber& absorber_;
  const Blocks& blocks_;
  ExtinctionLattice& out_;
  const float inverse_count_;
};

// Layers of cells: who makes which, and everybody gets all.
class Slabs {
 public:
  Slabs(std::int64_t count, KernelTeam* team) : count_(count), team_(team) {}

  std::int64_t begin() const { return team_ == nullptr ? 0 : end_of(team_->number()); }
  std::int64_t end() const { return team_ == nullptr ? count_ : end_of(team_->number() + 1); }

  // `layers`: those of all slabs, `size` cells each, of which this process has made its own.
  void gather(std::span<float> layers, std::size_t size) const {
    if (team_ == nullptr) return;
    const auto own = layers.subspan(static_cast<std::size_t>(begin()) * size,
                                    static_cast<std::size_t>(end() - begin()) * size);
    auto to = layers.begin();
    for (const std::vector<float>& from :
         data::gathered(*team_, std::span<const float>(own.data(), own.size())))
      to = std::copy(from.begin(), from.end(), to);
  }

 private:
  std::int64_t end_of(int process) const { return count_ * process / team_->count(); }

  std::int64_t count_;
  KernelTeam* team_;
};

ExtinctionLattice of_lattice(const LatticeField& field, const Absorber& absorber, int threads,
                             const std::stop_token& stop, KernelTeam* team) {
  const BrickSource& source = field.samples();
  const Blocks blocks = blocks_of(source.geometry());
  ExtinctionLattice out = lattice_around(source.geometry(), blocks);
  const SlabOfBlocks slab_of_blocks(source, absorber, blocks, out);
  const Slabs slabs(blocks.count[2], team);
  // A range of slabs reads most of its bricks once.
  const std::int64_t grain =
      std::max<std::int64_t>(1, source.brick_edge() / std::max<std::int64_t>(1, blocks.edge[2]));
  data::parallel_ranges({slabs.end() - slabs.begin(), grain, threads, stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          for (std::int64_t slab = begin; slab < end; ++slab)
                            slab_of_blocks.add(slabs.begin() + slab);
                        });
  const auto layer = static_cast<std::size_t>(out.dims[0] * out.dims[1]);
  slabs.gather(std::span(out.extinction).subspan(layer, layer * blocks.count[2]), layer);
  return out;
}

// Sums of a set's kernels at the middles of one slab of cells.
class SlabSums {
 public:
  SlabSums(const KernelField& field, const ExtinctionLattice& lattice)
      : field_(field),
        source_(field.source()),
        dims_(lattice.dims),
        edge_(lattice.cell_edge()),
        origin_(lattice.world_from_cell.translation()) {
    const double cutoff = source_.cutoff();
    for (std::size_t i = 0; i < heights_.size(); ++i) {
      const double squared = cutoff * cutoff * static_cast<double>(i) / kHeights;
      heights_[i] =
          static_cast<float>(profile_value(source_.profile(), std::sqrt(squared), cutoff));
    }
  }

  // The values of a slab, NaN where the field is not defined.
  std::vector<float> values(std::int64_t slab) const {
    std::vector<float> sums(static_cast<std::size_t>(2 * dims_[0] * dims_[1]), 0.0F);
    const double z = origin_[2] + edge_ * static_cast<double>(slab);
    const double room = source_.cutoff() * edge_;  // more than kernels are widened by
    for (std::int64_t b = 0; b < source_.num_bricks(); ++b) {
      const KernelBrick& brick = source_.brick(b);
      if (z < brick.support.min()[2] - room || z > brick.support.max()[2] + room) continue;
      const KernelView view = source_.acquire(b, 0);
      for (std::int32_t i = 0; i < view.count; ++i) add(brick, view, i, slab, sums);
    }
    const bool is_sum = field_.reconstruction() == Reconstruction::kSum;
    std::vector<float> values(sums.size() / 2);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const float weight = sums[2 * i + 1];
      const bool is_defined = is_sum ? weight > 0 : weight >= KernelField::kLeastWeight;
      values[i] = !is_defined ? std::nanf("") : is_sum ? sums[2 * i] : sums[2 * i] / weight;
    }
    return values;
  }

 private:
  static constexpr int kHeights = 256;

  void add(const KernelBrick& brick, const KernelView& view, std::int32_t i, std::int64_t slab,
           std::vector<float>& sums) const {
    const Mat3 factor =
        data::factor_of(source_.shape(), data::shape_numbers(view, source_.shape(), i).data());
    const Vec3 place = (brick.origin + data::offset_of(view, i) - origin_) / edge_;  // in cells
    const Mat3 narrow = factor * factor.transpose() / (edge_ * edge_);
    const Mat3 wide = narrow + 0.25 * Mat3::Identity();
    const double cutoff = source_.cutoff();
    const double dz = static_cast<double>(slab) - place[2];
    if (dz * dz > cutoff * cutoff * wide(2, 2)) return;
    const Mat3 inverse = wide.inverse();
    const double height =
        data::weight_of(view, i) * std::sqrt(narrow.determinant() / wide.determinant());
    const auto value =
        static_cast<float>(view.value[static_cast<std::size_t>(field_.attribute())][i]);
    const double reach_x = cutoff * std::sqrt(wide(0, 0));
    const double reach_y = cutoff * std::sqrt(wide(1, 1));
    const auto first = [&](int a, double reach) {
      return std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(place[a] - reach)));
    };
    const auto last = [&](int a, double reach) {
      return std::min<std::int64_t>(dims_[static_cast<std::size_t>(a)] - 1,
                                    static_cast<std::int64_t>(std::floor(place[a] + reach)));
    };
    const double per_height = kHeights / (cutoff * cutoff);
    for (std::int64_t y = first(1, reach_y); y <= last(1, reach_y); ++y) {
      const double dy = static_cast<double>(y) - place[1];
      const double rest =
          inverse(1, 1) * dy * dy + 2 * inverse(1, 2) * dy * dz + inverse(2, 2) * dz * dz;
      const double slope = 2 * (inverse(0, 1) * dy + inverse(0, 2) * dz);
      for (std::int64_t x = first(0, reach_x); x <= last(0, reach_x); ++x) {
        const double dx = static_cast<double>(x) - place[0];
        const double entry = (rest + dx * (slope + inverse(0, 0) * dx)) * per_height;
        if (!(entry < kHeights)) continue;
        const auto share =
            static_cast<float>(height * heights_[static_cast<std::size_t>(std::max(entry, 0.0))]);
        float* const sum = &sums[static_cast<std::size_t>(2 * (y * dims_[0] + x))];
        sum[0] += share * value;
        sum[1] += share;
      }
    }
  }

  const KernelField& field_;
  const KernelSource& source_;
  const Index3 dims_;
  const double edge_;
  const Vec3 origin_;
  std::array<float, kHeights + 1> heights_{};  // of the profile, by the squared distance
};

ExtinctionLattice of_kernels(const KernelField& field, const Absorber& absorber, int threads,
                             const std::stop_token& stop, KernelTeam* team) {
  const Bounds3 box = field.world_bounds();
  const double longest = box.sizes().maxCoeff();
  const double edge = longest / wanted_cells(longest / field.default_sampling_distance());
  ExtinctionLattice out;
  for (int a = 0; a < 3; ++a) {
    out.dims[static_cast<std::size_t>(a)] =
        std::max<std::int64_t>(1, std::llround(std::ceil(box.sizes()[a] / edge))) + 2;
  }
  const Vec3 half = 0.5 * edge *
                    Vec3(static_cast<double>(out.dims[0] - 1), static_cast<double>(out.dims[1] - 1),
                         static_cast<double>(out.dims[2] - 1));
  out.world_from_cell =
      Eigen::Translation3d(box.center() - half) * Eigen::Scaling(Vec3::Constant(edge));
  out.extinction.assign(num_cells(out.dims), 0.0F);
  const SlabSums sums(field, out);
  const auto per_slab = static_cast<std::size_t>(out.dims[0] * out.dims[1]);
  const Slabs slabs(out.dims[2], team);
  const std::int64_t num_own = slabs.end() - slabs.begin();
  data::parallel_ranges({num_own, 1, threads, stop}, [&](std::int64_t of_own, std::int64_t) {
    const std::int64_t slab = slabs.begin() + of_own;
    const std::vector<float> values = sums.values(slab);
    std::transform(values.begin(), values.end(),
                   out.extinction.begin() + static_cast<std::ptrdiff_t>(slab * per_slab),
                   [&](float value) { return absorber(value); });
  });
  slabs.gather(out.extinction, per_slab);
  return out;
}

// Cells that a plane cuts keep the part of them that is on its side, as if it lay across them.
void cut(const std::vector<ClipPlane>& planes, ExtinctionLattice& lattice) {
  for (const ClipPlane& plane : planes) {
    const double length = plane.normal.norm();
    const Vec3 normal = plane.normal / length;
    const double extent = (lattice.world_from_cell.linear().transpose() * normal).cwiseAbs().sum();
    float* cell = lattice.extinction.data();
    for (std::int64_t z = 0; z < lattice.dims[2]; ++z) {
      for (std::int64_t y = 0; y < lattice.dims[1]; ++y) {
        for (std::int64_t x = 0; x < lattice.dims[0]; ++x, ++cell) {
          const Vec3 middle =
              lattice.world_from_cell *
              Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
          const double inside = normal.dot(middle) - plane.offset / length;
          *cell *= static_cast<float>(std::clamp(0.5 + inside / extent, 0.0, 1.0));
        }
      }
    }
  }
}

}  // namespace

ExtinctionLattice extinction_lattice(const Field& field, const Look& look,
                                     const std::vector<ClipPlane>& clip_planes, int threads,
                                     const std::stop_token& stop, KernelTeam* team) {
  const Absorber absorber(field, look);
  ExtinctionLattice out = field.kernels() != nullptr
                              ? of_kernels(*field.kernels(), absorber, threads, stop, team)
                              : of_lattice(*field.lattice(), absorber, threads, stop, team);
  cut(clip_planes, out);
  return out;
}

ExtinctionLattice grown(const ExtinctionLattice& lattice, const Index3& before,
                        const Index3& behind) {
  ExtinctionLattice out = lattice;
  for (std::size_t a = 0; a < 3; ++a) out.dims[a] += before[a] + behind[a];
  if (out.dims == lattice.dims) return out;
  out.world_from_cell.translate(-Vec3(static_cast<double>(before[0]),
                                      static_cast<double>(before[1]),
                                      static_cast<double>(before[2])));
  out.extinction.assign(num_cells(out.dims), 0.0F);
  for (std::int64_t z = 0; z < lattice.dims[2]; ++z) {
    for (std::int64_t y = 0; y < lattice.dims[1]; ++y) {
      const float* const row =
          &lattice
               .extinction[static_cast<std::size_t>((z * lattice.dims[1] + y) * lattice.dims[0])];
      std::copy_n(row, lattice.dims[0],
                  &out.extinction[static_cast<std::size_t>(
                      ((z + before[2]) * out.dims[1] + y + before[1]) * out.dims[0] + before[0])]);
    }
  }
  return out;
}

namespace {

// As many cells around as `box` needs, which is in cells.
ExtinctionLattice grown_to(const ExtinctionLattice& lattice, const Bounds3& box) {
  Index3 before{}, behind{};
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    const std::int64_t room = std::max<std::int64_t>(0, kMostCellsOfAll - lattice.dims[i]);
    const auto end = static_cast<double>(lattice.dims[i] - 1);
    const auto cells_for = [&](double beyond, std::int64_t most) {
      const auto cells = std::clamp(std::ceil(beyond), 0.0, static_cast<double>(most));
      return static_cast<std::int64_t>(cells);
    };
    before[i] = cells_for(-box.min()[a], room);
    behind[i] = cells_for(box.max()[a] - end, room - before[i]);
  }
  return grown(lattice, before, behind);
}

// Between the middles of cells; nothing beyond them.
float extinction_at(const ExtinctionLattice& lattice, const Vec3& cell) {
  Index3 first;
  Vec3 share;
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    if (!(cell[a] >= 0 && cell[a] <= static_cast<double>(lattice.dims[i] - 1))) return 0;
    first[i] = std::min(static_cast<std::int64_t>(cell[a]), lattice.dims[i] - 2);
    share[a] = cell[a] - static_cast<double>(first[i]);
  }
  double sum = 0;
  for (std::int64_t corner = 0; corner < 8; ++corner) {
    const Index3 side{corner & 1, corner >> 1 & 1, corner >> 2};
    double weight = 1;
    for (int a = 0; a < 3; ++a)
      weight *= side[static_cast<std::size_t>(a)] == 1 ? share[a] : 1 - share[a];
    sum += weight *
           lattice.extinction[static_cast<std::size_t>(
               ((first[2] + side[2]) * lattice.dims[1] + first[1] + side[1]) * lattice.dims[0] +
               first[0] + side[0])];
  }
  return static_cast<float>(sum);
}

}  // namespace

void mix_extinction(const ExtinctionLattice& other, Mixing mixing, ExtinctionLattice& sum) {
  const Affine3 cell_from_other = sum.world_from_cell.inverse() * other.world_from_cell;
  Bounds3 box;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 place;
    for (int a = 0; a < 3; ++a) {
      const auto last = static_cast<double>(other.dims[static_cast<std::size_t>(a)] - 1);
      place[a] = (corner >> a & 1) != 0 ? last : 0.0;
    }
    box.extend(cell_from_other * place);
  }
  sum = grown_to(sum, box);
  const Affine3 other_from_cell = other.world_from_cell.inverse() * sum.world_from_cell;
  float* cell = sum.extinction.data();
  for (std::int64_t z = 0; z < sum.dims[2]; ++z) {
    for (std::int64_t y = 0; y < sum.dims[1]; ++y) {
      for (std::int64_t x = 0; x < sum.dims[0]; ++x, ++cell) {
        const float more = extinction_at(
            other, other_from_cell * Vec3(static_cast<double>(x), static_cast<double>(y),
                                          static_cast<double>(z)));
        *cell = mixing == Mixing::kAdded ? std::max(*cell, more) : *cell + more;
      }
    }
  }
}

}  // namespace ovoid
