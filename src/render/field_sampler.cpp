// SPDX-License-Identifier: Apache-2.0
#include <optional>
#include <utility>

#include "ovoid/sampler.h"
#include "render/reference/field_evaluator.h"

namespace ovoid {

// One of both.
struct FieldSampler::Impl {
  std::optional<KernelSampler> kernels;
  std::optional<reference::FieldEvaluator> lattice;
};

FieldSampler::FieldSampler(const Field& field) {
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
  const reference::FieldSample at = impl_->lattice->at_world(world);
  return {at.value, at.value, at.gradient, at.weight, at.is_defined};
}

}  // namespace ovoid
