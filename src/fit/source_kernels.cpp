// SPDX-License-Identifier: Apache-2.0
#include "fit/source_kernels.h"

#include <cmath>

#include "data/kernels/kernel_shape.h"
#include "model/particles/kernel_parts.h"
#include "ovoid/fit.h"

namespace ovoid::fit {
namespace {

// Of the Gaussian that stands for a kernel of a profile: the factor of its sigmas, of its weight,
// and where it ends.
struct AsGaussian {
  double sigmas = 1, weight = 1, cutoff = 4;
};

AsGaussian as_gaussian(KernelProfile profile, double cutoff) {
  if (profile == KernelProfile::kGaussian) return {1, 1, cutoff};
  AsGaussian as;
  as.sigmas = std::sqrt(data::profile_variance(profile, cutoff));
  as.weight = profile_integral(profile, cutoff) /
              (profile_integral(KernelProfile::kGaussian, as.cutoff) * std::pow(as.sigmas, 3));
  return as;
}

// How many kernels there are per volume, as their own smooth density tells it: its reciprocal is
// the volume that each stands for.
void find_sums_and_volumes(SourceKernels& kernels, int threads, const std::stop_token& stop) {
  kernels.volumes.resize(kernels.count());
  std::vector<float> densities(kernels.count());
  // In units of a typical kernel: lengths may be those of galaxies in centimetres.
  double logarithms = 0;
  for (std::size_t i = 0; i < kernels.count(); ++i) logarithms += std::log(kernels.det(i));
  const double typical = std::exp(logarithms / static_cast<double>(kernels.count()));
  for (std::size_t i = 0; i < kernels.count(); ++i)
    densities[i] = static_cast<float>(typical / kernels.det(i));
  KernelColumns columns = kernels.columns();
  {
    const KernelOperator sums(columns, Reconstruction::kSum, kernels.centers, threads, stop);
    kernels.sums.assign(sums.weights().begin(), sums.weights().end());
  }
  columns.weights = densities;
  const double unit = typical * profile_integral(KernelProfile::kGaussian, kernels.cutoff);
  const KernelOperator per_volume(columns, Reconstruction::kSum, kernels.centers, threads, stop);
  for (std::size_t i = 0; i < kernels.count(); ++i)
    kernels.volumes[i] = unit / static_cast<double>(per_volume.weights()[i]);
}

}  // namespace

Mat3 SourceKernels::factor(std::size_t i) const noexcept {
  return data::factor_of(KernelShape::kEllipsoids, shapes.data() + 6 * i);
}

KernelColumns SourceKernels::columns() const {
  KernelColumns columns;
  columns.shape = KernelShape::kEllipsoids;
  columns.cutoff = cutoff;
  columns.centers = centers;
  columns.shapes = shapes;
  columns.weights = weights;
  return columns;
}

SourceKernels load_source_kernels(const KernelField& field, int threads,
                                  const std::stop_token& stop) {
  const KernelSource& source = field.source();
  const AsGaussian as = as_gaussian(source.profile(), source.cutoff());
  SourceKernels kernels;
  kernels.cutoff = as.cutoff;
  kernels.reconstruction = field.reconstruction();
  kernels.attributes.push_back(source.attributes()[static_cast<std::size_t>(field.attribute())]);
  if (field.has_own_color())
    kernels.attributes.push_back(
        source.attributes()[static_cast<std::size_t>(field.color_attribute())]);
  kernels.values.resize(kernels.attributes.size());
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
    const KernelView view = source.acquire(b, 0.0);
    for (std::int32_t i = 0; i < view.count; ++i) {
      const Vec3 at = source.brick(b).origin + data::offset_of(view, i);
      kernels.centers.insert(kernels.centers.end(), {at[0], at[1], at[2]});
      const auto numbers = data::shape_numbers(view, source.shape(), i);
      model::append_factor(as.sigmas * data::factor_of(source.shape(), numbers.data()),
                           kernels.shapes);
      kernels.weights.push_back(
          static_cast<float>(as.weight * static_cast<double>(data::weight_of(view, i))));
      kernels.values[0].push_back(view.value[static_cast<std::size_t>(field.attribute())][i]);
      if (field.has_own_color())
        kernels.values[1].push_back(
            view.value[static_cast<std::size_t>(field.color_attribute())][i]);
    }
  }
  find_sums_and_volumes(kernels, threads, stop);
  return kernels;
}

}  // namespace ovoid::fit
