// SPDX-License-Identifier: Apache-2.0
#include "render/field_levels.h"

#include <algorithm>
#include <cmath>

#include "ovoid/coarse.h"
#include "ovoid/error.h"
#include "view/view_lattice.h"

namespace ovoid {
namespace {

// Along its longest axis; fewer samples cost nothing.
constexpr std::int64_t kLeastSamples = 32;

// The width of the narrowest pixel of those that can show the lattice, world units.
double least_pitch(const LatticeGeometry& geometry, const Camera& camera,
                   const RenderOptions& options) {
  const double spacing = geometry.spacing().maxCoeff();
  const view::ViewLattice lattice(camera, options.width, options.height, spacing, geometry);
  if (lattice.is_parallel()) return lattice.pitch(0);
  const auto sheets = lattice.sheets_meeting(geometry.index_bounds());
  return sheets.first < sheets.last ? lattice.pitch(sheets.first) : 0.0;
}

}  // namespace

int coarsest_level(const Field& field, const Camera& camera, const RenderOptions& options) {
  const LatticeField* const lattice = field.lattice();
  if (lattice == nullptr || options.post_convolution != PostConvolution::kAuto) return 0;
  const LatticeGeometry& geometry = lattice->geometry();
  if (geometry.num_sublattices() > 1) return 0;  // their coarser ones do not lie where they lay
  // Kernels that are not divided by their sum ripple unless they stay wider than a spacing.
  const double least_pixel = lattice->reconstruction() == Reconstruction::kSum ? 2.0 : 1.0;
  const std::int64_t longest = std::max({geometry.dims[0], geometry.dims[1], geometry.dims[2]});
  // An axis of one sample stays as it is.
  const Vec3 spacing = geometry.spacing();
  double widest = 0;
  for (int a = 0; a < 3; ++a) {
    if (geometry.dims[static_cast<std::size_t>(a)] > 1) widest = std::max(widest, spacing[a]);
  }
  const double pitch = least_pitch(geometry, camera, options);
  int level = 0;
  while (pitch >= least_pixel * widest * std::exp2(level + 1) * (1 - 1e-9) &&
         longest >= kLeastSamples << (level + 1))
    ++level;
  return level;
}

const Field& FieldLevels::at(const Field& field, int level, int threads,
                             const std::stop_token& stop) {
  if (level == 0) return field;
  if (field.id() != id_ || field.version() != version_) {
    coarser_.clear();
    id_ = field.id();
    version_ = field.version();
  }
  try {
    while (static_cast<int>(coarser_.size()) < level) {
      CoarseOptions options;
      options.threads = threads;
      options.stop = stop;
      coarser_.push_back(coarse_field(coarser_.empty() ? field : coarser_.back(), options));
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kOutOfMemory) throw;
  }
  if (coarser_.empty()) return field;
  return coarser_[std::min(static_cast<std::size_t>(level), coarser_.size()) - 1];
}

}  // namespace ovoid
