// SPDX-License-Identifier: Apache-2.0
// One volume, four looks: looks head.nrrd pictures/head
#include <ovoid/ovoid.h>

#include <cstdio>
#include <string>
#include <utility>
#include <vector>

namespace {

// Colours and opacities by value, point by point; between points they go straight.
ovoid::Look own_look(const ovoid::ValueRange& range) {
  const double lo = range.lo;
  const double hi = range.hi;
  const double middle = 0.5 * (lo + hi);
  ovoid::Look look;
  look.transfer_function.colors = {
      {lo, {0.1, 0.2, 0.5}}, {middle, {0.9, 0.9, 0.8}}, {hi, {0.9, 0.4, 0.1}}};
  look.transfer_function.opacities = {{middle, 0.0}, {hi, 0.6}};
  look.material.specular = 0.5;
  look.light_direction = ovoid::Vec3(1, 1, 1);
  return look;
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) return std::fprintf(stderr, "usage: %s VOLUME PREFIX\n", argv[0]), 2;
  const std::string prefix = argv[2];
  const auto field = ovoid::make_field(ovoid::read_dataset({argv[1]}));
  const auto camera = ovoid::default_camera(field.world_bounds());
  const ovoid::ValueRange range = field.value_range();

  // A file in ParaView's format keeps a transfer function; reading gives back the same numbers.
  const ovoid::Look own = own_look(range);
  ovoid::write_transfer_function(own.transfer_function, prefix + "-own.json");
  ovoid::Look stored = own;
  stored.transfer_function = ovoid::read_transfer_function(prefix + "-own.json");

  ovoid::Look brightest = ovoid::ramp_look(range, "inferno");
  brightest.mode = ovoid::Mode::kMaximum;

  const std::vector<std::pair<std::string, ovoid::Look>> looks = {
      {"default", ovoid::default_look(field)},
      {"ramp", ovoid::ramp_look(range, "plasma")},
      {"own", stored},
      {"brightest", brightest}};
  ovoid::Renderer renderer;  // keeps its threads from picture to picture
  for (const auto& [name, look] : looks) {
    ovoid::write_image(renderer.render({field, look}, camera).image, prefix + "-" + name + ".png");
  }
} catch (const ovoid::Error& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
