// SPDX-License-Identifier: Apache-2.0
#include "scenes.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>

namespace ovoid::cli {

std::string BenchScene::volume_name() const { return fmt::format("{}-{}", volume, samples); }

std::string BenchScene::name() const {
  const char* const kind = look == SceneLook::kSoft ? "soft" : "opaque";
  const std::string size =
      width == height ? fmt::format("{}px", width) : fmt::format("{}x{}", width, height);
  const std::string nearer = magnification == 1 ? "" : fmt::format("-x{:g}", magnification);
  return fmt::format("{}-{}-{}{}", volume_name(), size, kind, nearer);
}

std::optional<BenchScene> scene_named(const std::string& name) {
  static const std::regex form(
      R"(([a-z-]+)-(\d{1,9})-(\d{1,5})x(\d{1,5})-(soft|opaque)(-x(\d+(\.\d+)?))?)");
  std::smatch part;
  if (!std::regex_match(name, part, form)) return std::nullopt;
  const std::vector<BenchScene> standard = standard_scenes();
  const auto known = std::find_if(standard.begin(), standard.end(), [&](const BenchScene& scene) {
    return scene.volume == part[1].str();
  });
  if (known == standard.end()) return std::nullopt;
  BenchScene scene = *known;
  scene.samples = std::stoi(part[2]);
  scene.width = std::stoi(part[3]);
  scene.height = std::stoi(part[4]);
  scene.look = part[5] == "soft" ? SceneLook::kSoft : SceneLook::kOpaque;
  scene.magnification = part[7].matched ? std::stod(part[7]) : 1;
  const bool is_possible =
      scene.samples > 0 && scene.width > 0 && scene.height > 0 && scene.magnification > 0;
  return is_possible ? std::optional(scene) : std::nullopt;
}

std::vector<BenchScene> standard_scenes() {
  struct Data {
    const char* name;
    int samples;
    bool is_lattice;
  };
  std::vector<BenchScene> scenes;
  for (const Data& data : {Data{"marschner-lobb", 128, true}, Data{"marschner-lobb", 256, true},
                           Data{"head", 256, true}, Data{"fin", 100'000, false},
                           Data{"galaxy", 200'000, false}, Data{"blobs", 2'000, false}}) {
    for (const int pixels : {256, 512}) {
      for (const SceneLook look : {SceneLook::kSoft, SceneLook::kOpaque}) {
        scenes.push_back({data.name, data.samples, data.is_lattice, pixels, pixels, look});
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
