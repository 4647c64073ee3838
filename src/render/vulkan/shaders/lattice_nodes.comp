#version 450
// SPDX-License-Identifier: Apache-2.0
// The stages of a lattice with post-convolution: sheets of one layer, on which the field is worked
// out at nodes some pixels apart, and brought from there to the pixels. A work group has a tile of
// kNodeTile^2 pixels, four of them a thread; values, and gradients where any pixel shows something,
// are filtered along the rows of nodes first, then down the columns of pixels. A pixel that has a
// node without value around it is worked out by itself, as without nodes.
#extension GL_GOOGLE_include_directive : require
#include "lattice_bindings.glsl"
#include "render/shared/filter_formulas.h"

layout(local_size_x = 16, local_size_y = 16) in;
layout(constant_id = 6) const uint kFilter = 0u;

#include "view.glsl"
#include "look.glsl"
#include "shade.glsl"
#include "gather.glsl"
#include "composite.glsl"
#include "limits.glsl"
#include "finish.glsl"
#include "piece.glsl"
#include "lattice_pixel.glsl"
#include "spread.glsl"

const int kOwn = 4;      // pixels of a thread
const int kHalf = 16;    // pixels between them
const uint kThreads = 256u;

shared float node_values[kMostNodes * kMostNodes];
shared float node_gradients[3][kMostNodes * kMostNodes];
shared uint defined_rows[kMostNodes];  // a bit for a node
shared float filtered_rows[kMostNodes * kNodeTile];
shared uint wanted_by_any;  // 1: a value; 2: a gradient
shared int next_wanted;
// Of the pixels that want a value.
shared uint wanted_lo[2];
shared uint wanted_hi[2];

vec3 own_color(vec2 at, float s) { return vec3(0.0); }  // lattices have one attribute

struct Taps {
  int first;  // node, of the tile's
  float weight[kFilterTaps];
};

Taps taps_at(float place, int first_node) {
  Taps taps;
  float whole = floor(place);
  float phase = place - whole;
  taps.first = int(whole) - kTapsBefore - first_node;
  float sum = 0.0;
  for (int k = 0; k < kFilterTaps; ++k) {
    float weight = filter_weight(kFilter, k, phase);
    taps.weight[k] = weight;
    sum += weight;
  }
  for (int k = 0; k < kFilterTaps; ++k) taps.weight[k] /= sum;
  return taps;
}

// All kernels of an endless lattice exist that reach the place.
bool is_whole(Place place, float s) {
  LatticeConstants lattice = frame.fields[0];
  vec3 reach = lattice.support * widening_on(0, s);
  for (int n = 0; n < num_sublattices(0); ++n) {
    vec3 at = vec3(place.cell) + place.fraction - offset_of(lattice, n);
    if (any(lessThan(at, reach)) ||
        any(greaterThan(at, vec3(dims_of(lattice, n) - 1) - reach)))
      return false;
  }
  return (brick_byte(0, vec3(place.cell)) & kMissingBit) == 0u;
}

// The field at a node, with its gradient (along the world's axes) if that is the kernels'.
Gathered node_at(vec2 at, float s, bool wants_gradient) {
  Ray ray = ray_at(0, at);
  Place place = place_on(ray, s);
  Gathered result;
  result.value = 0.0;
  result.gradient = vec3(0.0);
  result.is_defined = false;
  if (has_flag(kSpreads)) return spread_at(place, s, box.node_step);
  if (!is_in_support(0, place)) return result;
  if (has_flag(kNodesKeepBound) && !is_whole(place, s)) return result;
  result = gather(0, place, s, ray.step.hi, wants_gradient);
  result.gradient = to_world(0, result.gradient);
  return result;
}

vec3 central_gradient_of_node(vec2 at, float s, float value) {
  Neighbours around = kNoNeighbours;
  for (int i = 0; i < kNumNeighbours; ++i) {
    vec3 way = way_to_neighbour(i);
    take_neighbour(around, i, node_at(at + way.xy * box.node_step, s + way.z, false));
  }
  return gradient_of_differences(differences_of(around, value), at, s, box.node_step);
}

ivec2 first_node;  // of the tile; the others are counted from it
ivec2 num_nodes;
ivec2 least_node;  // around pixels that want a value
ivec2 most_node;

// Those nodes on a sheet.
void fill_nodes(float s, bool wants_gradient) {
  uint self = gl_LocalInvocationIndex;
  if (self < uint(kMostNodes)) defined_rows[self] = 0u;
  barrier();
  ivec2 count = most_node - least_node + 1;
  for (uint n = self; n < uint(count.x * count.y); n += kThreads) {
    ivec2 node = least_node + ivec2(int(n) % count.x, int(n) / count.x);
    vec2 at = vec2(first_node + node) * box.node_step;
    bool takes_differences = has_flag(kTakesDifferences);
    Gathered f = node_at(at, s, wants_gradient && !takes_differences);
    if (wants_gradient && takes_differences && f.is_defined)
      f.gradient = central_gradient_of_node(at, s, f.value);
    int place = node.y * kMostNodes + node.x;
    node_values[place] = f.is_defined ? f.value : 0.0;
    for (int a = 0; a < 3; ++a) node_gradients[a][place] = f.is_defined ? f.gradient[a] : 0.0;
    ++num_samples.x;
    if (f.is_defined) atomicOr(defined_rows[node.y], 1u << uint(node.x));
  }
  barrier();
}

