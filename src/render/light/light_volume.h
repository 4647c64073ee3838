// SPDX-License-Identifier: Apache-2.0
// The light that a frame's samples are reached by: made from a field and a look, and kept as long
// as neither changes. docs/numerics.md, "Light from a coarse volume", is the definition.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <stop_token>
#include <vector>

#include "ovoid/field.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "ovoid/scene.h"
#include "ovoid/surface.h"
#include "render/light/extinction_lattice.h"
#include "render/light/surface_extinction.h"
#include "view/plan/further_volume.h"
#include "view/plan/light_volume.h"

namespace ovoid {

// How far light from everywhere must go to be whole again, in diagonals of the field's box.
inline constexpr double kReachOfDiagonal = 0.125;
// Directions from which light comes from everywhere: with 64 a picture is as near to what endless
// directions give as the coarse cells let it be (bench/light.py).
inline constexpr int kSphereDirections = 64;
// What scattering brings back comes from a cone around the key, through a part of the extinction.
inline constexpr double kScatterAngle = 0.6;  // radians, from the cone's axis
inline constexpr int kConeDirections = 8;
inline constexpr double kScatterExtinction = 0.25;

// True if light that arrives is a matter of the look: a share of it is taken.
bool has_light_volume(const Look& look);

// What the light of a frame is made from. Unit distances are set, of looks or of their transfer
// functions, and the look's light has a direction unless it is a headlight.
struct LitScene {
  const Field& field;
  const Look& look;
  const std::vector<ClipPlane>& clip_planes;
  std::span<const FurtherVolume> further{};
  Mixing mixing = Mixing::kAveraged;  // of the extinctions of these with the field's
  // The surface of the field's mesh, which lets no light through, whatever the look makes of the
  // field; null: the field.
  const Surface* solid = nullptr;
  std::span<const Geometry> geometry{};  // valid; what stands beside the field
};

class LightVolumes {
 public:
  // The light of a frame. Null where the look has none. Valid until the next call. By a team all
  // call it. Throws Error(kCancelled), and what the fields' sources and the team throw.
  const view::LightVolume* at(const LitScene& scene, int threads, const std::stop_token& stop,
                              KernelTeam* team = nullptr);

 private:
  // What an extinction is made of, as numbers that are compared.
  using Key = std::vector<double>;
  struct Kept {
    Key key;
    std::vector<std::weak_ptr<const Surface>> surfaces;  // of the geometry
    ExtinctionLattice extinction;
    GrownSides sides;           // of it, to hold the surfaces
    double diagonal = 0;        // world: of the fields' box, without surfaces
    std::vector<float> around;  // shares of light from everywhere; empty: not asked for yet
    Key key_light;              // what the two below are made of
    std::vector<float> key_share, scattered;
    Key strengths;  // what the volume is made of
    view::LightVolume volume;
  };
  Kept& kept_for(const LitScene& scene, int threads, const std::stop_token& stop, KernelTeam* team);

  std::vector<Kept> kept_;  // the last used first
};

}  // namespace ovoid
