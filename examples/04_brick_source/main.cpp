// SPDX-License-Identifier: Apache-2.0
// Samples that are nowhere in memory until a brick of them is asked for: brick_source gyroid.png
//
// The same interface serves files too large for memory, data behind a network, or a simulation's
// own arrays. This one computes 256^3 samples of a gyroid, brick by brick, and tells ranges without
// computing any, so that bricks where nothing shows are never made. (One whose bricks cost more to
// get keeps those it got last: the interface asks for the same brick again and again.)
#include <ovoid/ovoid.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

namespace {

class Gyroid final : public ovoid::BrickSource {
 public:
  Gyroid() {
    geometry_.dims = {kSide, kSide, kSide};
    geometry_.world_from_index.linear() *= 1.0 / kSide;  // a unit cube
    for (std::size_t i = 0; i < kSide; ++i) {
      sine_[i] = std::sin(kScale * static_cast<double>(i));
      cosine_[i] = std::cos(kScale * static_cast<double>(i));
    }
  }

  const ovoid::LatticeGeometry& geometry() const noexcept override { return geometry_; }
  int brick_edge() const noexcept override { return kEdge; }
  double range_reach() const noexcept override { return kReach; }
  bool has_missing(std::int64_t, std::int64_t, std::int64_t) const noexcept override {
    return false;
  }
  std::size_t resident_bytes() const noexcept override { return sizeof *this; }

  // Of all samples that reach the brick: its middle's value, and as much as the function can change
  // on the way to the farthest of them (its gradient is at most kScale * sqrt(3) per sample).
  ovoid::ValueRange brick_range(std::int64_t bx, std::int64_t by,
                                std::int64_t bz) const noexcept override {
    const auto middle = [](std::int64_t b) {
      return static_cast<std::size_t>(b * kEdge + kEdge / 2);
    };
    const double value = value_at(middle(bx), middle(by), middle(bz));
    const double farthest = std::sqrt(3.0) * (kEdge / 2.0 + kReach);
    const auto change = static_cast<float>(std::sqrt(3.0) * kScale * farthest);
    return {static_cast<float>(value) - change, static_cast<float>(value) + change};
  }

  ovoid::BrickView acquire(std::int64_t bx, std::int64_t by, std::int64_t bz,
                           double /*time*/) const override {
    const auto samples = std::make_shared<std::vector<float>>(kEdge * kEdge * kEdge);
    std::size_t at = 0;
    for (std::int64_t k = bz * kEdge; k < (bz + 1) * kEdge; ++k) {
      for (std::int64_t j = by * kEdge; j < (by + 1) * kEdge; ++j) {
        for (std::int64_t i = bx * kEdge; i < (bx + 1) * kEdge; ++i) {
          (*samples)[at++] =
              static_cast<float>(value_at(static_cast<std::size_t>(i), static_cast<std::size_t>(j),
                                          static_cast<std::size_t>(k)));
        }
      }
    }
    ovoid::BrickView view;
    view.data = samples->data();
    view.type = ovoid::ScalarType::kFloat32;
    view.lo = {bx * kEdge, by * kEdge, bz * kEdge};
    view.hi = {view.lo[0] + kEdge, view.lo[1] + kEdge, view.lo[2] + kEdge};
    view.stride_y = kEdge;
    view.stride_z = kEdge * kEdge;
    view.pin = samples;  // the view keeps its samples alive
    return view;
  }

 private:
  static constexpr std::int64_t kSide = 256;
  static constexpr int kEdge = 8;
  static constexpr double kReach = 2.0;  // the default kernel's support radius, in samples
  static constexpr double kScale = 2.0 * 2.0 * 3.14159265358979 / kSide;

  double value_at(std::size_t i, std::size_t j, std::size_t k) const {
    return sine_[i] * cosine_[j] + sine_[j] * cosine_[k] + sine_[k] * cosine_[i];
  }

  std::array<double, kSide> sine_{};
  std::array<double, kSide> cosine_{};
  ovoid::LatticeGeometry geometry_;
};

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return std::fprintf(stderr, "usage: %s PICTURE\n", argv[0]), 2;
  const ovoid::LatticeField field(std::make_shared<Gyroid>(), {},
                                  ovoid::Reconstruction::kNormalized);
  auto camera = ovoid::default_camera(field.world_bounds());
  camera.azimuth(30);
  camera.elevation(25);
  ovoid::Look look;
  look.transfer_function = ovoid::color_map("viridis");
  look.transfer_function.map_range(-1.5, 1.5);
  look.transfer_function.opacities = {{0.9, 0.0}, {1.1, 0.9}};
  const auto frame = ovoid::Renderer{}.render({field, look}, camera);
  ovoid::write_image(frame.image, argv[1]);
  std::printf("%lld of %lld kernels were in bricks that could show\n",
              static_cast<long long>(frame.profile.kernels_drawn),
              static_cast<long long>(frame.profile.kernels_total));
} catch (const ovoid::Error& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
