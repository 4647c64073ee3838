// SPDX-License-Identifier: Apache-2.0
#include "render/passes/mesh_crossings.h"

namespace ovoid {
namespace {

// Of their depth: fragments so near each other are at one place. A hundred roundings of a float.
constexpr float kOnePlace = 1e-5F;

// Whether rays go on within the mesh: at each place that the fragments cover as many come in as go
// out, and the mesh was there before.
bool is_inner(std::span<const SurfaceFragment> fragments, const MeshCount& before) {
  std::array<int, SurfaceRaster::kPlaces> sum{};
  std::uint8_t covered = 0;
  for (const SurfaceFragment& fragment : fragments) {
    if (fragment.enters == 0) return false;
    covered = static_cast<std::uint8_t>(covered | fragment.covered);
    for (std::size_t p = 0; p < sum.size(); ++p) {
      if ((fragment.covered >> p & 1U) != 0) sum[p] += fragment.enters;
    }
  }
  for (int p = 0; p < SurfaceRaster::kPlaces; ++p) {
    if ((covered >> p & 1U) == 0) continue;
    if (sum[static_cast<std::size_t>(p)] != 0 || !before.is_inside(p)) return false;
  }
  return true;
}

}  // namespace

bool is_one_place(float depth, float behind) { return behind <= depth * (1 + kOnePlace); }

void drop_inner_boundaries(std::span<const SurfaceFragment> fragments,
                           std::vector<SurfaceFragment>& kept) {
  kept.clear();
  MeshCount count(fragments);
  for (std::size_t begin = 0; begin < fragments.size();) {
    std::size_t end = begin + 1;
    while (end < fragments.size() && is_one_place(fragments[begin].depth, fragments[end].depth))
      ++end;
    const auto group = fragments.subspan(begin, end - begin);
    if (group.size() < 2 || !is_inner(group, count))
      kept.insert(kept.end(), group.begin(), group.end());
    for (const SurfaceFragment& fragment : group) count.pass(fragment);
    begin = end;
  }
}

}  // namespace ovoid
