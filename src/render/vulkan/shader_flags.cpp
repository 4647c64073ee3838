// SPDX-License-Identifier: Apache-2.0
#include "render/vulkan/shader_flags.h"

namespace ovoid::vulkan {
namespace {

struct Flag {
  bool is_set;
  std::uint32_t bit;
};

std::uint32_t bits_of(std::initializer_list<Flag> flags) {
  std::uint32_t bits = 0;
  for (const Flag& flag : flags) bits |= flag.is_set ? flag.bit : 0;
  return bits;
}

}  // namespace

std::uint32_t frame_flags(const FrameTraits& traits, const RenderOptions& options) {
  return bits_of({{traits.is_parallel, device::kIsParallel},
                  {traits.is_clipped, device::kIsClipped},
                  {traits.is_lit, device::kShades},
                  {traits.is_preintegrated, device::kIsPreintegrated},
                  {traits.is_refined, device::kIsRefined},
                  {traits.fades_by_gradient, device::kFades},
                  {traits.takes_gradients, device::kTakesGradients},
                  {traits.takes_differences, device::kTakesDifferences},
                  {traits.has_own_color, device::kHasOwnColor},
                  {options.depth_limits != nullptr, device::kHasLimits},
                  {options.spread == Spread::kBilinear, device::kSpreads},
                  {traits.nodes_keep_bound, device::kNodesKeepBound},
                  {traits.fades_at_cuts, device::kFadesAtCuts},
                  {options.stop_opaque, device::kStopsOpaque}});
}

std::uint32_t lattice_flags(const LatticeTraits& traits, bool is_double, bool may_miss) {
  return bits_of({{traits.is_sum, device::kIsSum},
                  {traits.takes_means, device::kTakesMeans},
                  {traits.is_piecewise, device::kIsPiecewise},
                  {traits.has_four_taps && !is_double, device::kHasFourTaps},
                  {traits.corrects_gradient, device::kCorrects},
                  {may_miss, device::kMayMiss},
                  {is_double, device::kIsDouble}});
}

std::uint32_t set_flags(const KernelTraits& traits, const KernelField& field, bool is_parallel) {
  return bits_of({{field.source().shape() == KernelShape::kEllipsoids, device::kHasEllipsoids},
                  {traits.is_sum, device::kSetIsSum},
                  {traits.takes_means, device::kSetTakesMeans},
                  {field.has_own_color(), device::kSetHasColor},
                  {traits.max_level > 0, device::kHasLevels},
                  {traits.gathers, device::kIsFragmentCentric},
                  {is_parallel, device::kSetIsParallel},
                  {traits.finds_cover, device::kSetFindsCover}});
}

std::uint32_t type_number(ScalarType type) {
  switch (type) {
    case ScalarType::kUInt8:
      return device::kTypeU8;
    case ScalarType::kInt8:
      return device::kTypeI8;
    case ScalarType::kUInt16:
      return device::kTypeU16;
    case ScalarType::kInt16:
      return device::kTypeI16;
    default:
      return device::kTypeF32;
  }
}

}  // namespace ovoid::vulkan
