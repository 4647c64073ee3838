// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "ovoid/look.h"
#include "ovoid/renderer.h"
#include "render/reference/field_evaluator.h"
#include "render/reference/shading.h"
#include "render/reference/view_rays.h"

namespace ovoid::reference {

struct Pixel {
  std::array<double, 4> rgba{};  // premultiplied
  double depth = std::numeric_limits<double>::infinity();
};

// What was done for some pixels.
struct TraceCounts {
  std::int64_t samples = 0;
  std::int64_t visible = 0;    // samples with a non-zero opacity
  std::int64_t gradients = 0;  // samples whose gradient was used
};

// One pixel after the other, one sample of its ray after the other: docs/numerics.md from "Slabs"
// to "Modes". Immutable after construction: any number of threads may trace at once.
class PixelTracer {
 public:
  // Camera, look and options are valid; `field` and `evaluator` (of that field) outlive the tracer.
  PixelTracer(const LatticeField& field, const FieldEvaluator& evaluator, const Camera& camera,
              const Look& look, const RenderOptions& options);

  Pixel trace(int x, int y, TraceCounts& counts) const;

 private:
  // What a mode sees of a ray: the ray itself, and its samples by sheet.
  struct PixelRay {
    int x;
    int y;
    Ray ray;
    SheetRange sheets;
  };
  struct RaySample {
    std::int64_t sheet;
    double z;
    double path;
    double value;
    Vec3 exact_gradient;
  };

  std::optional<RaySample> sample(const PixelRay& pixel, std::int64_t sheet,
                                  TraceCounts& counts) const;
  FieldSample field_at(int x, int y, std::int64_t sheet) const;
  Vec3 gradient(const PixelRay& pixel, const RaySample& sample) const;
  Vec3 piece_gradient(const PixelRay& pixel, const RaySample& from, const RaySample& to) const;
  Vec3 own_gradient(const Vec3& exact, const Vec3& position, const Vec3& widening) const;
  Vec3 central_gradient(const PixelRay& pixel, const RaySample& sample) const;

  ClassifiedSample classified_sample(const std::optional<RaySample>& before,
                                     const RaySample& at) const;

  Pixel composite(const PixelRay& pixel, TraceCounts& counts) const;
  Pixel xray(const PixelRay& pixel, TraceCounts& counts) const;
  Pixel maximum(const PixelRay& pixel, TraceCounts& counts) const;
  Pixel mean(const PixelRay& pixel, TraceCounts& counts) const;
  Pixel isosurface(const PixelRay& pixel, TraceCounts& counts) const;
  double refined_crossing(const PixelRay& pixel, const RaySample& near, const RaySample& far) const;
  FieldSample field_on_ray(const Ray& ray, double z, const Vec3& widening) const;
  Pixel classified(double value, double depth, TraceCounts& counts) const;

  const FieldEvaluator& evaluator_;
  const Look look_;
  const Slab slab_;
  const GradientMethod gradient_method_;
  const Classification classification_;
  const TransferFunction fading_;  // opacity by the gradient's length; without points 1
  const ViewRays view_;
  const Affine3 index_from_world_;
  const Bounds3 support_;  // index space, the whole frame's
  ShadingContext shading_;
};

}  // namespace ovoid::reference