// One kind of number of the nodes: -1 values, 0 to 2 gradients, along the rows.
void filter_rows(int kind, uvec2 corner) {
  int num_rows = most_node.y - least_node.y + 1;
  for (uint n = gl_LocalInvocationIndex; n < uint(num_rows * kNodeTile); n += kThreads) {
    int row = least_node.y + int(n) / kNodeTile;
    int column = int(n) % kNodeTile;
    Taps taps = taps_at(float(corner.x + uint(column)) / box.node_step, first_node.x);
    float sum = 0.0;
    for (int k = 0; k < kFilterTaps; ++k) {
      int at = row * kMostNodes + min(taps.first + k, num_nodes.x - 1);
      sum = fma(taps.weight[k], kind < 0 ? node_values[at] : node_gradients[kind][at], sum);
    }
    filtered_rows[row * kNodeTile + column] = sum;
  }
  barrier();
}

float filtered_at(Taps rows, int column) {
  float sum = 0.0;
  for (int k = 0; k < kFilterTaps; ++k)
    sum = fma(rows.weight[k],
              filtered_rows[min(rows.first + k, num_nodes.y - 1) * kNodeTile + column], sum);
  return sum;
}

bool has_all_nodes(Taps columns, Taps rows) {
  uint mask = 63u << uint(columns.first);
  for (int k = 0; k < kFilterTaps; ++k) {
    if ((defined_rows[rows.first + k] & mask) != mask) return false;
  }
  return true;
}

// Whether a pixel's sample on a sheet is wanted: the one itself, or as the front end of a piece.
bool is_wanted_on(Ray ray, vec2 at, float s) {
  Place place = place_on(ray, s);
  if (!is_in_support(0, place)) return false;
  if (has_flag(kIsRefined)) return is_own(place) || is_own(place_on(ray, s + 1.0));
  return is_own(place) && path_fraction(at, s) > 0.0;
}

bool takes_pieces() { return has_flag(kIsPreintegrated | kIsRefined) || kMode == kIsosurface; }

// What a pixel has on a sheet: from nodes, or worked out by itself.
struct NodeSample {
  bool is_defined;
  bool is_from_nodes;
  float value;
  vec3 gradient;  // from nodes, where gradients are
};
const NodeSample kNoSample = NodeSample(false, false, 0.0, vec3(0.0));

// The sample of the sheet joins its pixel. A piece is of the layer that the sheet at its end is of,
// and of nodes if that sample is.
void take_sample(inout Pixel pixel, vec2 at, float s, NodeSample front, NodeSample back,
                 bool has_gradients) {
  bool is_mixed = front.is_from_nodes && !back.is_from_nodes;
  if (takes_pieces() && is_mixed && has_before(pixel, s)) {
    ++num_samples.x;
    pixel.before = gather(0, place_on(own_ray, s - 1.0), s - 1.0, own_ray.step.hi, false).value;
  }
  own_place = place_on(own_ray, s);
  has_own_gradient = back.is_from_nodes && has_gradients;
  own_gradient = back.gradient;
  if (!has_flag(kIsRefined)) {
    float path = path_within_spans(pixel, at, s, path_fraction(at, s));
    take_value(pixel, at, s, path, back.value);
    return;
  }
  has_front_gradient = has_own_gradient && front.is_from_nodes;
  front_gradient = front.gradient;
  take_end(pixel, at, s, back.is_defined, back.value);
}

