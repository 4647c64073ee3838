// SPDX-License-Identifier: Apache-2.0
#include "render/light/light_volume.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/light/light_sweep.h"
#include "render/light/solid_lattice.h"

namespace ovoid {
namespace {

// Fields and looks whose light is kept: viewers go to and fro between a field and its coarse ones.
constexpr std::size_t kMostLights = 4;

void append_curve(std::vector<double>& key, const std::vector<OpacityPoint>& points) {
  key.push_back(static_cast<double>(points.size()));
  for (const OpacityPoint& point : points)
    key.insert(key.end(), {point.x, point.opacity, point.midpoint, point.sharpness});
}

void append_look(std::vector<double>& key, const Look& look) {
  const TransferFunction& tf = look.transfer_function;
  key.insert(key.end(),
             {static_cast<double>(look.mode), look.isovalue, look.unit_distance,
              tf.unit_distance.value_or(0), static_cast<double>(tf.scale), tf.linear_width});
  if (look.mode != Mode::kIsosurface) append_curve(key, tf.opacities);
}

// All that an extinction lattice depends on. Colours are not among it.
std::vector<double> key_of(const LitScene& scene) {
  const bool is_solid = scene.solid != nullptr;
  std::vector<double> key{static_cast<double>(scene.field.id()),
                          static_cast<double>(scene.field.version()), is_solid ? 1.0 : 0.0};
  if (!is_solid) append_look(key, scene.look);
  key.push_back(static_cast<double>(scene.mixing));
  for (const FurtherVolume& volume : scene.further) {
    key.insert(key.end(), {static_cast<double>(volume.field.id()),
                           static_cast<double>(volume.field.version())});
    append_look(key, volume.look);
  }
  for (const ClipPlane& plane : scene.clip_planes)
    key.insert(key.end(), {plane.normal[0], plane.normal[1], plane.normal[2], plane.offset});
  for (const Geometry& one : scene.geometry) key.push_back(one.opacity);
  return key;
}

// A surface has no number of its own. One that is gone is none of those that are there, and of one
// that nobody owns nothing is known.
bool is_same(const std::weak_ptr<const Surface>& kept, const Geometry& geometry) {
  const std::shared_ptr<const Surface> surface = kept.lock();
  return surface != nullptr && surface == geometry.surface;
}

double diagonal_of(const ExtinctionLattice& lattice) {
  const Vec3 cells(static_cast<double>(lattice.dims[0] - 2),
                   static_cast<double>(lattice.dims[1] - 2),
                   static_cast<double>(lattice.dims[2] - 2));
  const Mat3 axes = lattice.world_from_cell.linear();
  double longest = 0;  // of four diagonals
  for (const double y : {-1.0, 1.0}) {
    for (const double z : {-1.0, 1.0})
      longest = std::max(longest, (axes * cells.cwiseProduct(Vec3(1, y, z))).norm());
  }
  return longest;
}

// Half of the sky is what an open surface sees: that counts as all of the light.
std::vector<float> light_from_everywhere(const ExtinctionLattice& lattice, double diagonal,
                                         int threads, const std::stop_token& stop) {
  const double reach = kReachOfDiagonal * diagonal;
  std::vector<float> light = mean_arriving_light(lattice, directions_of_sphere(kSphereDirections),
                                                 {1, 1 / reach}, threads, stop);
  for (float& share : light) share = std::min(1.0F, 2 * share);
  return light;
}

ExtinctionLattice extinction_of_scene(const LitScene& scene, int threads,
                                      const std::stop_token& stop, KernelTeam* team) {
  if (scene.solid != nullptr) return solid_lattice(*scene.solid, scene.clip_planes, threads, stop);
  ExtinctionLattice all =
      extinction_lattice(scene.field, scene.look, scene.clip_planes, threads, stop, team);
  if (scene.mixing == Mixing::kColored) return all;
  for (const FurtherVolume& volume : scene.further) {
    mix_extinction(
        extinction_lattice(volume.field, volume.look, scene.clip_planes, threads, stop, team),
        scene.mixing, all);
  }
  return all;
}

// Towards the sides beyond which surfaces are not known, light becomes all of it, over some cells:
// else shadows that reach such a side would go on beyond it.
void fade_at_cuts(const GrownSides& sides, view::LightVolume& volume) {
  constexpr std::int64_t kFade = 8, kPartOfRoom = 4;
  std::array<std::vector<double>, 3> shares;  // of what is missing, that stays
  bool is_cut = false;
  for (std::size_t a = 0; a < 3; ++a) {
    shares[a].assign(static_cast<std::size_t>(volume.dims[a]), 1);
    const auto fade = [&](bool is_side_cut, std::int64_t room, const auto& cell_at) {
      if (!is_side_cut) return;
      is_cut = true;
      const std::int64_t cells = std::min(kFade, room / kPartOfRoom + 1);
      for (std::int64_t i = 0; i < cells; ++i)
        shares[a][cell_at(i)] *= static_cast<double>(i) / static_cast<double>(cells);
    };
    fade(sides.is_cut_before[a], sides.before[a],
         [](std::int64_t i) { return static_cast<std::size_t>(i); });
    fade(sides.is_cut_behind[a], sides.behind[a],
         [&](std::int64_t i) { return static_cast<std::size_t>(volume.dims[a] - 1 - i); });
  }
  if (!is_cut) return;
  float* packed = volume.packed.data();
  for (const double z : shares[2]) {
    for (const double y : shares[1]) {
      for (const double x : shares[0]) {
        const double share = x * y * z;
        if (share < 1) {
          const view::ArrivingLight light = view::unpacked_light(*packed);
          *packed =
              view::packed_light({1 - share * (1 - light.around), 1 - share * (1 - light.key)});
        }
        ++packed;
      }
    }
  }
}

bool has_key_light(const Look& look) { return look.shadows > 0 && look.light_direction; }

}  // namespace

bool has_light_volume(const Look& look) {
  const bool takes_light = look.mode == Mode::kComposite || look.mode == Mode::kIsosurface;
  return takes_light && (look.occlusion > 0 || has_key_light(look));
}

LightVolumes::Kept& LightVolumes::kept_for(const LitScene& scene, int threads,
                                           const std::stop_token& stop, KernelTeam* team) {
  Key key = key_of(scene);
  const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) {
    return kept.key == key && std::equal(kept.surfaces.begin(), kept.surfaces.end(),
                                         scene.geometry.begin(), scene.geometry.end(), is_same);
  });
  if (found != kept_.end()) {
    std::rotate(kept_.begin(), found, found + 1);
    return kept_.front();
  }
  Kept fresh;
  fresh.extinction = extinction_of_scene(scene, threads, stop, team);
  fresh.diagonal = diagonal_of(fresh.extinction);
  if (!scene.geometry.empty())
    fresh.sides = add_surfaces(scene.geometry, threads, stop, fresh.extinction);
  for (const Geometry& one : scene.geometry) fresh.surfaces.emplace_back(one.surface);
  fresh.key = std::move(key);
  fresh.volume.dims = fresh.extinction.dims;
  fresh.volume.cell_from_world = fresh.extinction.world_from_cell.inverse();
  fresh.volume.cell_edge = fresh.extinction.cell_edge();
  if (kept_.size() == kMostLights) kept_.pop_back();
  kept_.insert(kept_.begin(), std::move(fresh));
  return kept_.front();
}

