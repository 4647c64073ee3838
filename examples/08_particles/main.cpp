// SPDX-License-Identifier: Apache-2.0
// Particles that a program has in memory: particles spiral.png
//
// Two arms of a spiral; where the particles lie closer, they are smaller. Density gives opacity,
// temperature gives colour.
#include <ovoid/ovoid.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace {

ovoid::DataArray array_of(std::string name, int num_components, std::vector<float> values) {
  const auto owner = std::make_shared<const std::vector<float>>(std::move(values));
  ovoid::DataArray array;
  array.name = std::move(name);
  array.num_components = num_components;
  array.num_tuples = static_cast<std::int64_t>(owner->size()) / num_components;
  array.bytes = {owner, std::as_bytes(std::span(*owner))};
  return array;
}

ovoid::Dataset spiral() {
  std::mt19937 random(20061);
  std::normal_distribution<float> normal(0, 0.06F);
  std::vector<float> positions, temperatures;
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    const float along = static_cast<float>(i) / kCount;
    const float angle = 7 * along + (i % 2 == 0 ? 0.0F : 3.14159F);
    const float radius = 0.1F + along;
    const float spread = 0.3F + along;
    positions.insert(positions.end(),
                     {radius * std::cos(angle) + spread * normal(random),
                      radius * std::sin(angle) + spread * normal(random), 0.5F * normal(random)});
    temperatures.push_back(1e4F * std::exp(-2 * along));
  }
  ovoid::Dataset gas;
  gas.source = "spiral";
  gas.kind = ovoid::DatasetKind::kParticles;
  gas.positions = array_of("positions", 3, std::move(positions));
  gas.arrays = {array_of("temperature", 1, std::move(temperatures))};
  return gas;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 2) return std::fprintf(stderr, "usage: %s PICTURE\n", argv[0]), 2;
  ovoid::FieldModelOptions model;
  model.kernels.is_density = true;  // mass per volume; every particle has the mass 1
  model.kernels.color_array = "temperature";
  const auto field = ovoid::make_field(spiral(), model);
  const auto camera = ovoid::default_camera(field.world_bounds());
  const auto frame = ovoid::Renderer{}.render({field, ovoid::default_look(field)}, camera);
  ovoid::write_image(frame.image, argv[1], ovoid::Rgb{0, 0, 0});
} catch (const ovoid::Error& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
