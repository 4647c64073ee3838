// SPDX-License-Identifier: Apache-2.0
#include "render/field_levels.h"

#include <algorithm>
#include <cmath>

#include "ovoid/coarse.h"
#include "ovoid/error.h"
#include "view/plan/view_lattice.h"

namespace ovoid {
namespace {

// Fields whose levels are kept, an eighth of a field each.
constexpr std::size_t kMostKept = 4;

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

// A level is for time, not to take more memory than the field does: of fields that stay in a file,
// or of relevant samples alone, it may be larger than they are. Samples counted as floats.
bool has_room_for_level(const Field& field) {
  return field.num_kernels() / 8 * static_cast<std::int64_t>(sizeof(float)) <=
         static_cast<std::int64_t>(field.resident_bytes());
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

std::vector<Field>& FieldLevels::pyramid_of(const Field& field) {
  const auto found = std::find_if(kept_.begin(), kept_.end(), [&](const Pyramid& kept) {
    return kept.id == field.id() && kept.version == field.version();
  });
  if (found != kept_.end()) {
    std::rotate(kept_.begin(), found, found + 1);
  } else {
    if (kept_.size() == kMostKept) kept_.pop_back();
    kept_.insert(kept_.begin(), {field.id(), field.version(), {}});
  }
  return kept_.front().coarser;
}

const Field& FieldLevels::at(const Field& field, int level, int threads,
                             const std::stop_token& stop) {
  if (level == 0) return field;
  std::vector<Field>& coarser = pyramid_of(field);
  try {
    while (static_cast<int>(coarser.size()) < level) {
      if (!has_room_for_level(coarser.empty() ? field : coarser.back())) break;
      CoarseOptions options;
      options.threads = threads;
      options.stop = stop;
      coarser.push_back(coarse_field(coarser.empty() ? field : coarser.back(), options));
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kOutOfMemory) throw;
  }
  if (coarser.empty()) return field;
  return coarser[std::min(static_cast<std::size_t>(level), coarser.size()) - 1];
}

}  // namespace ovoid
