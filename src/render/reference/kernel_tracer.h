// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "render/reference/kernel_planes.h"
#include "render/reference/pixel_tracer.h"

namespace ovoid::reference {

// Rays through the samples of a kernel field, which are all there beforehand.
class KernelTracer final : public PixelTracer {
 public:
  // `planes` hold the rows that are traced.
  KernelTracer(const KernelField& field, KernelPlanes planes, const ViewRays& view,
               const SheetRange& sheets, const Look& look, const RenderOptions& options,
               const BesideTracer& beside = {}, const view::LightVolume* light = nullptr);

 private:
  SheetRange sheets_of(const Ray& ray) const override;
  std::optional<RaySample> sample(const PixelRay& pixel, std::int64_t sheet,
                                  TraceCounts& counts) const override;
  Vec3 gradient(const PixelRay& pixel, const RaySample& sample) const override;
  Vec3 piece_gradient(const PixelRay& pixel, const RaySample& from,
                      const RaySample& to) const override;
  Crossing crossing(const PixelRay& pixel, const RaySample& near, const RaySample& far,
                    double isovalue) const override;

  const KernelPlanes planes_;
  const SheetRange sheets_;
};

// The mean of a trail's moments: samples alone, without gradients.
class KernelTrailTracer final : public PixelTracer {
 public:
  struct Moment {
    KernelPlanes planes;
    double share;
  };
  // `like`: one of the fields. The planes hold the rows that are traced on these sheets.
  KernelTrailTracer(const KernelField& like, std::vector<Moment> moments, const ViewRays& view,
                    const SheetRange& sheets, const Look& look, const RenderOptions& options);

 private:
  SheetRange sheets_of(const Ray& ray) const override;
  std::optional<RaySample> sample(const PixelRay& pixel, std::int64_t sheet,
                                  TraceCounts& counts) const override;
  Vec3 gradient(const PixelRay& pixel, const RaySample& sample) const override;
  Vec3 piece_gradient(const PixelRay& pixel, const RaySample& from,
                      const RaySample& to) const override;
  Crossing crossing(const PixelRay& pixel, const RaySample& near, const RaySample& far,
                    double isovalue) const override;

  const std::vector<Moment> moments_;
  const SheetRange sheets_;
};

// The sheets that a field's kernels reach.
SheetRange sheets_reached(const std::vector<ViewedKernel>& kernels, const ViewRays& view,
                          double cutoff);

}  // namespace ovoid::reference
