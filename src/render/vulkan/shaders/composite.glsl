// SPDX-License-Identifier: Apache-2.0
// Stage "composite": samples join their pixel front to back; one that has become opaque is closed.

const vec2 kDepthOpacities = vec2(0.5, kLeastVisibleOpacity);

struct Pixel {
  vec4 color;  // premultiplied
  vec2 depths;  // where opacity reaches 1/2, and kLeastVisibleOpacity
  float best;
  float path;
  float before;      // value on the sheet before,
  int before_sheet;  // and which sheet that is; -1: none
  uint first_stop;   // of depth limits, as PixelStops
  uint end_stop;
  uint next_stop;
  bool is_seen;
  bool is_closed;
};

// Whether `before` is of the sheet before s. No sheet is before the first one.
bool has_before(Pixel pixel, float s) { return s > 0.0 && pixel.before_sheet == int(s) - 1; }

Pixel load_pixel(uint at) {
  PixelState state = states[at];
  Pixel pixel;
  pixel.color = colors[at];
  pixel.depths = depths[at];
  pixel.best = state.best;
  pixel.path = state.path;
  pixel.before = state.before;
  pixel.before_sheet = int(state.flags >> 2) - 1;
  pixel.is_seen = (state.flags & kSeen) != 0u;
  pixel.is_closed = (state.flags & kClosed) != 0u;
  pixel.first_stop = pixel.end_stop = pixel.next_stop = 0u;
  if (has_flag(kHasLimits)) {
    PixelStops of_pixel = pixel_stops[at];
    pixel.first_stop = of_pixel.first;
    pixel.end_stop = of_pixel.end;
    pixel.next_stop = of_pixel.next;
    if (of_pixel.first == of_pixel.end) pixel.is_closed = true;  // nothing is ever drawn here
  }
  return pixel;
}

void store_pixel(uint at, Pixel pixel) {
  colors[at] = pixel.color;
  depths[at] = pixel.depths;
  states[at] = PixelState(pixel.best, pixel.path, pixel.before,
                          uint(pixel.before_sheet + 1) << 2 | (pixel.is_seen ? kSeen : 0u) |
                              (pixel.is_closed ? kClosed : 0u));
  if (has_flag(kHasLimits)) pixel_stops[at].next = pixel.next_stop;
}

// What joins a pixel at a depth takes its opacity on from `before`.
void note_depth(inout Pixel pixel, float before, float depth) {
  bvec2 is_reached = greaterThanEqual(vec2(pixel.color.a), kDepthOpacities);
  bvec2 is_new = lessThan(vec2(before), kDepthOpacities);
  if (is_reached.x && is_new.x) pixel.depths.x = depth;
  if (is_reached.y && is_new.y) pixel.depths.y = depth;
}

// A sample of that colour and opacity.
void composite(inout Pixel pixel, vec3 color, float opacity, float depth) {
  if (pixel.is_closed) return;  // nothing is added behind what is opaque
  float before = pixel.color.a;
  float share = (1.0 - before) * opacity;
  float after = before + share;
  pixel.color.rgb = fma(vec3(share), color, pixel.color.rgb);
  pixel.color.a = after;
  note_depth(pixel, before, depth);
  if (after >= frame.view.opaque_at) pixel.is_closed = true;
}

// An opaque surface, whatever is in front of it.
void composite_surface(inout Pixel pixel, vec3 color, float depth) {
  if (pixel.is_closed) return;
  float in_front = pixel.color.a;
  pixel.color.rgb = fma(vec3(1.0 - in_front), color, pixel.color.rgb);
  pixel.color.a = 1.0;
  note_depth(pixel, in_front, depth);
  pixel.is_closed = true;
}

// X-ray, maximum, minimum and mean: every defined sample counts. Whether what they show is seen is known
// when all of it is there (Pixels::finish).
void accumulate(inout Pixel pixel, float value, float path, float depth) {
  if (kMode == kMaximum || kMode == kMinimum) {
    bool is_better = kMode == kMaximum ? value > pixel.best : value < pixel.best;
    if (!pixel.is_seen || is_better) {
      pixel.best = value;
      pixel.depths.x = depth;
    }
  } else {
    pixel.best = fma(value, path, pixel.best);
    pixel.path += path;
    if (!pixel.is_seen) pixel.depths.x = depth;
  }
  pixel.is_seen = true;
}
