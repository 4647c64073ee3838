// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "data/validate.h"
#include "ovoid/sampler.h"
#include "render/reference/field_evaluator.h"

namespace ovoid {

namespace {

FieldSample plain_sample(const reference::FieldSample& at) {
  return {at.value, at.value, at.gradient, at.weight, at.is_defined};
}

}  // namespace

// One of both.
struct FieldSampler::Impl {
  std::optional<KernelSampler> kernels;
  std::optional<reference::FieldEvaluator> lattice;
};

FieldSampler::FieldSampler(const Field& field) {
  data::require_field(field);
  auto impl = std::make_unique<Impl>();
  if (const KernelField* const set = field.kernels()) {
    impl->kernels.emplace(*set);
  } else {
    impl->lattice.emplace(*field.lattice());
  }
  impl_ = std::move(impl);
}

FieldSampler::~FieldSampler() = default;
FieldSampler::FieldSampler(FieldSampler&&) noexcept = default;
FieldSampler& FieldSampler::operator=(FieldSampler&&) noexcept = default;

FieldSample FieldSampler::at(const Vec3& world) const {
  if (impl_->kernels) return impl_->kernels->at(world);
  return plain_sample(impl_->lattice->at_world(world));
}

// One of both.
struct FieldProbe::Impl {
  std::optional<KernelSampler> kernels;
  LatticeField lattice;
  Affine3 index_from_world;
  double reach = 0;  // index units

  // The samples lo <= (i, j, k) < hi in reach of a place in index space, of both sublattices, one
  // more to each side. False if there are none.
  bool samples_in_reach(const Vec3& u, Index3& lo, Index3& hi) const {
    const LatticeGeometry& geometry = lattice.geometry();
    for (int a = 0; a < 3; ++a) {
      const auto i = static_cast<std::size_t>(a);
      const double per_unit = a == 2 ? geometry.num_sublattices() : 1;
      const double shift = a == 2 ? 0.0 : geometry.offset_of(geometry.num_sublattices() - 1)[a];
      const double first = std::floor((u[a] - reach - shift) * per_unit) - 1;
      const double last = std::ceil((u[a] + reach) * per_unit) + 1;
      const auto end = static_cast<double>(geometry.dims[i]);
      if (!(first < end && last >= 0)) return false;  // nor of what is no number
      lo[i] = static_cast<std::int64_t>(std::max(first, 0.0));
      hi[i] = static_cast<std::int64_t>(std::min(last + 1, end));
    }
    return true;
  }
};

FieldProbe::FieldProbe(const Field& field) {
  data::require_field(field);
  auto impl = std::make_unique<Impl>();
  if (const KernelField* const set = field.kernels()) {
    impl->kernels.emplace(*set);
  } else {
    impl->lattice = *field.lattice();
    impl->index_from_world = impl->lattice.geometry().world_from_index.inverse();
    impl->reach = impl->lattice.index_kernel().support_radius();
  }
  impl_ = std::move(impl);
}

FieldProbe::~FieldProbe() = default;
FieldProbe::FieldProbe(FieldProbe&&) noexcept = default;
FieldProbe& FieldProbe::operator=(FieldProbe&&) noexcept = default;

FieldSample FieldProbe::at(const Vec3& world) const {
  if (impl_->kernels) return impl_->kernels->at(world);
  Index3 lo, hi;
  if (!impl_->samples_in_reach(impl_->index_from_world * world, lo, hi)) return {};
  return plain_sample(reference::FieldEvaluator(impl_->lattice, lo, hi).at_world(world));
}

}  // namespace ovoid