const view::LightVolume* LightVolumes::at(const LitScene& scene, int threads,
                                          const std::stop_token& stop, KernelTeam* team) {
  const Look& look = scene.look;
  if (!has_light_volume(look)) return nullptr;
  Kept& kept = kept_for(scene, threads, stop, team);
  if (look.occlusion > 0 && kept.around.empty())
    kept.around = light_from_everywhere(kept.extinction, kept.diagonal, threads, stop);
  const bool has_key = has_key_light(look);
  const bool has_scatter = has_key && look.scatter > 0;
  if (has_key) {
    const Vec3 towards = look.light_direction->normalized();
    Key key_light{towards[0], towards[1], towards[2], has_scatter ? 1.0 : 0.0};
    if (kept.key_light != key_light) {
      kept.key_light.clear();
      kept.key_share = mean_arriving_light(kept.extinction, {towards}, {}, threads, stop);
      if (has_scatter) {
        kept.scattered = mean_arriving_light(
            kept.extinction, directions_of_cone(towards, kScatterAngle, kConeDirections),
            {kScatterExtinction, 0}, threads, stop);
      }
      kept.key_light = std::move(key_light);
      kept.strengths.clear();
    }
  }
  Key strengths{look.occlusion, has_key ? look.shadows : 0, has_scatter ? look.scatter : 0};
  if (kept.strengths == strengths) return &kept.volume;
  std::vector<float>& packed = kept.volume.packed;
  packed.resize(kept.extinction.extinction.size());
  for (std::size_t i = 0; i < packed.size(); ++i) {
    view::ArrivingLight light;
    if (look.occlusion > 0) light.around = 1 - look.occlusion * (1 - kept.around[i]);
    if (has_key) {
      const double lost =
          (1 - kept.key_share[i]) * (1 - (has_scatter ? look.scatter * kept.scattered[i] : 0.0));
      light.key = 1 - look.shadows * lost;
    }
    packed[i] = view::packed_light(light);
  }
  fade_at_cuts(kept.sides, kept.volume);
  kept.volume.has_key = has_key;
  kept.strengths = std::move(strengths);
  return &kept.volume;
}

}  // namespace ovoid
