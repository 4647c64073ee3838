// SPDX-License-Identifier: Apache-2.0
#include "experiments/control_renderer.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "data/parallel.h"
#include "experiments/pictures.h"

namespace ovoid::experiments {

using reference::FieldSample;

// Front to back, as docs/numerics.md has it.
struct ControlRenderer::Compositor {
  const TransferFunction& transfer_function;
  std::array<double, 4> rgba{};

  bool is_opaque() const { return rgba[3] >= 1 - 1.0 / 1024; }

  void add(const FieldSample& sample, double path) {
    if (!sample.is_defined) return;
    const double opacity = 1 - std::pow(1 - transfer_function.opacity_at(sample.value), path);
    if (opacity <= 0) return;
    const Rgb color = transfer_function.color_at(sample.value);
    const double share = (1 - rgba[3]) * opacity;
    for (std::size_t c = 0; c < 3; ++c) rgba[c] += share * color[c];
    rgba[3] += share;
  }
};

ControlRenderer::ControlRenderer(const Dataset& dataset, const TransferFunction& transfer_function)
    : dataset_(dataset),
      values_(reinterpret_cast<const float*>(dataset.array().bytes.view.data())),
      dims_(dataset.lattice.dims),
      kernel_(default_choice().kernel),
      field_(kernel_points(dataset, default_choice())),
      transfer_function_(transfer_function) {}

Image ControlRenderer::draw(double degrees, int pixels, double half_height, Sheets sheets) const {
  const double angle = degrees * std::numbers::pi / 180;
  const Vec3 forward(-std::sin(angle), 0, -std::cos(angle));
  const Vec3 right(std::cos(angle), 0, -std::sin(angle));
  const Affine3 index_from_world = dataset_.lattice.world_from_index.inverse();
  const double spacing = dataset_.lattice.spacing()[0];
  Image image = blank(pixels, pixels);
  data::parallel_ranges({pixels, 1, 0, {}}, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t row = begin; row < end; ++row) {
      for (int column = 0; column < pixels; ++column) {
        const double x = (2 * (column + 0.5) / pixels - 1) * half_height;
        const double y = (1 - 2 * (static_cast<double>(row) + 0.5) / pixels) * half_height;
        const Ray ray{index_from_world * Vec3(x * right + y * Vec3::UnitY()),
                      index_from_world.linear() * forward * spacing};
        Compositor pixel{transfer_function_};
        if (sheets == Sheets::kImageAligned) {
          trace_image_aligned(ray, pixel);
        } else {
          trace_axis_aligned(ray, sheets, pixel);
        }
        for (std::size_t c = 0; c < 4; ++c) {
          image.rgba[4 * static_cast<std::size_t>(row * pixels + column) + c] =
              static_cast<float>(pixel.rgba[c]);
        }
      }
    }
  });
  return image;
}

void ControlRenderer::trace_image_aligned(const Ray& ray, Compositor& pixel) const {
  const auto half = static_cast<std::int64_t>(
      std::ceil(std::hypot(dims_[0], dims_[1], static_cast<double>(dims_[2])) / 2));
  for (std::int64_t k = -half; k < half && !pixel.is_opaque(); ++k) {
    pixel.add(field_(ray.origin + (static_cast<double>(k) + 0.5) * ray.step), 1.0);
  }
}

void ControlRenderer::trace_axis_aligned(const Ray& ray, Sheets sheets, Compositor& pixel) const {
  int axis = 0;
  ray.step.cwiseAbs().maxCoeff(&axis);
  const double slope = ray.step[axis];
  for (std::int64_t n = 0; n < dims_[axis] && !pixel.is_opaque(); ++n) {
    const std::int64_t slice = slope > 0 ? n : dims_[axis] - 1 - n;
    const double t = (static_cast<double>(slice) - ray.origin[axis]) / slope;
    Vec3 place = ray.origin + t * ray.step;
    place[axis] = static_cast<double>(slice);
    pixel.add(sheets == Sheets::kAxisPlanes ? field_(place) : slice_at(ray, place, axis),
              1 / std::abs(slope));
  }
}

// The slice's kernels, each integrated along the whole ray: a Gaussian of the distance from the ray
// to the sample, divided by their sum.
FieldSample ControlRenderer::slice_at(const Ray& ray, const Vec3& place, int axis) const {
  for (int a = 0; a < 3; ++a) {
    if (place[a] < -0.5 || place[a] > static_cast<double>(dims_[a]) - 0.5) return {};
  }
  // Seen under 45 degrees a kernel covers sqrt(2) times its width of the slice.
  const double reach = kernel_.support_radius() * std::numbers::sqrt2;
  Index3 first;
  Index3 last;
  for (int a = 0; a < 3; ++a) {
    const double along = a == axis ? 0 : reach;
    first[a] = std::max<std::int64_t>(static_cast<std::int64_t>(std::ceil(place[a] - along)), 0);
    last[a] = std::min(static_cast<std::int64_t>(std::floor(place[a] + along)), dims_[a] - 1);
  }
  double numerator = 0;
  double denominator = 0;
  for (std::int64_t k = first[2]; k <= last[2]; ++k) {
    for (std::int64_t j = first[1]; j <= last[1]; ++j) {
      for (std::int64_t i = first[0]; i <= last[0]; ++i) {
        const Vec3 offset =
            Vec3(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)) - place;
        const double distance2 = offset.cross(ray.step).squaredNorm();
        const double weight = std::exp(-0.5 * distance2 / (kernel_.sigma * kernel_.sigma));
        numerator += weight * static_cast<double>(values_[i + dims_[0] * (j + dims_[1] * k)]);
        denominator += weight;
      }
    }
  }
  FieldSample sample;
  if (denominator > 0) {
    sample.value = numerator / denominator;
    sample.is_defined = true;
  }
  return sample;
}

}  // namespace ovoid::experiments
