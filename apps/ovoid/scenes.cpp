// SPDX-License-Identifier: Apache-2.0
#include "scenes.h"

#include <fmt/format.h>

namespace ovoid::cli {

std::string Scene::volume_name() const { return fmt::format("{}-{}", volume, samples); }

std::string Scene::name() const {
  const char* const kind = look == SceneLook::kSoft ? "soft" : "opaque";
  return fmt::format("{}-{}px-{}", volume_name(), pixels, kind);
}

std::vector<Scene> standard_scenes() {
  struct Data {
    const char* name;
    int samples;
    bool is_lattice;
  };
  std::vector<Scene> scenes;
  for (const Data& data : {Data{"marschner-lobb", 128, true}, Data{"marschner-lobb", 256, true},
                           Data{"head", 256, true}, Data{"fin", 100'000, false},
                           Data{"galaxy", 200'000, false}, Data{"blobs", 2'000, false}}) {
    for (const int pixels : {256, 512}) {
      for (const SceneLook look : {SceneLook::kSoft, SceneLook::kOpaque}) {
        scenes.push_back({data.name, data.samples, data.is_lattice, pixels, look});
      }
    }
  }
  return scenes;
}

Look make_scene_look(SceneLook kind, const ValueRange& range) {
  Look look = ramp_look(range);
  const double lo = range.lo;
  const double width = static_cast<double>(range.hi) - lo;
  const auto at = [&](double fraction, double opacity) {
    return OpacityPoint{.x = lo + fraction * width, .opacity = opacity};
  };
  std::vector<OpacityPoint>& opacities = look.transfer_function.opacities;
  if (kind == SceneLook::kSoft) {
    opacities = {at(0, 0), at(0.15, 0), at(1, 0.05)};
  } else {
    opacities = {at(0, 0), at(0.35, 0), at(0.45, 0.9), at(1, 0.9)};
  }
  return look;
}

}  // namespace ovoid::cli
