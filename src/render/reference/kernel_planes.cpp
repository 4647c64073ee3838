// SPDX-License-Identifier: Apache-2.0
// docs/numerics.md, "Kernel sets", word for word: every kernel adds its section to every sample of
// every sheet that its support holds.
#include "render/reference/kernel_planes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <new>
#include <numbers>

#include "data/kernel_shape.h"
#include "ovoid/error.h"

namespace ovoid::reference {
namespace {

// docs/numerics.md: sigma is at least 0.65 pixels and half a sheet.
constexpr double kLeastSquaredSigma = 0.25;
constexpr double kLeastPixels = 1.3;
constexpr int kSlabNodes = 64;  // where a mean has no closed form

// Raises what is less than kLeastSquaredSigma in these units; the mass stays.
void widen(ViewedKernel& kernel, const Vec3& units) {
  const Mat3 scaled =
      units.cwiseInverse().asDiagonal() * kernel.covariance * units.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(scaled);
  const Vec3& before = solver.eigenvalues();
  if (before.minCoeff() >= kLeastSquaredSigma) return;
  const Vec3 after = before.cwiseMax(kLeastSquaredSigma);
  const Mat3 wider = solver.eigenvectors() * after.asDiagonal() * solver.eigenvectors().transpose();
  // The kernel's own determinant, as its eigenvalues may have lost the smallest.
  kernel.weight *= std::sqrt(std::max(scaled.determinant(), 0.0) / after.prod());
  kernel.covariance = units.asDiagonal() * wider * units.asDiagonal();
}

// Integral, mean and variance of exp(-x^2 / 2) on [a, b].
struct Moments {
  double weight, mean, variance;
};

Moments moments_between(double a, double b) {
  const double weight = std::sqrt(std::numbers::pi / 2) *
                        (std::erf(b / std::numbers::sqrt2) - std::erf(a / std::numbers::sqrt2));
  if (!(weight > 0)) return {0, 0.5 * (a + b), 0};
  const double mean = (std::exp(-a * a / 2) - std::exp(-b * b / 2)) / weight;
  const double spread =
      1 + (a * std::exp(-a * a / 2) - b * std::exp(-b * b / 2)) / weight - mean * mean;
  return {weight, mean, std::max(spread, 0.0)};
}

}  // namespace

std::vector<ViewedKernel> view_kernels(const KernelField& field, const ViewRays& view) {
  const KernelSource& source = field.source();
  const Mat3 axes = view.camera_axes();
  std::vector<ViewedKernel> kernels;
  kernels.reserve(static_cast<std::size_t>(source.num_kernels()));
  for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
    const KernelView some = source.acquire(b, 0.0);
    for (std::int32_t i = 0; i < some.count; ++i) {
      const auto numbers = data::shape_numbers(some, source.shape(), i);
      const Mat3 factor = axes * data::factor_of(source.shape(), numbers.data());
      ViewedKernel kernel;
      kernel.center = view.camera_from_world(source.brick(b).origin + data::offset_of(some, i));
      kernel.covariance = factor * factor.transpose();
      kernel.weight = data::weight_of(some, i);
      kernel.value = some.value[static_cast<std::size_t>(field.attribute())][i];
      kernel.color_value = some.value[static_cast<std::size_t>(field.color_attribute())][i];
      const double z = view.is_perspective() ? std::max(kernel.center[2], view.z_near()) : 0.0;
      const double pitch = view.pitch_at(z);
      widen(kernel, Vec3(kLeastPixels * pitch, kLeastPixels * pitch, view.sampling_distance()));
      kernels.push_back(kernel);
    }
  }
  return kernels;
}

