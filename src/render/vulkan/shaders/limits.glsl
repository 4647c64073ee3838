// SPDX-License-Identifier: Apache-2.0
// Depth limits: where along its ray a pixel draws the field, and what joins it there
// (docs/numerics.md, "Depth limits").
//
// A pixel goes along its stops from front to back, as it does along its sheets, and each joins it
// when it is passed. The last one that has joined says whether the field is drawn from there to the
// next one: that is the span in hand. A pixel that has passed its last span is closed.

const float kEndlessDepth = 3.4e38;  // where a span ends that no stop ends

bool is_field_behind(DepthStop stop) { return (stop.flags & kFieldBehind) != 0u; }

// Whether the field is drawn in front of the next stop.
bool is_in_span(Pixel pixel) {
  return pixel.next_stop > pixel.first_stop && is_field_behind(stops[pixel.next_stop - 1u]);
}

float next_depth(Pixel pixel) {
  return pixel.next_stop < pixel.end_stop ? stops[pixel.next_stop].depth : kEndlessDepth;
}

// Whether the span in hand begins, or ends, where somebody else draws on.
bool begins_at_seam(Pixel pixel) { return (stops[pixel.next_stop - 1u].flags & kSeam) != 0u; }
bool ends_at_seam(Pixel pixel) {
  return pixel.next_stop < pixel.end_stop && (stops[pixel.next_stop].flags & kSeam) != 0u;
}

// The next stop, which there is, joins the pixel.
void join_next_stop(inout Pixel pixel) {
  DepthStop stop = stops[pixel.next_stop];
  ++pixel.next_stop;
  if ((kMode != kComposite && kMode != kIsosurface) || pixel.is_closed) return;
  vec4 seen = vec4(stop.rgba[0], stop.rgba[1], stop.rgba[2], stop.rgba[3]);
  float before = pixel.color.a;
  pixel.color = fma(vec4(1.0 - before), seen, pixel.color);
  note_depth(pixel, before, stop.depth);
  if (pixel.color.a >= frame.view.opaque_at) pixel.is_closed = true;
}

void join_stops(inout Pixel pixel, float up_to_depth) {
  while (pixel.next_stop < pixel.end_stop && stops[pixel.next_stop].depth <= up_to_depth)
    join_next_stop(pixel);
}

// All that is drawn from now on is behind this depth.
void reach(inout Pixel pixel, float depth) {
  join_stops(pixel, depth);
  if (pixel.next_stop == pixel.end_stop && !is_in_span(pixel)) pixel.is_closed = true;
}

// Whether any span may meet the piece that ends on sheet s.
bool meets_span(inout Pixel pixel, float s) {
  if (!has_flag(kHasLimits)) return true;
  reach(pixel, depth_of_sheet(s - 1.0));
  return is_in_span(pixel) || next_depth(pixel) < depth_of_sheet(s);
}

// Whether a place is within a span.
bool is_within_span(inout Pixel pixel, float depth) {
  if (!has_flag(kHasLimits)) return true;
  reach(pixel, depth);
  return is_in_span(pixel) && !pixel.is_closed;
}

// What all spans leave of a sample's path, `path` being what planes do. A sample with a path comes
// behind the stops up to its sheet, though some of its path may lie before them. Of a surface it is
// the crossing that must be within a span, and samples have all of their path.
float path_within_spans(inout Pixel pixel, vec2 at, float s, float path) {
  if (!has_flag(kHasLimits) || kMode == kIsosurface) return path;
  vec2 slab = kept_part(at, s, vec2(-0.5, 0.5));
  float depth = depth_of_sheet(s);
  reach(pixel, depth - 0.5 * frame.view.sampling_distance);
  path = 0.0;
  float enter = slab.x;  // the span in hand began before the slab
  bool is_drawn = is_in_span(pixel);
  for (uint i = pixel.next_stop; enter < slab.y; ++i) {
    bool is_last = i == pixel.end_stop;
    float leave = is_last ? slab.y : (stops[i].depth - depth) / frame.view.sampling_distance;
    if (is_drawn) path += max(min(leave, slab.y) - enter, 0.0);
    if (is_last) break;
    enter = max(leave, slab.x);
    is_drawn = is_field_behind(stops[i]);
  }
  if (path > 0.0) join_stops(pixel, depth);
  return path;
}
