// SPDX-License-Identifier: Apache-2.0
// Where a frame's time goes, and what finer sheets cost: profile head.nrrd
#include <ovoid/ovoid.h>

#include <cstdio>

int main(int argc, char** argv) try {
  if (argc != 2) return std::fprintf(stderr, "usage: %s VOLUME\n", argv[0]), 2;
  const auto field = ovoid::make_field(ovoid::read_dataset({argv[1]}));
  const auto camera = ovoid::default_camera(field.world_bounds());
  const auto look = ovoid::default_look(field);
  ovoid::Renderer renderer;
  ovoid::RenderOptions options;
  renderer.render({field, look}, camera, options);  // warms up

  options.collect_profile = true;  // timers in every stage cost a few per cent
  const ovoid::FrameProfile p = renderer.render({field, look}, camera, options).profile;
  std::printf("%s (%s), %d threads: %.1f ms\n", p.backend.c_str(), p.simd_target.c_str(), p.threads,
              p.frame_ms);
  for (const auto& [stage, ms] : p.stages_ms) std::printf("  %-12s %8.1f ms\n", stage.c_str(), ms);
  std::printf("samples: %lld reconstructed, %lld visible; blocks: %lld drawn of %lld\n\n",
              static_cast<long long>(p.samples_reconstructed),
              static_cast<long long>(p.samples_shaded), static_cast<long long>(p.blocks_drawn),
              static_cast<long long>(p.blocks_total));

  options.collect_profile = false;
  for (const double sheets : {0.5, 1.0, 2.0, 4.0}) {
    options.sampling_distance = field.default_sampling_distance() / sheets;
    const double ms = renderer.render({field, look}, camera, options).profile.frame_ms;
    std::printf("%4.1f sheets per spacing: %8.1f ms\n", sheets, ms);
  }
} catch (const ovoid::Error& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