KernelPlanes::KernelPlanes(const KernelField& field, const std::vector<ViewedKernel>& kernels,
                           const ViewRays& view, const SheetRange& sheets, const Rows& rows,
                           bool is_mean)
    : view_(view),
      sheets_(sheets),
      rows_(rows),
      profile_(field.source().profile()),
      cutoff_(field.source().cutoff()),
      is_sum_(field.reconstruction() == Reconstruction::kSum),
      has_own_color_(field.has_own_color()),
      is_mean_(is_mean) {
  const auto num_sheets =
      static_cast<std::size_t>(std::max<std::int64_t>(0, sheets.last - sheets.first + 1));
  try {
    cells_.resize(num_sheets * static_cast<std::size_t>(rows.y1 - rows.y0 + 2) *
                  static_cast<std::size_t>(rows.width + 2));
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory,
                "sampling_distance: no memory for " + std::to_string(num_sheets) + " sheets");
  }
  for (const ViewedKernel& kernel : kernels) add_kernel(kernel);
}

void KernelPlanes::add_kernel(const ViewedKernel& kernel) {
  const double reach = cutoff_ * std::sqrt(kernel.covariance(2, 2));
  const double slab = is_mean_ ? 0.5 * view_.sampling_distance() : 0.0;
  const double first = std::ceil(view_.sheet_of(kernel.center[2] - reach - slab));
  const double last = std::floor(view_.sheet_of(kernel.center[2] + reach + slab));
  const auto from = static_cast<std::int64_t>(std::max(first, static_cast<double>(sheets_.first)));
  const auto to = static_cast<std::int64_t>(std::min(last, static_cast<double>(sheets_.last)));
  for (std::int64_t sheet = from; sheet <= to; ++sheet) {
    if (view_.exists(sheet)) add_sheet(kernel, sheet);
  }
}

void KernelPlanes::add_sheet(const ViewedKernel& kernel, std::int64_t sheet) {
  const double z = view_.z_of(sheet);
  if (!is_mean_) {
    add_section(kernel, middle_section(kernel, z), sheet, z);
  } else if (profile_ == KernelProfile::kGaussian) {
    add_section(kernel, mean_section(kernel, z), sheet, z);
  } else {
    for (int node = 0; node < kSlabNodes; ++node) {
      const double at = z + ((node + 0.5) / kSlabNodes - 0.5) * view_.sampling_distance();
      Section section = middle_section(kernel, at);
      section.amplitude /= kSlabNodes;
      add_section(kernel, section, sheet, at);
    }
  }
}

// The cut with the plane at z: an ellipse of one shape whose centre slides with z [METHOD 5.2].
KernelPlanes::Section KernelPlanes::middle_section(const ViewedKernel& kernel, double z) const {
  const double t = z - kernel.center[2];
  const double along = kernel.covariance(2, 2);
  const Eigen::Vector2d across = kernel.covariance.topRightCorner<2, 1>();
  const Eigen::Vector2d slide = across / along;
  Section section;
  section.x = kernel.center[0] + slide[0] * t;
  section.y = kernel.center[1] + slide[1] * t;
  section.covariance = kernel.covariance.topLeftCorner<2, 2>() - across * slide.transpose();
  section.amplitude = 1;
  section.q_along = t * t / along;
  section.room = cutoff_ * cutoff_ - section.q_along;
  return section;
}

// The mean over the slab around z: the part of the kernel within, as one Gaussian at its mean place
// along the ray, widened by the spread of that place [METHOD 5.2, step 6].
KernelPlanes::Section KernelPlanes::mean_section(const ViewedKernel& kernel, double z) const {
  const double ds = view_.sampling_distance();
  const double sigma = std::sqrt(kernel.covariance(2, 2));
  const double t = z - kernel.center[2];
  const Moments moments = moments_between(std::clamp((t - ds / 2) / sigma, -cutoff_, cutoff_),
                                          std::clamp((t + ds / 2) / sigma, -cutoff_, cutoff_));
  Section section = middle_section(kernel, z);
  const Eigen::Vector2d slide = kernel.covariance.topRightCorner<2, 1>() / kernel.covariance(2, 2);
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();
  if (view_.is_perspective()) ray = Eigen::Vector2d(section.x, section.y) / z;
  const Eigen::Vector2d drift = slide - ray;
  const Eigen::Matrix2d before = section.covariance;
  section.covariance += moments.variance * sigma * sigma * drift * drift.transpose();
  section.x += drift[0] * (moments.mean * sigma - t);
  section.y += drift[1] * (moments.mean * sigma - t);
  section.amplitude = moments.weight * sigma / ds *
                      std::sqrt(before.determinant() / section.covariance.determinant());
  section.q_along = 0;
  section.room = cutoff_ * cutoff_;
  return section;
}

