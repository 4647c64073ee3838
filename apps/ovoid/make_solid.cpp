// SPDX-License-Identifier: Apache-2.0
#include "make_solid.h"

#include <fmt/format.h>

#include "load.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {

namespace {

SolidMesh read_control_mesh(const SolidFlags& solid, Session& session) {
  if (solid.control.empty()) return make_sample_control_mesh();
  DataFlags data;
  data.inputs = {solid.control};
  return make_control_mesh(load(data, session), {.array = solid.array});
}

}  // namespace

const Table<SolidFlags>& solid_settings() {
  using S = SolidFlags;
  static const Names<SolidBasis> bases = {{"interpolating", SolidBasis::kInterpolating},
                                          {"one", SolidBasis::kOneGaussian},
                                          {"two", SolidBasis::kTwoGaussians}};
  static const Table<S> all = {
      {"--control", word("MESH"), &S::control,
       "the control mesh: hexahedra with a density per node (default: the built-in one)"},
      {"--array", word("NAME"), &S::array,
       "which array of it holds the densities (default: the first that varies)",
       needs("control", "has no effect without --control")},
      {"--levels", integer("N", 0, SubdivisionOptions::kMostLevels), &S::levels,
       "steps of subdivision, each of which makes eight cells of one (default {})"},
      {"--basis", choice(bases), &S::basis,
       "kernels of a vertex: a Gaussian with values such that the field takes the densities at the "
       "vertices, or the least-squares fit of one or two Gaussians to its basis function (default "
       "{})"},
      {"--memory-limit", bytes("BYTES"), &S::memory_limit,
       "what the level may take; more is refused before any work (default {})"},
  };
  return all;
}

Dataset make_solid(const SolidFlags& solid, const std::string& output, Session& session) {
  const bool is_mesh = has_ending(output, ".vtu");
  if (!is_mesh && !has_ending(output, ".ply"))
    throw UsageError(fmt::format(
        "--output '{}': expected a name that ends in .ply for kernels, or in .vtu for the mesh",
        output));
  const SolidMesh control = read_control_mesh(solid, session);
  const SolidMesh level = subdivide_solid(
      control,
      {.levels = solid.levels, .memory_limit = solid.memory_limit, .stop = session.stop()});
  if (is_mesh) return make_solid_dataset(level);
  return make_kernel_dataset(
      make_solid_field(level, {.basis = solid.basis, .stop = session.stop()}));
}

}  // namespace ovoid::cli
