// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "ovoid/scene.h"
#include "render/cpu/frame.h"
#include "render/shared/lattice_values.h"

namespace ovoid::cpu {

// A frame of a lattice field.
struct LatticeFrame : CpuFrame, LatticeTraits {
  const view::LatticePlan* lattice_plan = nullptr;  // `plan`, as what it is
  const LatticeField* field = nullptr;
  device::LatticeConstants lattice{};
  bool samples_at_nodes = false;  // of some sheets: tiles come in patches (nodes.h)
  bool is_on_lattice = false;     // sheets are parallel to the lattice's planes
  bool has_rows = false;          // of samples that share weights, on lattice sheets (rows-inl.h)
  bool has_only_rows = false;     // blocks that have rows read the lattice in no other way
  // Drawn with this frame sheet by sheet: further volumes, which are mixed with it, or a trail.
  std::vector<const LatticeFrame*> beside;
  bool is_mixed = false;  // with what is beside it; else that is behind it
  Mixing mixing = Mixing::kAveraged;
};

}  // namespace ovoid::cpu