void KernelPlanes::add_section(const ViewedKernel& kernel, const Section& section,
                               std::int64_t sheet, double z) {
  if (!(section.room > 0) || !(section.amplitude > 0) || !(view_.pitch_at(z) > 0)) return;
  const Eigen::Matrix2d precision = section.covariance.inverse();
  const double reach_x = std::sqrt(section.room * section.covariance(0, 0));
  const double reach_y = std::sqrt(section.room * section.covariance(1, 1));
  const auto range = [](double lo, double hi, int least, int most) {
    return std::pair(static_cast<int>(std::clamp(std::ceil(lo), 1.0 * least, most + 1.0)),
                     static_cast<int>(std::clamp(std::floor(hi), least - 1.0, 1.0 * most)));
  };
  const auto [y0, y1] = range(view_.row_of(section.y - reach_y, z),
                              view_.row_of(section.y + reach_y, z), rows_.y0 - 1, rows_.y1);
  const auto [x0, x1] = range(view_.column_of(section.x - reach_x, z),
                              view_.column_of(section.x + reach_x, z), -1, rows_.width);
  for (int y = y0; y <= y1; ++y) {
    const double dy = view_.below_of(y, z) - section.y;
    for (int x = x0; x <= x1; ++x) {
      const double dx = view_.right_of(x, z) - section.x;
      const double q =
          precision(0, 0) * dx * dx + 2 * precision(0, 1) * dx * dy + precision(1, 1) * dy * dy;
      if (q > section.room) continue;
      // A mean's section is a Gaussian whatever was integrated.
      const double phi =
          kernel.weight * section.amplitude *
          profile_value(profile_, std::min(std::sqrt(q + section.q_along), cutoff_), cutoff_);
      Cell& cell = cells_[index_of(x, y, sheet)];
      const double share = phi * kernel.value;
      cell.numerator += share;
      cell.denominator += phi;
      cell.color_numerator += (is_sum_ ? share : phi) * kernel.color_value;
    }
  }
}

bool KernelPlanes::holds(int x, int y, std::int64_t sheet) const {
  return x >= -1 && x <= rows_.width && y >= rows_.y0 - 1 && y <= rows_.y1 &&
         sheet >= sheets_.first && sheet <= sheets_.last;
}

std::size_t KernelPlanes::index_of(int x, int y, std::int64_t sheet) const {
  const auto plane = static_cast<std::size_t>(sheet - sheets_.first);
  const auto rows = static_cast<std::size_t>(rows_.y1 - rows_.y0) + 2;
  const auto columns = static_cast<std::size_t>(rows_.width) + 2;
  const int row = y - rows_.y0 + 1;
  const int column = x + 1;
  return (plane * rows + static_cast<std::size_t>(row)) * columns +
         static_cast<std::size_t>(column);
}

KernelPlanes::Sample KernelPlanes::at(int x, int y, std::int64_t sheet) const {
  if (!holds(x, y, sheet)) return {};
  const Cell& cell = cells_[index_of(x, y, sheet)];
  const double whole = is_sum_ ? cell.numerator : cell.denominator;
  if (is_sum_ ? whole == 0 : !(whole >= KernelField::kLeastWeight)) return {};
  const double value = is_sum_ ? whole : cell.numerator / whole;
  return {value, has_own_color_ ? cell.color_numerator / whole : value, true};
}

}  // namespace ovoid::reference
