// SPDX-License-Identifier: Apache-2.0
// A picture of every time step, all with the look of the first: time_steps scan4d.nii.gz frame
#include <ovoid/ovoid.h>

#include <cstdio>
#include <optional>
#include <string>
#include <vector>

int main(int argc, char** argv) try {
  if (argc < 3) return std::fprintf(stderr, "usage: %s VOLUME... PREFIX\n", argv[0]), 2;
  const std::vector<std::string> inputs(argv + 1, argv + argc - 1);
  ovoid::Renderer renderer;
  std::optional<ovoid::Look> look;
  std::int64_t num_steps = 1;
  for (std::int64_t step = 0; step < num_steps; ++step) {
    ovoid::ReadOptions options;
    options.step = step;  // only this step's samples are read
    const ovoid::Dataset dataset = ovoid::read_dataset(inputs, options);
    num_steps = dataset.num_steps;
    const auto field = ovoid::make_lattice_field(dataset);
    const auto camera = ovoid::default_camera(field.world_bounds(), dataset.space);
    if (!look) look = ovoid::default_look(field, dataset.array().unit);

    const std::string path = argv[argc - 1] + std::to_string(step) + ".png";
    ovoid::write_image(renderer.render({field, *look}, camera).image, path);
    if (dataset.times.empty()) {
      std::printf("step %lld: %s\n", static_cast<long long>(step), path.c_str());
    } else {
      std::printf("time %g: %s\n", dataset.times[static_cast<std::size_t>(step)], path.c_str());
    }
  }
} catch (const ovoid::Error& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
