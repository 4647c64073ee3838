// SPDX-License-Identifier: Apache-2.0
// What a look makes of a field, seen from afar: how strongly each cell of a coarse lattice absorbs
// light. docs/numerics.md, "Light from a coarse volume", is the definition.
#pragma once

#include <array>
#include <cstdint>
#include <stop_token>
#include <vector>

#include "ovoid/field.h"
#include "ovoid/kernel_team.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "ovoid/scene.h"

namespace ovoid {

// A cell that surfaces beside the field pass through. How often a ray crosses them goes with its
// direction, so that what they absorb is a form: a ray that goes by `v` cells within this one has
// the optical depth sqrt(v' form v).
struct CrossedCell {
  std::array<std::int32_t, 3> cell{};
  std::array<float, 6> form{};  // symmetric: xx, yy, zz, yz, zx, xy
};

struct ExtinctionLattice {
  Index3 dims{};  // an empty cell lies around the field on all sides
  Affine3 world_from_cell = Affine3::Identity();  // cell (i, j, k) has its middle at (i, j, k)
  std::vector<float> extinction;                  // per world length, [dims[2]][dims[1]][dims[0]]
  std::vector<CrossedCell> crossed;               // each cell once; empty: no surfaces

  double cell_edge() const;  // world: the mean of a cell's three
};

// An opacity of 1 counts as this much extinction per unit distance: of its light 1.8 % go through.
// A greater number would let single samples fill their cell.
inline constexpr double kOpaqueExtinction = 4;

// Cells along the longest side: a quarter of the samples, in these bounds, and never more than
// there are samples.
inline constexpr int kLeastLightCells = 64;
inline constexpr int kMostLightCells = 128;

// Extinction per world length of a value, of a look whose unit distance is set.
double extinction_of(const Look& look, double value);

// `unit_distance` of the look is set. Clip planes take away what they cut. A pass over the samples
// that can show, or over all kernels; by a team, each process makes some slabs of it, and all call
// it. Throws Error(kCancelled), and what the field's source and the team throw.
ExtinctionLattice extinction_lattice(const Field& field, const Look& look,
                                     const std::vector<ClipPlane>& clip_planes, int threads,
                                     const std::stop_token& stop, KernelTeam* team = nullptr);

// Mixes in what another lattice absorbs, read between its cells' middles, at the middles of all
// cells of `sum`, which gets as many more around it as the other reaches beyond it: added, or where
// colours are added the greater.
void mix_extinction(const ExtinctionLattice& other, Mixing mixing, ExtinctionLattice& sum);

// The most cells along an axis that a lattice has then.
inline constexpr std::int64_t kMostCellsOfAll = 256;

// With so many more empty cells before and behind, along each axis. No surfaces are in it.
ExtinctionLattice grown(const ExtinctionLattice& lattice, const Index3& before,
                        const Index3& behind);

}  // namespace ovoid
