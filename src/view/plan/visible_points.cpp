// SPDX-License-Identifier: Apache-2.0
#include "view/plan/visible_points.h"

#include <algorithm>
#include <cmath>

#include "data/kernels/kernel_shape.h"
#include "data/kernels/some_kernels.h"
#include "data/scalar_visit.h"
#include "view/look/field_samples.h"
#include "view/look/isosurfaces.h"
#include "view/look/look_2d.h"
#include "view/look/look_table.h"

namespace ovoid::view {
namespace {

double sample_value(const BrickSource& source, const BrickView& view, const Index3& at) {
  const std::int64_t place = (at[0] - view.lo[0]) + (at[1] - view.lo[1]) * view.stride_y +
                             (at[2] - view.lo[2]) * view.stride_z;
  const double stored = data::visit_scalar(view.type, [&]<class T>(std::type_identity<T>) {
    return static_cast<double>(
        data::load_scalar<T>(static_cast<const std::byte*>(view.data), place));
  });
  return stored * source.value_scale() + source.value_offset();
}

// Is a surface around what is less, as of a distance that is negative within? Then most corners of
// the lattice are more.
bool encloses_less(const Field& field, float isovalue) {
  if (field.lattice() == nullptr) return false;
  const BrickSource& source = field.lattice()->samples();
  const LatticeGeometry& lattice = source.geometry();
  const std::int64_t edge = source.brick_edge();
  const std::int64_t layers = edge * lattice.num_sublattices();
  int num_more = 0;
  for (unsigned corner = 0; corner < 8; ++corner) {
    Index3 at{};
    for (unsigned a = 0; a < 3; ++a) at[a] = (corner >> a & 1U) != 0 ? lattice.dims[a] - 1 : 0;
    const BrickView view = source.acquire(at[0] / edge, at[1] / edge, at[2] / layers, 0.0);
    if (sample_value(source, view, at) >= isovalue) ++num_more;
  }
  return num_more > 4;
}

// Extinction by the value.
class Extinction {
 public:
  Extinction(const Field& field, const Look& look)
      : mode_(look.mode),
        isovalue_(static_cast<float>(surfaces_of(look).front().value)),
        table_(with_envelope(look).transfer_function) {
    encloses_less_ = mode_ == Mode::kIsosurface && encloses_less(field, isovalue_);
    const ValueRange range = field.value_range();
    least_shown_ = range.lo + 0.02F * (range.hi - range.lo);
    per_unit_ = 1 / unit_distance_of(look, field);
  }

  double at(float value) const { return std::isnan(value) ? 0.0 : per_unit_ * of_unit(value); }

 private:
  static constexpr double kSolid = 10;

  // Where one sample makes the pixel, opacity is no matter of thickness.
  double of_unit(float value) const {
    switch (mode_) {
      case Mode::kIsosurface:
        return (value >= isovalue_) != encloses_less_ ? kSolid : 0.0;
      case Mode::kXray:
        return value > least_shown_ ? kSolid : 0.0;
      case Mode::kMaximum:
      case Mode::kMinimum:
      case Mode::kMean:
        return table_.at(value).opacity > 0.02F ? kSolid : 0.0;
      case Mode::kComposite:
        break;
    }
    const double opacity = table_.at(value).opacity;
    return opacity < 1 ? std::min(-std::log1p(-opacity), kSolid) : kSolid;
  }

  Mode mode_;
  float isovalue_;  // the least
  bool encloses_less_ = false;
  LookTable table_;
  float least_shown_ = 0;
  double per_unit_ = 1;
};

// Every so many-th sample along each axis, those of a brick together.
void add_samples(const LatticeField& field, const Extinction& extinction,
                 const std::vector<ClipPlane>& planes, const VisiblePointSink& sink,
                 std::int64_t most) {
  const BrickSource& source = field.samples();
  const LatticeGeometry& lattice = source.geometry();
  const double per_axis =
      std::cbrt(static_cast<double>(num_samples(lattice.dims)) / static_cast<double>(most));
  const auto step = std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(per_axis)));
  const std::int64_t edge = source.brick_edge();
  const std::int64_t layers = edge * lattice.num_sublattices();
  const Mat3 axes = lattice.world_from_index.linear();
  const double volume = std::abs(axes.determinant()) / lattice.density();
  // Along an axis that has fewer samples than a step there is one.
  const auto first = [&](std::int64_t lo) { return (lo + step - 1) / step * step; };
  BrickView view;
  for (std::int64_t z = 0; z < lattice.dims[2]; z = first(z + 1)) {
    for (std::int64_t y = 0; y < lattice.dims[1]; y = first(y + 1)) {
      for (std::int64_t x = 0; x < lattice.dims[0]; x = first(x + 1)) {
        const bool is_in_view = x >= view.lo[0] && x < view.hi[0] && y >= view.lo[1] &&
                                y < view.hi[1] && z >= view.lo[2] && z < view.hi[2];
        if (!is_in_view) view = source.acquire(x / edge, y / edge, z / layers, 0.0);
        const double here =
            extinction.at(static_cast<float>(sample_value(source, view, {x, y, z})));
        if (!(here > 0)) continue;
        const Vec3 place = lattice.world_from_index * lattice.index_position({x, y, z});
        if (!is_kept(place, planes)) continue;
        const auto steps = static_cast<double>(step);
        sink({place, here * volume * steps * steps * steps, axes * (0.6 * steps)});
      }
    }
  }
}

// A normalized set fills the volume of its kernels, as far as they are most of what is there; of a
// sum, a kernel's content stands for the volume that holds as much where it lies.
void add_kernels(const KernelField& field, const Extinction& extinction,
                 const std::vector<ClipPlane>& planes, const VisiblePointSink& sink,
                 std::int64_t most) {
  const KernelSource& source = field.source();
  const bool is_sum = field.reconstruction() == Reconstruction::kSum;
  const double integral = profile_integral(source.profile(), source.cutoff());
  const auto attribute = static_cast<std::size_t>(field.attribute());
  const auto stands_for = static_cast<double>(
      is_sum ? field.sums()->stride : data::stride_for(source.num_kernels(), most));
  constexpr double kReach = 1.5;  // sigmas
  for_values_at_kernels(
      field, most,
      [&](const KernelBrick& brick, const KernelView& view, std::int32_t i, double value) {
        const Vec3 place = brick.origin + data::offset_of(view, i);
        if (!is_kept(place, planes)) return;
        const Mat3 factor =
            data::factor_of(source.shape(), data::shape_numbers(view, source.shape(), i).data());
        const double content = data::weight_of(view, i) * integral * std::abs(factor.determinant());
        const double own = view.value[attribute][i];
        const double volume = is_sum && value != 0 ? std::abs(content * own / value) : content;
        const double here = extinction.at(static_cast<float>(value));
        if (here > 0) sink({place, here * volume * stands_for, factor * kReach});
      });
}

}  // namespace

bool is_kept(const Vec3& place, const std::vector<ClipPlane>& planes) {
  return std::all_of(planes.begin(), planes.end(), [&](const ClipPlane& plane) {
    return plane.normal.dot(place) >= plane.offset;
  });
}

void for_visible_points(const Field& field, const Look& look,
                        const std::vector<ClipPlane>& clip_planes, const VisiblePointSink& sink,
                        std::int64_t most) {
  const Extinction extinction(field, look);
  if (field.lattice() != nullptr) {
    add_samples(*field.lattice(), extinction, clip_planes, sink, most);
  } else {
    add_kernels(*field.kernels(), extinction, clip_planes, sink, most);
  }
}

}  // namespace ovoid::view
