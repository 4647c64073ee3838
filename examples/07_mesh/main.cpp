// SPDX-License-Identifier: Apache-2.0
// A mesh that a program has in memory: mesh bent.png
//
// A bar of hexahedra, bent to a quarter of a ring, and the temperature at its nodes. Meshes of
// other cells name them one by one in `types`, `offsets` and `connectivity`.
#include <ovoid/ovoid.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace {

// The dataset shares the values: nothing is copied, and they live as long as anything needs them.
ovoid::DataArray array_of(std::string name, int num_components, std::vector<double> values) {
  const auto owner = std::make_shared<const std::vector<double>>(std::move(values));
  ovoid::DataArray array;
  array.name = std::move(name);
  array.type = ovoid::ScalarType::kFloat64;
  array.num_components = num_components;
  array.num_tuples = static_cast<std::int64_t>(owner->size()) / num_components;
  array.bytes = {owner, std::as_bytes(std::span(*owner))};
  return array;
}

ovoid::Dataset bent_bar() {
  const ovoid::Index3 nodes{61, 13, 13};  // along the bar, outwards, up
  std::vector<double> positions, temperatures;
  for (int k = 0; k < nodes[2]; ++k) {
    for (int j = 0; j < nodes[1]; ++j) {
      for (int i = 0; i < nodes[0]; ++i) {
        const double angle = 0.5 * std::numbers::pi * i / 60;
        const double radius = 3 + j / 12.0;
        positions.insert(positions.end(),
                         {radius * std::cos(angle), radius * std::sin(angle), k / 12.0});
        temperatures.push_back(500 - 3.0 * i + 2.0 * j);
      }
    }
  }
  ovoid::Dataset bar;
  bar.source = "bent bar";
  bar.kind = ovoid::DatasetKind::kMesh;
  bar.positions = array_of("positions", 3, std::move(positions));
  bar.cells.dims = nodes;
  bar.arrays = {array_of("temperature", 1, std::move(temperatures))};
  return bar;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return std::fprintf(stderr, "usage: %s PICTURE\n", argv[0]), 2;
  const auto field = ovoid::make_field(bent_bar());
  const auto camera = ovoid::default_camera(field.world_bounds());
  auto look = ovoid::ramp_look(field.value_range(), "viridis");
  look.transfer_function.opacities = {{0, 0.9}};  // the same everywhere
  look.shade = false;
  const auto frame = ovoid::Renderer{}.render({field, look}, camera);
  ovoid::write_image(frame.image, argv[1], ovoid::Rgb{1, 1, 1});
} catch (const ovoid::Error& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
