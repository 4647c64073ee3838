// SPDX-License-Identifier: Apache-2.0
#include "render/reference/kernel_tracer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "ovoid/error.h"

namespace ovoid::reference {

KernelTracer::KernelTracer(const KernelField& field, KernelPlanes planes, const ViewRays& view,
                           const SheetRange& sheets, const Look& look, const RenderOptions& options,
                           const BesideTracer& beside, const view::LightVolume* light)
    : PixelTracer(field, view, look, options, beside, light),
      planes_(std::move(planes)),
      sheets_(sheets) {}

SheetRange KernelTracer::sheets_of(const Ray& /*ray*/) const { return sheets_; }

std::optional<PixelTracer::RaySample> KernelTracer::sample(const PixelRay& pixel,
                                                           std::int64_t sheet,
                                                           TraceCounts& counts) const {
  if (!view().exists(sheet)) return std::nullopt;
  const double path = view().path(pixel.ray, sheet);
  if (!(path > 0) && !is_refined()) return std::nullopt;
  ++counts.samples;
  const KernelPlanes::Sample at = planes_.at(pixel.x, pixel.y, sheet);
  if (!at.is_defined) return std::nullopt;
  return RaySample{sheet, view().z_of(sheet), path, at.value, at.color_value, Vec3::Zero()};
}

// Central differences, one-sided where one neighbour is undefined, zero where both are.
Vec3 KernelTracer::gradient(const PixelRay& pixel, const RaySample& sample) const {
  const auto difference = [&](int dx, int dy, int dk) -> double {
    const auto before = planes_.at(pixel.x - dx, pixel.y - dy, sample.sheet - dk);
    const auto behind = planes_.at(pixel.x + dx, pixel.y + dy, sample.sheet + dk);
    if (before.is_defined && behind.is_defined) return 0.5 * (behind.value - before.value);
    if (before.is_defined) return sample.value - before.value;
    if (behind.is_defined) return behind.value - sample.value;
    return 0;
  };
  const Vec3 differences(difference(1, 0, 0), difference(0, 1, 0), difference(0, 0, 1));
  return view().position_derivatives(pixel.ray, sample.sheet).transpose().inverse() * differences;
}

Vec3 KernelTracer::piece_gradient(const PixelRay& pixel, const RaySample& /*from*/,
                                  const RaySample& to) const {
  return gradient(pixel, to);
}

// On the straight line between the two samples.
PixelTracer::Crossing KernelTracer::crossing(const PixelRay& pixel, const RaySample& near,
                                             const RaySample& far, double isovalue) const {
  const double t = (isovalue - near.value) / (far.value - near.value);
  Crossing at{near.z + t * (far.z - near.z), std::lerp(near.color_value, far.color_value, t),
              Vec3::Zero()};
  if (look().shade) at.gradient = (1 - t) * gradient(pixel, near) + t * gradient(pixel, far);
  return at;
}

KernelTrailTracer::KernelTrailTracer(const KernelField& like, std::vector<Moment> moments,
                                     const ViewRays& view, const SheetRange& sheets,
                                     const Look& look, const RenderOptions& options)
    : PixelTracer(like, view, look, options), moments_(std::move(moments)), sheets_(sheets) {}

SheetRange KernelTrailTracer::sheets_of(const Ray& /*ray*/) const { return sheets_; }

std::optional<PixelTracer::RaySample> KernelTrailTracer::sample(const PixelRay& pixel,
                                                                std::int64_t sheet,
                                                                TraceCounts& counts) const {
  if (!view().exists(sheet)) return std::nullopt;
  const double path = view().path(pixel.ray, sheet);
  if (!(path > 0)) return std::nullopt;
  ++counts.samples;
  RaySample mean{sheet, view().z_of(sheet), path, 0, 0, Vec3::Zero(), false, 0};
  for (const auto& [planes, share] : moments_) {
    const KernelPlanes::Sample at = planes.at(pixel.x, pixel.y, sheet);
    if (!at.is_defined) continue;
    mean.value += share * at.value;
    mean.color_value += share * at.color_value;
    mean.presence += share;
  }
  if (!(mean.presence > 0)) return std::nullopt;
  mean.value /= mean.presence;
  mean.color_value /= mean.presence;
  if (moments_.size() == 1) mean.presence = 1;
  return mean;
}

Vec3 KernelTrailTracer::gradient(const PixelRay& /*pixel*/, const RaySample& /*sample*/) const {
  return Vec3::Zero();
}

Vec3 KernelTrailTracer::piece_gradient(const PixelRay& /*pixel*/, const RaySample& /*from*/,
                                       const RaySample& /*to*/) const {
  return Vec3::Zero();
}

PixelTracer::Crossing KernelTrailTracer::crossing(const PixelRay& /*pixel*/, const RaySample& near,
                                                  const RaySample& /*far*/,
                                                  double /*isovalue*/) const {
  return {near.z, near.color_value, Vec3::Zero()};
}

SheetRange sheets_reached(const std::vector<ViewedKernel>& kernels, const ViewRays& view,
                          double cutoff) {
  constexpr double kMostSheets = 1 << 20;
  double lo = std::numeric_limits<double>::infinity();
  double hi = -lo;
  for (const ViewedKernel& kernel : kernels) {
    const double reach = cutoff * std::sqrt(kernel.covariance(2, 2));
    lo = std::min(lo, kernel.center[2] - reach);
    hi = std::max(hi, kernel.center[2] + reach);
  }
  if (view.is_perspective()) lo = std::max(lo, view.z_near());
  if (!(lo <= hi)) return {};
  const double first = std::floor(view.sheet_of(lo)) - 1;
  const double last = std::ceil(view.sheet_of(hi)) + 1;
  if (!(last - first <= kMostSheets && std::abs(first) < 1e15 && std::abs(last) < 1e15)) {
    throw Error(ErrorCode::kInvalidArgument,
                "sampling_distance = " + std::to_string(view.sampling_distance()) +
                    ": too small for these kernels; expected at most 2^20 sheets");
  }
  return {static_cast<std::int64_t>(first), static_cast<std::int64_t>(last)};
}

}  // namespace ovoid::reference
