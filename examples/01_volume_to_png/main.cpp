// SPDX-License-Identifier: Apache-2.0
// The least program: volume_to_png head.nrrd head.png
#include <ovoid/ovoid.h>

#include <cstdio>

int main(int argc, char** argv) try {
  if (argc != 3) return std::fprintf(stderr, "usage: %s VOLUME PICTURE\n", argv[0]), 2;
  const auto field = ovoid::make_field(ovoid::read_dataset({argv[1]}));
  const auto camera = ovoid::default_camera(field.world_bounds());
  const auto look = ovoid::default_look(field);
  const auto frame = ovoid::Renderer{}.render({field, look}, camera);
  ovoid::write_image(frame.image, argv[2]);
} catch (const ovoid::Error& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
