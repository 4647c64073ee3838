// SPDX-License-Identifier: Apache-2.0
// `ovoid make solid`: the kernels of a subdivision solid, or the mesh of a level.
#pragma once

#include <string>

#include "flags.h"
#include "ovoid/dataset.h"
#include "ovoid/solid.h"
#include "session.h"

namespace ovoid::cli {

struct SolidFlags {
  std::string control;  // a file; empty: the built-in mesh
  std::string array;
  int levels = 1;
  SolidBasis basis = SolidBasis::kInterpolating;
  std::size_t memory_limit = std::size_t{4} << 30;
};

const Table<SolidFlags>& solid_settings();

// What is to be written to `output`, which says whether kernels or a mesh. Throws Error.
Dataset make_solid(const SolidFlags& solid, const std::string& output, Session& session);

inline constexpr const char* kSolidName = "solid";
inline constexpr const char* kSolidText =
    "a subdivision solid: the kernels (.ply) or the mesh (.vtu) of a level of a control mesh, by "
    "default that of a star, 258 vertices";

}  // namespace ovoid::cli