void main() {
  uvec2 corner = gl_WorkGroupID.xy * uint(kNodeTile) + uvec2(box.tile_x, box.tile_y);
  ivec2 within = ivec2(gl_LocalInvocationID.xy);
  first_node = ivec2(floor(vec2(corner) / box.node_step)) - 2;
  num_nodes = ivec2(floor(vec2(corner + uint(kNodeTile) - 1u) / box.node_step)) + 3 - first_node + 1;
  num_nodes = min(num_nodes, ivec2(kMostNodes));
  Pixel pixels[kOwn];
  Ray rays[kOwn];
  ivec2 ranges[kOwn];
  bool exists[kOwn];
  uvec2 places[kOwn];
  NodeSample fronts[kOwn];  // of the sheet before
  for (int i = 0; i < kOwn; ++i) {
    fronts[i] = kNoSample;
    places[i] = corner + uvec2(within + ivec2(i & 1, i >> 1) * kHalf);
    exists[i] = places[i].x < frame.view.width && places[i].y < box.end_row;
    if (!exists[i]) continue;
    pixels[i] = load_pixel((places[i].y - box.first_row) * frame.view.width + places[i].x);
    rays[i] = ray_at(0, vec2(places[i]));
    ranges[i] = sheets_in_box(rays[i]);
    // What is known of the sheet before is of another layer's nodes.
    pixels[i].before_sheet = -1;
  }
  bool takes_node_gradients =
      has_flag(kTakesGradients) && (!has_flag(kIsPreintegrated) || has_flag(kTakesDifferences));
  int sheet = takes_pieces() ? max(box.first_sheet - 1, 0) : box.first_sheet;
  while (sheet < box.end_sheet) {
    float s = float(sheet);
    bool is_margin = sheet < box.first_sheet;
    if (gl_LocalInvocationIndex == 0u) {
      wanted_by_any = 0u;
      next_wanted = box.end_sheet;
      wanted_lo[0] = wanted_lo[1] = 0xFFFFFFFFu;
      wanted_hi[0] = wanted_hi[1] = 0u;
    }
    barrier();
    bool wants[kOwn];
    bool visits[kOwn];
    int next = box.end_sheet;
    for (int i = 0; i < kOwn; ++i) {
      wants[i] = visits[i] = false;
      if (!exists[i] || (pixels[i].is_closed && has_flag(kStopsOpaque))) continue;
      if (sheet >= ranges[i].y) continue;
      // The sheet before a layer is not in its range, which says nothing of the samples on it.
      int skipped = sheet < ranges[i].x && !is_margin ? ranges[i].x - sheet
                                                      : sheets_to_skip(0, rays[i], s);
      if (skipped > 0) {
        next = min(next, sheet + skipped);
        continue;
      }
      next = min(next, sheet + 1);
      visits[i] = is_own(place_on(rays[i], s));
      wants[i] = is_wanted_on(rays[i], vec2(places[i]), s);
      if (!wants[i]) continue;
      atomicOr(wanted_by_any, 1u);
      for (int a = 0; a < 2; ++a) {
        atomicMin(wanted_lo[a], places[i][a]);
        atomicMax(wanted_hi[a], places[i][a]);
      }
    }
    atomicMin(next_wanted, next);
    barrier();
    bool is_wanted = wanted_by_any != 0u;
    int following = max(next_wanted, sheet + 1);
    if (is_wanted) {
      vec2 lo = vec2(float(wanted_lo[0]), float(wanted_lo[1]));
      vec2 hi = vec2(float(wanted_hi[0]), float(wanted_hi[1]));
      least_node = max(ivec2(floor(lo / box.node_step)) - 2 - first_node, ivec2(0));
      most_node = min(ivec2(floor(hi / box.node_step)) + 3 - first_node, num_nodes - 1);
    }
    barrier();
    bool wants_gradients = takes_node_gradients && (!is_margin || has_flag(kIsRefined));
    NodeSample found[kOwn];
    for (int i = 0; i < kOwn; ++i) found[i] = kNoSample;
    if (is_wanted) {
      fill_nodes(s, wants_gradients);
      filter_rows(-1, corner);
      for (int i = 0; i < kOwn; ++i) {
        if (!wants[i]) continue;
        Taps columns = taps_at(float(places[i].x) / box.node_step, first_node.x);
        Taps rows = taps_at(float(places[i].y) / box.node_step, first_node.y);
        found[i].is_from_nodes = has_all_nodes(columns, rows);
        if (found[i].is_from_nodes) {
          found[i].value = filtered_at(rows, int(places[i].x - corner.x));
          found[i].is_defined = true;
          // What lies between two sheets may show where neither of them does.
          if (wants_gradients &&
              (has_flag(kIsRefined) || classify(frame.looks[0].look, found[i].value).a > 0.0))
            atomicOr(wanted_by_any, 2u);
        } else {
          ++num_samples.x;
          Gathered f = gather(0, place_on(rays[i], s), s, rays[i].step.hi, false);
          found[i].value = f.value;
          found[i].is_defined = f.is_defined;
        }
      }
      barrier();
      if (wants_gradients && (wanted_by_any & 2u) != 0u) {
        for (int a = 0; a < 3; ++a) {
          filter_rows(a, corner);
          for (int i = 0; i < kOwn; ++i) {
            if (!found[i].is_from_nodes) continue;
            Taps rows = taps_at(float(places[i].y) / box.node_step, first_node.y);
            found[i].gradient[a] = filtered_at(rows, int(places[i].x - corner.x));
          }
          barrier();
        }
      }
    }
    for (int i = 0; i < kOwn; ++i) {
      if (visits[i] && !is_margin && (found[i].is_defined || has_flag(kIsRefined))) {
        own_ray = rays[i];
        take_sample(pixels[i], vec2(places[i]), s, fronts[i], found[i], takes_node_gradients);
      } else if (found[i].is_defined) {
        pixels[i].before = found[i].value;
        pixels[i].before_sheet = sheet;
      }
      fronts[i] = found[i];
    }
    sheet = following;
    barrier();
  }
  for (int i = 0; i < kOwn; ++i) {
    if (exists[i])
      store_pixel((places[i].y - box.first_row) * frame.view.width + places[i].x, pixels[i]);
  }
  uint group = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
  atomicAdd(counts[group].x, num_samples.x);
  atomicAdd(counts[group].y, num_samples.y);
  atomicAdd(counts[group].z, num_samples.z);
}
