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

#include "data/kernels/kernel_shape.h"
#include "ovoid/error.h"

namespace ovoid::reference {
namespace {

// docs/numerics.md: sigma is at least 0.65 pixels and half a sheet.
constexpr double kLeastSquaredSigma = 0.25;
constexpr double kLeastPixels = 1.3;
// docs/numerics.md, "Levels", of the published ways.
constexpr std::size_t kNumLevels = 7;
constexpr double kLeastLevelSigma = 0.5;  // samples

constexpr int kSlabPoints = 64;  // where a mean has no closed form

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

// The place among the samples of a level of sample i of the next finer one: a quarter of a sample
// before or behind one of them.
double coarse_place(int i) { return 0.5 * i - 0.25; }

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

// Where the section of the slab [a, b] ends: first such that it has the mean of m^2 along the ray,
// then such that it has the slab's mass, by one step of Newton's. `most`: the squared cut-off.
double room_of_mass(double a, double b, const Moments& moments, double most) {
  const double room = most - moments.mean * moments.mean - moments.variance;
  if (!(room > 1) || !(moments.weight > 1e-12)) return room;
  // Of exp(-q / 2) less its tangent at an end: what the end takes of the mass 2, over all q.
  const auto taken = [](double end) { return 2 + end + end * end / 4; };
  const double at_end = moments.weight * std::exp(-room / 2);
  const double takes =
      std::exp(-most / 2) *
      (taken(most) * (b - a) - (1 + most / 2) * (std::pow(b, 3) - std::pow(a, 3)) / 3 +
       (std::pow(b, 5) - std::pow(a, 5)) / 20);
  return room + (at_end * taken(room) - takes) / (at_end * room * room / 8);
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
                           const Way& way)
    : view_(view),
      sheets_(sheets),
      profile_(field.source().profile()),
      cutoff_(field.source().cutoff()),
      is_sum_(field.reconstruction() == Reconstruction::kSum),
      has_own_color_(field.has_own_color()),
      way_(way) {
  add_levels(rows);
  for (const ViewedKernel& kernel : kernels) add_kernel(kernel);
  for (std::size_t l = levels_.size() - 1; l > 0; --l) post_convolve(levels_[l], levels_[l - 1]);
}

// The pixels and one more on every side; of each coarser level what its finer one is made from.
void KernelPlanes::add_levels(const Rows& rows) {
  const std::int64_t num_sheets = std::max<std::int64_t>(0, sheets_.last - sheets_.first + 1);
  Level level{1, -1, rows.width + 1, rows.y0 - 1, rows.y1 + 1, {}};
  const std::size_t num_levels = is_published(way_.post_convolution) ? kNumLevels : 1;
  while (true) {
    try {
      level.cells.resize(level.index_of(level.x0, level.y0, num_sheets));
    } catch (const std::bad_alloc&) {
      throw Error(ErrorCode::kOutOfMemory,
                  "sampling_distance: no memory for " + std::to_string(num_sheets) + " sheets");
    }
    levels_.push_back(std::move(level));
    if (levels_.size() == num_levels) return;
    const Level& finer = levels_.back();
    const auto taps_of = [&](int sample) {
      return taps_at(way_.post_convolution, coarse_place(sample));
    };
    const auto end_of = [](const FilterTaps& taps) {
      return static_cast<int>(taps.first) + static_cast<int>(taps.weight.size());
    };
    level = {2 * finer.step,
             static_cast<int>(taps_of(finer.x0).first),
             end_of(taps_of(finer.x1 - 1)),
             static_cast<int>(taps_of(finer.y0).first),
             end_of(taps_of(finer.y1 - 1)),
             {}};
  }
}

void KernelPlanes::add_kernel(const ViewedKernel& kernel) {
  const double reach = cutoff_ * std::sqrt(kernel.covariance(2, 2));
  const double slab = way_.is_mean ? 0.5 * view_.sampling_distance() : 0.0;
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
  Level& level = levels_[level_for(kernel, z)];
  if (!way_.is_mean) {
    add_section(kernel, middle_section(kernel, z), sheet, z, level);
  } else if (profile_ == KernelProfile::kGaussian) {
    add_section(kernel, mean_section(kernel, z), sheet, z, level);
  } else {
    for (int point = 0; point < kSlabPoints; ++point) {
      const double at = z + ((point + 0.5) / kSlabPoints - 0.5) * view_.sampling_distance();
      Section section = middle_section(kernel, at);
      section.amplitude /= kSlabPoints;
      add_section(kernel, section, sheet, at, level);
    }
  }
}

// The coarsest level that shows the kernel on the sheet at z, by the cut with the middle plane
// whatever is then added.
std::size_t KernelPlanes::level_for(const ViewedKernel& kernel, double z) const {
  const Eigen::Matrix2d cut = middle_section(kernel, z).covariance;
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(cut).eigenvalues()[0];
  const double sigma = std::sqrt(std::max(least, 0.0)) / view_.pitch_at(z);  // pixels
  std::size_t l = levels_.size() - 1;
  while (l > 0 && !(sigma >= kLeastLevelSigma * levels_[l].step)) --l;
  return l;
}

void KernelPlanes::post_convolve(const Level& coarse, Level& fine) const {
  const std::int64_t num_sheets = std::max<std::int64_t>(0, sheets_.last - sheets_.first + 1);
  for (std::int64_t plane = 0; plane < num_sheets; ++plane) {
    for (int y = fine.y0; y < fine.y1; ++y) {
      const FilterTaps taps_y = taps_at(way_.post_convolution, coarse_place(y));
      for (int x = fine.x0; x < fine.x1; ++x) {
        const FilterTaps taps_x = taps_at(way_.post_convolution, coarse_place(x));
        Cell& cell = fine.cells[fine.index_of(x, y, plane)];
        for (std::size_t j = 0; j < taps_y.weight.size(); ++j) {
          for (std::size_t i = 0; i < taps_x.weight.size(); ++i) {
            const double weight = taps_x.weight[i] * taps_y.weight[j];
            const Cell& from = coarse.cells[coarse.index_of(
                static_cast<int>(taps_x.first) + static_cast<int>(i),
                static_cast<int>(taps_y.first) + static_cast<int>(j), plane)];
            cell.numerator += weight * from.numerator;
            cell.denominator += weight * from.denominator;
            cell.color_numerator += weight * from.color_numerator;
          }
        }
      }
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
  const double from = std::clamp((t - ds / 2) / sigma, -cutoff_, cutoff_);
  const double to = std::clamp((t + ds / 2) / sigma, -cutoff_, cutoff_);
  const Moments moments = moments_between(from, to);
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
  section.room = room_of_mass(from, to, moments, cutoff_ * cutoff_);
  section.q_along = cutoff_ * cutoff_ - section.room;
  section.amplitude *= std::exp(section.q_along / 2);
  return section;
}

void KernelPlanes::add_section(const ViewedKernel& kernel, const Section& section,
                               std::int64_t sheet, double z, Level& level) {
  if (!(section.room > 0) || !(section.amplitude > 0) || !(view_.pitch_at(z) > 0)) return;
  const Eigen::Matrix2d precision = section.covariance.inverse();
  const double reach_x = std::sqrt(section.room * section.covariance(0, 0));
  const double reach_y = std::sqrt(section.room * section.covariance(1, 1));
  const auto range = [&](double lo, double hi, int least, int most) {
    return std::pair(
        static_cast<int>(std::clamp(std::ceil(level.sample_of(lo)), 1.0 * least, most + 1.0)),
        static_cast<int>(std::clamp(std::floor(level.sample_of(hi)), least - 1.0, 1.0 * most)));
  };
  const auto [y0, y1] = range(view_.row_of(section.y - reach_y, z),
                              view_.row_of(section.y + reach_y, z), level.y0, level.y1 - 1);
  const auto [x0, x1] = range(view_.column_of(section.x - reach_x, z),
                              view_.column_of(section.x + reach_x, z), level.x0, level.x1 - 1);
  for (int y = y0; y <= y1; ++y) {
    const double dy = view_.below_of(level.pixel_of(y), z) - section.y;
    for (int x = x0; x <= x1; ++x) {
      const double dx = view_.right_of(level.pixel_of(x), z) - section.x;
      const double q =
          precision(0, 0) * dx * dx + 2 * precision(0, 1) * dx * dy + precision(1, 1) * dy * dy;
      if (q > section.room) continue;
      // A mean's section is a Gaussian whatever was integrated.
      const double phi =
          kernel.weight * section.amplitude *
          profile_value(profile_, std::min(std::sqrt(q + section.q_along), cutoff_), cutoff_);
      Cell& cell = level.cells[level.index_of(x, y, sheet - sheets_.first)];
      const double share = phi * kernel.value;
      cell.numerator += share;
      cell.denominator += phi;
      cell.color_numerator += (is_sum_ ? share : phi) * kernel.color_value;
    }
  }
}

KernelPlanes::Sample KernelPlanes::at(int x, int y, std::int64_t sheet) const {
  const Level& pixels = levels_.front();
  if (x < pixels.x0 || x >= pixels.x1 || y < pixels.y0 || y >= pixels.y1 || sheet < sheets_.first ||
      sheet > sheets_.last)
    return {};
  const Cell& cell = pixels.cells[pixels.index_of(x, y, sheet - sheets_.first)];
  const double whole = is_sum_ ? cell.numerator : cell.denominator;
  if (is_sum_ ? whole == 0 : !(whole >= KernelField::kLeastWeight)) return {};
  const double value = is_sum_ ? whole : cell.numerator / whole;
  return {value, has_own_color_ ? cell.color_numerator / whole : value, true};
}

}  // namespace ovoid::reference
