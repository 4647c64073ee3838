// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/reference/field_evaluator.h"
#include "render/reference/pixel_tracer.h"

namespace ovoid::reference {

// Rays through a lattice field: a sample is asked for where it is needed.
class LatticeTracer final : public PixelTracer {
 public:
  // Camera, look and options are valid; `field` and `evaluator` (of that field) outlive the tracer.
  LatticeTracer(const LatticeField& field, const FieldEvaluator& evaluator, const Camera& camera,
                const Look& look, const RenderOptions& options);

 private:
  SheetRange sheets_of(const Ray& ray) const override;
  std::optional<RaySample> sample(const PixelRay& pixel, std::int64_t sheet,
                                  TraceCounts& counts) const override;
  Vec3 gradient(const PixelRay& pixel, const RaySample& sample) const override;
  Vec3 piece_gradient(const PixelRay& pixel, const RaySample& from,
                      const RaySample& to) const override;
  Crossing crossing(const PixelRay& pixel, const RaySample& near,
                    const RaySample& far) const override;

  FieldSample field_at(int x, int y, std::int64_t sheet) const;
  FieldSample field_on_ray(const Ray& ray, double z, const Vec3& widening) const;
  Vec3 own_gradient(const Vec3& exact, const Vec3& position, const Vec3& widening) const;
  Vec3 central_gradient(const PixelRay& pixel, const RaySample& sample) const;
  double refined_crossing(const PixelRay& pixel, const RaySample& near, const RaySample& far) const;

  const FieldEvaluator& evaluator_;
  const Slab slab_;
  const GradientMethod gradient_method_;
  const Affine3 index_from_world_;
  const Bounds3 support_;  // index space, the whole frame's
};

}  // namespace ovoid::reference
