// SPDX-License-Identifier: Apache-2.0
// What the host hands to shaders, read by both: as C++, and as GLSL with the layout std430, whose
// rules the members are ordered and padded by. tests hold every offset to the shaders' own.
#ifndef OVOID_RENDER_SHARED_DEVICE_LAYOUT_H_
#define OVOID_RENDER_SHARED_DEVICE_LAYOUT_H_

#ifdef __cplusplus
#pragma once

#include <cstdint>

namespace ovoid::device {

// By their names in GLSL. NOLINTBEGIN(readability-identifier-naming)
using uint = std::uint32_t;
struct alignas(16) vec4 {
  float x = 0, y = 0, z = 0, w = 0;
};
struct alignas(16) ivec4 {
  std::int32_t x = 0, y = 0, z = 0, w = 0;
};
// NOLINTEND(readability-identifier-naming)
#define OVOID_CONSTANT inline constexpr
#else
#define OVOID_CONSTANT const
#endif

// ---- Numbers ----

OVOID_CONSTANT uint kGroupEdge = 8u;  // pixels along the side of a work group: 64 threads
OVOID_CONSTANT uint kGroupSize = 64u;
OVOID_CONSTANT int kStoredEdge = 4;   // samples along the side of a cube that lies together
OVOID_CONSTANT uint kMaxFields = 2u;  // a field and its trail
OVOID_CONSTANT uint kMaxClips = 16u;
OVOID_CONSTANT int kMaxSublattices = 2;
OVOID_CONSTANT int kMaxSlabPoints = 32;
OVOID_CONSTANT uint kNoTable = 0xFFFFFFFFu;
OVOID_CONSTANT uint kTableCells = 4096u;
// A normalized field is undefined where the weights that exist are a smaller part of an endless
// lattice's (docs/numerics.md).
OVOID_CONSTANT float kLeastShare = 0.48f;
OVOID_CONSTANT float kLeastSetWeight = 0.2f;
// Spacings squared: a gradient is only corrected where more than one kernel has weight; of several
// sublattices, where the matrix that is inverted is not near to singular.
OVOID_CONSTANT float kLeastVariance = 1e-6f;
OVOID_CONSTANT float kLeastInnerVariance = 1e-3f;
OVOID_CONSTANT int kSurfaceSteps = 8;  // bisections, to 1/256 of a sheet's distance, then a secant
// Refined pieces: view/look/look_variation.h.
OVOID_CONSTANT int kMostSteps = 16;
OVOID_CONSTANT float kStepsPerVariation = 10.0f;
OVOID_CONSTANT float kLeastVisibleOpacity = 0.003921568627451f;  // ovoid::kLeastVisibleOpacity
OVOID_CONSTANT float kClosePieces = 2.0f;  // cells: the middle stands for a shorter piece
OVOID_CONSTANT int kFarBricks = 63;        // the greatest distance that is kept
OVOID_CONSTANT uint kDistanceBits = 63u;   // of a brick's byte
OVOID_CONSTANT uint kMissingBit = 128u;    // of a brick's byte: samples may be missing

// Bits of the specialisation constants.
// Of a field:
OVOID_CONSTANT uint kIsSum = 1u;
OVOID_CONSTANT uint kTakesMeans = 2u;
OVOID_CONSTANT uint kHasFourTaps = 4u;
OVOID_CONSTANT uint kCorrects = 8u;      // gradients, so that ramps have a constant one
OVOID_CONSTANT uint kMayMiss = 16u;      // some sample is missing
OVOID_CONSTANT uint kIsDouble = 32u;     // two sublattices
OVOID_CONSTANT uint kIsPiecewise = 64u;  // the kernel is made of polynomials
OVOID_CONSTANT uint kIsNarrow = 128u;    // of kHasFourTaps: on these sheets no kernel is widened
// Of a frame:
OVOID_CONSTANT uint kIsParallel = 1u;
OVOID_CONSTANT uint kIsClipped = 2u;
OVOID_CONSTANT uint kShades = 4u;
OVOID_CONSTANT uint kIsPreintegrated = 8u;
OVOID_CONSTANT uint kFades = 16u;  // by the gradient
OVOID_CONSTANT uint kTakesGradients = 32u;
OVOID_CONSTANT uint kTakesDifferences = 64u;
OVOID_CONSTANT uint kStopsOpaque = 128u;
OVOID_CONSTANT uint kIsRefined = 256u;
OVOID_CONSTANT uint kHasLightVolume = 512u;
OVOID_CONSTANT uint kHasTrail = 1024u;
OVOID_CONSTANT uint kHasOwnColor = 2048u;
OVOID_CONSTANT uint kHasLimits = 4096u;          // in depth, per pixel
OVOID_CONSTANT uint kNodesKeepBound = 8192u;     // those near faces have no value
OVOID_CONSTANT uint kSpreads = 16384u;           // bilinearly
OVOID_CONSTANT uint kFadesAtCuts = 32768u;       // light, towards cut faces
OVOID_CONSTANT uint kGathersGradients = 65536u;  // with every value, whether or not it is seen
// Of post-convolution.
OVOID_CONSTANT int kNodeTile = 32;   // pixels along the side of the tile that shares nodes
OVOID_CONSTANT int kMostNodes = 30;  // along it, with those around: at 1.45 pixels each 28
OVOID_CONSTANT int kFilterTaps = 6;  // samples at -kTapsBefore, ..., +3 from the one at or before
OVOID_CONSTANT int kTapsBefore = 2;
// ovoid::PostConvolution as a number.
OVOID_CONSTANT uint kFilterBilinear = 1u;
OVOID_CONSTANT uint kFilterGaussian = 2u;
OVOID_CONSTANT uint kFilterCubic = 3u;
OVOID_CONSTANT uint kFilterLagrange = 4u;
// ovoid::ValueScale and ovoid::Mode as numbers, and types of samples.
OVOID_CONSTANT uint kScaleLinear = 0u;
OVOID_CONSTANT uint kScaleLog = 1u;
OVOID_CONSTANT uint kComposite = 0u;
OVOID_CONSTANT uint kXray = 1u;
OVOID_CONSTANT uint kMaximum = 2u;
OVOID_CONSTANT uint kMean = 3u;
OVOID_CONSTANT uint kIsosurface = 4u;
OVOID_CONSTANT uint kMinimum = 5u;
// ovoid::Light and its direction. The studio's numbers are docs/numerics.md's.
OVOID_CONSTANT uint kSingleLight = 0u;
OVOID_CONSTANT uint kHeadlight = 1u;
OVOID_CONSTANT uint kStudioLight = 2u;
OVOID_CONSTANT float kKeyShare = 0.65f;      // of the diffuse light; the rest is the fill's
OVOID_CONSTANT uint kMaxFurtherLights = 4u;  // Look::kMaxFurtherLights
OVOID_CONSTANT float kMeanCosine = 0.5f;     // of further lights, where the field is flat
OVOID_CONSTANT float kKeyWrap = 0.25f;       // how far the key reaches round a surface: a cosine
OVOID_CONSTANT uint kTypeU8 = 0u;
OVOID_CONSTANT uint kTypeI8 = 1u;
OVOID_CONSTANT uint kTypeU16 = 2u;
OVOID_CONSTANT uint kTypeI16 = 3u;
OVOID_CONSTANT uint kTypeF32 = 4u;

// ---- Layouts ----

// view::LookAxis and where its table lies: entries_at counts vectors, steps_at numbers.
struct TableConstants {
  uint scale;
  float origin;
  int origin_bits;
  float cells_per_step;
  float inverse_width;
  float visible_lo;
  float visible_hi;
  uint entries_at;
  uint steps_at;  // kNoTable: no cell has a step
  uint padding0;
  uint padding1;
  uint padding2;
};

// view::LightVolume as samples of a frame read it. Cell coordinates of pixel (x, y) on sheet s,
// counted from the frame's first: start[0] + x start[1] + y start[2] + s (step[0] + x step[1] + y
// step[2]).
struct LightConstants {
  vec4 start[3];
  vec4 step[3];
  vec4 shift[3];  // cells in a mean cell edge along the world's axes: rows of a matrix
  ivec4 dims;     // w: where the cells begin, in numbers of the tables
};
OVOID_CONSTANT float kLightSteps = 4095.0f;  // view::packed_light()
OVOID_CONSTANT float kLightRadix = 4096.0f;
OVOID_CONSTANT float kLightSteepness = 4.0f;  // view::light_shift()

struct LookConstants {
  TableConstants look;
  TableConstants color;   // of another attribute
  TableConstants fading;  // by the gradient's length, in FramePlan::gradient_unit
  vec4 integrals_before;
  vec4 integrals_behind;
  vec4 isosurface_color;
  vec4 light;  // world, unit length, towards it
  LightConstants volume;
  float integral_per_value;
  float integral_lo;
  float integral_hi;
  uint integrals_at;
  float ambient;
  float diffuse;
  float specular;
  float specular_power;
  float flat_gradient_inverse;
  float path_in_units;
  float isovalue;
  uint light_kind;
  uint variation_at;  // view::look_variation(), one number an entry; of refined pieces
  uint num_further_lights;
  uint padding0;
  uint padding1;
  vec4 further_lights[kMaxFurtherLights];  // unit length, towards each; w: its intensity
};

// Samples at whole numbers of index space, shifted.
struct Sublattice {
  int dims[3];
  float offset;  // along every axis
};

// A Gauss-Legendre point of a slab.
struct SlabPoint {
  float offset;  // sheets, from the middle
  float weight;  // their sum is 1
};

// Positions are sums of two floats each, so that they are as exact far from the origin as near it.
struct LatticeConstants {
  vec4 place_hi[3];  // index position of pixel (0, 0) on the frame's sheet 0; per x; per y
  vec4 place_lo[3];
  vec4 step_hi[3];  // its change per sheet
  vec4 step_lo[3];
  vec4 gradient_rows[3];   // of the world's axes, in FramePlan::gradient_unit, from index
  vec4 camera_rows[3];     // to the right, down and along the view axis, world, from index
  vec4 camera_columns[3];  // the inverse's rows, magnitudes
  vec4 inverse_spacing;
  vec4 widening_limit;
  vec4 support_lo;  // index positions where the field can be defined
  vec4 support_hi;
  // Kernels that are cubic polynomials of t, the distance over a unit of the axis: coefficients of
  // 1, t, t^2 and t^3 for t < 1 and for t from 1 to 2. Of Gaussians zeros.
  vec4 inner_piece;
  vec4 outer_piece;
  vec4 faces_lo;  // of the box of all samples' cells, index space
  vec4 faces_hi;
  SlabPoint slab[kMaxSlabPoints];  // where the mean of a slab is taken
  ivec4 num_bricks;                // w: log2 of the edge
  Sublattice sublattices[kMaxSublattices];
  float sigma;    // index units, before widening
  float support;  // likewise
  float inverse_variance;
  float sum_weight;   // w of a `sum` field
  float near_weight;  // of a kernel one spacing away, against that of one in the place
  float far_weight;   // two spacings away
  float value_scale;
  float value_offset;
  int num_slab_points;  // 1: the middle alone
  int num_sublattices;
  float inverse_unit;  // of the pieces' t, before widening
  uint is_piecewise;   // the pieces are the kernel; shaders have kIsPiecewise
};

// A clip plane: distance inside, world, at pixel (x, y) of sheet s: at_first + s per_sheet, each
// x + pixel x * y + pixel y * z of the vector.
struct ClipConstants {
  vec4 at_first;
  vec4 per_sheet;
};

struct ViewConstants {
  vec4 right;  // world
  vec4 up;
  vec4 axis;
  vec4 ray[3];       // world, per unit of depth: of pixel (0, 0); per x; per y
  vec4 slope_right;  // of the ray along `right`: at pixel (0, 0), per x, per y
  vec4 slope_up;
  ClipConstants clips[kMaxClips];
  uint width;
  uint height;
  int num_sheets;
  uint num_clips;
  float sampling_distance;
  float first_depth;  // of sheet 0 of the frame
  float near_cut;     // sheets: where slabs begin at the earliest; -infinity in parallel projection
  float pitch;        // of a pixel on sheet 0, world
  float pitch_per_sheet;
  float opaque_at;       // a pixel is closed once its opacity has reached this
  float gradient_pitch;  // what differences of pixels and sheets are divided by for gradients in
  float gradient_pitch_per_sheet;  // FramePlan::gradient_unit
  float gradient_step;
  uint num_cut_faces;          // the first clips; light fades towards them
  float clearance_per_length;  // 1 / h_min
  float padding0;
};

struct LatticeFrame {
  ViewConstants view;
  LookConstants looks[kMaxFields];
  LatticeConstants fields[kMaxFields];
};

// One box of a lattice: which cells are its own, and which samples are stored. The outermost own
// what lies beyond, too.
struct BoxConstants {
  ivec4 own_lo;
  ivec4 own_hi;
  ivec4 stored_lo;
  ivec4 stored_bricks;  // w: words from a sublattice's samples to the next one's, of bytes
  uint tile_x;          // in the picture, of work group (0, 0)
  uint tile_y;
  uint first_row;  // of the picture, that the pixels' buffers begin with
  uint end_row;
  int first_sheet;  // that are drawn now
  int end_sheet;
  float node_step;  // pixels from node to node, on these sheets
  uint padding;
};

// A pass of the distances between bricks, along one axis.
struct DistanceConstants {
  ivec4 num_bricks;  // w: the axis
};

// ---- Kernel sets ----

OVOID_CONSTANT int kBlockDepth = 4;  // of a layer; view::kBlockDepth
OVOID_CONSTANT int kPlanEdge = 64;   // pixels of a plan's block; view::kBlockEdge
OVOID_CONSTANT int kNumLevels = 7;   // samples 1 to 64 pixels wide
OVOID_CONSTANT uint kBrickGroup =
    256u;  // threads for a brick's kernels: KernelBrick::kMaxBrickKernels
OVOID_CONSTANT uint kNoList = 0xFFFFFFFFu;
OVOID_CONSTANT uint kScanGroup = 256u;  // threads of a scan, which takes four numbers each
OVOID_CONSTANT uint kScanItems = 1024u;
OVOID_CONSTANT uint kSortGroup = 256u;  // threads of a sort, which takes eight pairs each
OVOID_CONSTANT uint kSortItems = 2048u;
OVOID_CONSTANT uint kSortBits = 4u;  // of a digit
OVOID_CONSTANT uint kSortBins = 16u;
// Of a slab, where a mean has no closed form: Gauss-Legendre on [-1/2, 1/2].
OVOID_CONSTANT int kProfilePoints = 8;
OVOID_CONSTANT float kProfilePointOffsets[kProfilePoints] = {
    -0.48014493f, -0.39833324f, -0.26276620f, -0.09171732f,
    0.09171732f,  0.26276620f,  0.39833324f,  0.48014493f};
OVOID_CONSTANT float kProfilePointWeights[kProfilePoints] = {0.05061427f, 0.11119052f, 0.15685332f,
                                                             0.18134189f, 0.18134189f, 0.15685332f,
                                                             0.11119052f, 0.05061427f};
OVOID_CONSTANT float kLeastSigma = 0.5f;  // in units of kLeastPixels (view) and sheets
// Bits of a plan's block.
OVOID_CONSTANT uint kBlockIsNeeded = 1u;
OVOID_CONSTANT uint kBlockIsRelevant = 2u;
// Bits of what is said of a level.
OVOID_CONSTANT uint kIsFinest = 1u;
OVOID_CONSTANT uint kHasCoarser = 2u;
// ovoid::KernelProfile.
OVOID_CONSTANT uint kProfileGaussian = 0u;
OVOID_CONSTANT uint kProfileCubicSpline = 1u;
OVOID_CONSTANT uint kProfileWendland = 2u;
OVOID_CONSTANT uint kProfileEpanechnikov = 3u;
// Bits of a kernel frame's specialisation constant.
OVOID_CONSTANT uint kHasEllipsoids = 1u;
OVOID_CONSTANT uint kSetIsSum = 2u;
OVOID_CONSTANT uint kSetTakesMeans = 4u;
OVOID_CONSTANT uint kSetHasColor = 8u;
OVOID_CONSTANT uint kHasLevels = 16u;
OVOID_CONSTANT uint kIsFragmentCentric = 32u;
OVOID_CONSTANT uint kSetHalfSheets = 64u;
OVOID_CONSTANT uint kSetIsParallel = 128u;
OVOID_CONSTANT uint kSetFindsCover = 256u;  // a sum on levels, defined where a kernel reaches

// A level's tiles of kGroupEdge^2 samples in a strip of the picture.
struct LevelConstants {
  ivec4 tiles;      // number along x and y; numbers of the first ones
  uint first_list;  // of the level, for a layer's tiles one after the other
  uint plane_at;    // in the buffer of levels: of sheet 0, channel 0
  uint padding0;
  uint padding1;
};

struct KernelFrame {
  ViewConstants view;
  LookConstants looks[1];
  vec4 rotation[3];  // rows: right, down, view axis
  LevelConstants levels[kNumLevels];
  vec4 taps[3];      // of post-convolution: a quarter behind a coarse sample, and three quarters
  ivec4 num_blocks;  // of the plan; w: the lists in a layer, all levels
  float pitch;       // of a pixel at the focal depth, world
  float sampling_distance;
  float focal_depth;
  float first_depth;
  float center_x;  // of the optical axis, pixels
  float center_y;
  float near_depth;
  float cutoff;
  float least_pixels;
  float least_level_sigma;
  float sheet_scale;  // from values to what half sheets hold
  float sheet_offset;
  int num_sheets;
  int max_level;
  int ring_sheets;
  int num_numbers;  // of a kernel, in its page
};

// A brick's part in a frame.
struct BrickConstants {
  vec4 origin;  // right and down from the optical axis, world units; depth behind sheet 0
  uint first;   // number of its first kernel in its page
  uint count;
  uint first_splat;
  uint padding;
};

// A kernel in splat space (view/plan/kernel_plan.h), as the cpu back end has it.
struct DeviceSplat {
  vec4 center;  // x, y, s; weight
  vec4 shape;   // axx, axy, ayy; 1 / variance along s
  vec4 slide;   // mx, my; reach along s; smaller sigma
  vec4 values;  // value, colour; reach along x and y
};

// What is worked out now.
struct KernelPush {
  int first_layer;  // of the lists that there are
  int end_layer;
  int layer;     // of the chunk in hand
  int coarsest;  // level of the lists that there are
  int level;
  int first_sheet;  // to shade
  int end_sheet;
  uint num_items;  // kernels, numbers, pairs, lists: whatever there are of
  uint shift;      // of a sort's digit
  uint first_row;  // of the strip
  uint end_row;
  uint first_item;
  int only_sheet;  // of a layer's; -1: all at once
  uint padding0;
  uint padding1;
  uint padding2;
};

// What a pixel has gathered beside its colour and depth.
struct PixelState {
  float best;    // maximum: greatest value; x-ray and mean: sum of value * path
  float path;    // mean: sum of paths
  float before;  // value on the sheet before
  uint flags;    // kSeen, kClosed, and (number of the sheet that `before` is of + 1) << 2; 0: none
};
OVOID_CONSTANT uint kSeen = 1u;
OVOID_CONSTANT uint kClosed = 2u;

// ---- Depth limits ----

// A place on a pixel's ray: ovoid::DepthLimits::Stop.
struct DepthStop {
  float depth;
  uint flags;     // kFieldBehind, kSeam
  float rgba[4];  // premultiplied
};
OVOID_CONSTANT uint kFieldBehind = 1u;
OVOID_CONSTANT uint kSeam = 2u;

// A pixel's stops, by their numbers: [first, end), of which those before `next` have joined it.
struct PixelStops {
  uint first;
  uint end;
  uint next;
};

// What is worked out for each pixel of a strip by itself.
struct StripConstants {
  uint num_pixels;
};

#ifdef __cplusplus
static_assert(sizeof(TableConstants) == 48);
static_assert(sizeof(LightConstants) == 160);
static_assert(sizeof(LookConstants) == 3 * 48 + 4 * 16 + 160 + 64 + 16 * kMaxFurtherLights);
static_assert(sizeof(LatticeConstants) % 16 == 0);
static_assert(sizeof(ViewConstants) % 16 == 0);
static_assert(sizeof(BoxConstants) == 96);  // push constants: 128 bytes are sure
static_assert(sizeof(PixelState) == 16);
static_assert(sizeof(DepthStop) == 24);
static_assert(sizeof(PixelStops) == 12);
static_assert(sizeof(LevelConstants) == 32);
static_assert(sizeof(KernelFrame) % 16 == 0);
static_assert(sizeof(BrickConstants) == 32);
static_assert(sizeof(DeviceSplat) == 64);
static_assert(sizeof(KernelPush) == 64);
}  // namespace ovoid::device
#endif
#endif
