// SPDX-License-Identifier: Apache-2.0
// What every stage reads and none writes: one frame's constants, in the form that the SIMD code
// wants.
#pragma once

#include <array>
#include <cstdint>
#include <stop_token>
#include <type_traits>

#include "ovoid/renderer.h"
#include "render/shared/device_layout.h"
#include "render/shared/look_nodes.h"
#include "render/shared/slab_nodes.h"
#include "view/frame_plan.h"

namespace ovoid::cpu {

// A normalized field is undefined where the weights that exist are a smaller part of an endless
// lattice's (docs/numerics.md).
inline constexpr float kLeastWeight = 0.48F;
static_assert(kLeastWeight == device::kLeastShare);

// The look table, to be read as it says: red, green, blue and opacity of a node side by side. The
// opacity is corrected for a path of one sampling distance, unless the frame corrects_late.
struct ClassificationTable {
  const float* nodes = nullptr;  // [last_node + 2][4], 16-byte aligned
  const float* steps = nullptr;  // [last_node + 1]; null if no cell has one
  view::LookAxis axis;
  float last_node = 1;
  float visible_lo = 0, visible_hi = 0;  // values outside have no opacity
};

// Spacings squared: a gradient is only corrected where more than one kernel has weight.
inline constexpr float kLeastVariance = 1e-6F;
// The same of several sublattices, where a matrix is inverted: it must not be near to singular.
inline constexpr float kLeastInnerVariance = 1e-3F;
static_assert(kLeastVariance == device::kLeastOffset);
static_assert(kLeastInnerVariance == device::kLeastInnerOffset);

// Samples at whole numbers of index space, shifted.
struct FrameSublattice {
  std::array<std::int32_t, 3> dims{};
  float offset = 0;  // along every axis
};

inline constexpr int kMaxSublattices = 2;
static_assert(kMaxSublattices == std::extent_v<decltype(device::LatticeConstants::dims)>);

struct CpuFrame {
  const view::FramePlan* plan = nullptr;
  const view::LatticePlan* lattice_plan = nullptr;  // `plan`, if it is a lattice's
  const LatticeField* field = nullptr;              // likewise
  const CpuFrame* behind = nullptr;  // of a second field, drawn behind this one sheet by sheet
  std::stop_token stop;

  // Kernel and lattice
  int num_sublattices = 1;
  std::array<FrameSublattice, kMaxSublattices> sublattices{};
  float sigma = 0.5F;                     // index units, before widening
  float support = 2.0F;                   // index units, before widening
  float inverse_variance = 4.0F;          // 1 / sigma^2
  float near_weight = 0, far_weight = 0;  // g(1) / g(0), g(2) / g(0)
  bool has_four_taps = true;  // the default kernel, normalized, mid samples: four_taps-inl.h
  bool is_sum = false;
  float sum_weight = 1;  // w of a `sum` field
  float value_scale = 1, value_offset = 0;
  float world_from_index_gradient[9] = {};  // row major: grad_world = M * grad_index

  // View
  bool is_parallel = true;
  view::SheetMap ray_direction;
  float right[3] = {}, up[3] = {}, axis[3] = {};    // of the camera, world
  view::ClipMap ray_slope_right{}, ray_slope_up{};  // of the ray of pixel (x, y), per unit of depth
  float sampling_distance = 1;
  SlabNodes slab;  // one node: mid samples
  bool central_gradient = false;
  bool corrects_gradient = true;  // constant on ramps (docs/numerics.md, "Gradients")
  Evaluate evaluate = Evaluate::kAuto;
  PostConvolution post_convolution = PostConvolution::kOff;
  Spread spread = Spread::kGaussian;
  bool samples_at_nodes = false;  // some sheets are: tiles come in patches (nodes.h)
  bool takes_pieces = false;      // what shows lies between a sheet and the one before it
  bool stop_opaque = true;
  bool collect_profile = false;

  // Appearance
  Mode mode = Mode::kComposite;
  bool shade = true;
  ClassificationTable table;
  const IntegralNodes* integrals = nullptr;  // of pieces, if is_preintegrated
  ClassificationTable fading;       // opacity by the gradient's length, if fades_by_gradient
  ClassificationTable color_table;  // colours by another attribute, if has_own_color
  bool has_own_color = false;
  bool is_preintegrated = false;
  bool fades_by_gradient = false;
  bool takes_gradients = true;  // for light or for fading
  bool corrects_late = false;   // opacities are corrected for their path after the gradient
  float path_in_units = 1;      // sampling distance over unit distance
  float isovalue = 0;
  std::array<float, 4> isosurface_color{};
  float ambient = 0.1F, diffuse = 0.7F, specular = 0.2F, specular_power = 10.0F;
  bool has_headlight = true;
  float light[3] = {0, 0, 1};  // world, unit, towards the light
  float flat_gradient_inverse =
      0;  // 1 / (gradient length, world, below which a region counts as flat)
};

}  // namespace ovoid::cpu
