// SPDX-License-Identifier: Apache-2.0
// Stage "warp" of one strip of the picture.
//
// In:  the base plane's samples, red, green, blue and opacity side by side.
// Out: pixels. One that is no wider than a sample takes 4 x 4 of them. Places and weights are those
// of a group of pixels at once; then, pixel by pixel, four samples of a row are summed as one
// vector, whichever row they are of, and its four blocks are weighted at the end.
#if defined(OVOID_RENDER_CPU_WARP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_WARP_INL_H_
#undef OVOID_RENDER_CPU_WARP_INL_H_
#else
#define OVOID_RENDER_CPU_WARP_INL_H_
#endif

#include "render/cpu/lattice/warp.h"
#include "render/cpu/simd-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ovoid::cpu {
namespace HWY_NAMESPACE {

// Of the filter, in units of its width.
inline constexpr int kFilterReach = 2;

// [Mitchell 1988], B = C = 1/3; t >= 0. The weights of whole distances from any place add up to 1.
inline float filter_weight(float t) {
  const float inner = (7.0F / 6 * t - 2) * t * t + 8.0F / 9;
  const float outer = ((-7.0F / 18 * t + 2) * t - 10.0F / 3) * t + 16.0F / 9;
  return t < 1 ? inner : t < 2 ? outer : 0.0F;
}

// Where a pixel's centre lies in the base plane, and how many samples wide it is there, at least 1.
struct PlaceInBase {
  double x, y;
  float width_x, width_y;
};

// Of a step of one sample that is as long as the root of `squared` / `scale`, pixels.
inline float width_of_pixel(double squared, double scale) {
  const double wide = scale * scale;
  // Rounding makes no pixel wider than a sample.
  return wide < (1 + 1e-6) * squared ? 1.0F : static_cast<float>(std::sqrt(wide / squared));
}

// The pixels of a row.
class PlacesInBase {
 public:
  PlacesInBase(const view::BasePlane& base, int y)
      : base_(base),
        y_(y),
        column_(base.base_from_picture.matrix.col(0)),
        origin_(base.base_from_picture.matrix.col(1) * y + base.base_from_picture.matrix.col(2)),
        first_(at(0)) {}

  // In parallel projection all pixels are as wide.
  PlaceInBase operator[](int x) const {
    if (!base_.is_parallel) return at(x);
    const double scale = 1 / origin_[2];
    return {(origin_[0] + x * column_[0]) * scale, (origin_[1] + x * column_[1]) * scale,
            first_.width_x, first_.width_y};
  }

 private:
  PlaceInBase at(int x) const {
    // The maps are each other's inverse: what one scales a place by, the other undoes.
    const double scale = 1 / (origin_[2] + x * column_[2]);
    const Mat3& map = base_.picture_from_base.matrix;
    const auto width = [&](int a) {
      const double along = map(0, a) - x * map(2, a);
      const double down = map(1, a) - y_ * map(2, a);
      return width_of_pixel(along * along + down * down, scale);
    };
    return {(origin_[0] + x * column_[0]) * scale, (origin_[1] + x * column_[1]) * scale, width(0),
            width(1)};
  }

  const view::BasePlane& base_;
  const int y_;
  const Vec3 column_, origin_;
  const PlaceInBase first_;
};

HWY_INLINE V filter_weights(V t) {
  const auto polynomial = [&](float c3, float c2, float c1, float c0) {
    return hn::MulAdd(hn::MulAdd(hn::MulAdd(hn::Set(d, c3), t, hn::Set(d, c2)), t, hn::Set(d, c1)),
                      t, hn::Set(d, c0));
  };
  const V inner = polynomial(7.0F / 6, -2, 0, 8.0F / 9);
  const V outer = polynomial(-7.0F / 18, 2, -10.0F / 3, 16.0F / 9);
  return hn::IfThenElse(hn::Lt(t, hn::Set(d, 1.0F)), inner,
                        hn::IfThenElseZero(hn::Lt(t, hn::Set(d, 2.0F)), outer));
}

// Samples [first, last] of one axis and their weights, which add up to 1 over all that the filter
// reaches.
struct FilterSpan {
  int first = 0, last = -1;
  bool is_cut = false;  // some that the filter reaches do not exist
  const float* weights = nullptr;

  void set(double at, float width, int size) {
    const auto begin = static_cast<int>(std::ceil(at - kFilterReach * static_cast<double>(width)));
    const auto end = static_cast<int>(std::floor(at + kFilterReach * static_cast<double>(width)));
    first = std::max(begin, 0);
    last = std::min(end, size - 1);
    is_cut = first > begin || last < end;
    const int count = end - begin + 1;
    memory_.resize(static_cast<std::size_t>(count) + static_cast<std::size_t>(group_size()));
    const V inverse = hn::Set(d, 1 / width);
    const V nearest = hn::Set(d, static_cast<float>(begin - at));
    V sum = hn::Zero(d);
    for (int i = 0; i < count; i += group_size()) {
      const V distance = hn::Abs(hn::Add(hn::Iota(d, static_cast<float>(i)), nearest));
      const V w = filter_weights(hn::Mul(distance, inverse));  // 0 behind the last
      sum = hn::Add(sum, w);
      hn::StoreU(w, d, memory_.data() + i);
    }
    const V scale = hn::Div(hn::Set(d, 1.0F), hn::SumOfLanes(d, sum));
    for (int i = 0; i < count; i += group_size())
      hn::StoreU(hn::Mul(hn::LoadU(d, memory_.data() + i), scale), d, memory_.data() + i);
    weights = memory_.data() + (first - begin);
  }
  bool is_empty() const { return last < first; }

 private:
  std::vector<float> memory_;
};

struct Rgba {
  alignas(16) float v[4] = {};
};

// A weighted mean, and the least and the greatest of what it is of: the filter has negative
// weights, but pixels stay between their samples.
struct Mean {
  Rgba value, least, greatest;

  Rgba bounded() const {
    Rgba out;
    for (int c = 0; c < 4; ++c)
      out.v[c] = std::min(std::max(value.v[c], least.v[c]), greatest.v[c]);
    return out;
  }
};

// Any width, anywhere.
inline Rgba mean_of_span(const Image& samples, const FilterSpan& x, const FilterSpan& y) {
  Mean mean;
  const auto samples_at = [&](int j) {
    return samples.rgba.data() + 4 * (static_cast<std::size_t>(j) * samples.width + x.first);
  };
#if HWY_TARGET == HWY_SCALAR
  const float* const any = samples_at(y.first);
  for (int c = 0; c < 4; ++c) mean.least.v[c] = mean.greatest.v[c] = any[c];
  for (int j = y.first; j <= y.last; ++j) {
    const float* from = samples_at(j);
    for (int i = x.first; i <= x.last; ++i, from += 4) {
      const float weight = x.weights[i - x.first] * y.weights[j - y.first];
      for (int c = 0; c < 4; ++c) {
        mean.value.v[c] += weight * from[c];
        mean.least.v[c] = std::min(mean.least.v[c], from[c]);
        mean.greatest.v[c] = std::max(mean.greatest.v[c], from[c]);
      }
    }
  }
#else
  const hn::FixedTag<float, 4> four;
  auto total = hn::Zero(four);
  auto least = hn::LoadU(four, samples_at(y.first));
  auto greatest = least;
  for (int j = y.first; j <= y.last; ++j) {
    const float* from = samples_at(j);
    auto row = hn::Zero(four);
    for (int i = x.first; i <= x.last; ++i, from += 4) {
      const auto sample = hn::LoadU(four, from);
      row = hn::MulAdd(sample, hn::Set(four, x.weights[i - x.first]), row);
      least = hn::Min(least, sample);
      greatest = hn::Max(greatest, sample);
    }
    total = hn::MulAdd(row, hn::Set(four, y.weights[j - y.first]), total);
  }
  hn::Store(total, four, mean.value.v);
  hn::Store(least, four, mean.least.v);
  hn::Store(greatest, four, mean.greatest.v);
#endif
  if (x.is_cut || y.is_cut) {  // nothing is there
    for (int c = 0; c < 4; ++c) {
      mean.least.v[c] = std::min(mean.least.v[c], 0.0F);
      mean.greatest.v[c] = std::max(mean.greatest.v[c], 0.0F);
    }
  }
  return mean.bounded();
}

// Where a group of pixels of a row lie: in a box of whole samples, whose corner is (corner_x,
// corner_y), and how far from the corner.
struct PixelPlaces {
  static constexpr int kPixels = 16;

  int corner_x, corner_y;
  alignas(64) float x[kPixels], y[kPixels];
  bool are_narrow;  // than samples
};

// Pixels from x on.
inline PixelPlaces places_of(const PlacesInBase& row, int x) {
  PixelPlaces places;
  PlaceInBase at[PixelPlaces::kPixels];
  for (int i = 0; i < PixelPlaces::kPixels; ++i) at[i] = row[x + i];
  double least_x = at[0].x;
  double least_y = at[0].y;
  places.are_narrow = true;
  for (const PlaceInBase& place : at) {
    least_x = std::min(least_x, place.x);
    least_y = std::min(least_y, place.y);
    places.are_narrow &= place.width_x == 1.0F && place.width_y == 1.0F;
  }
  // Far away is as good as any place out there.
  constexpr double kFar = 1 << 20;
  places.corner_x = static_cast<int>(std::floor(std::clamp(least_x, -kFar, kFar)));
  places.corner_y = static_cast<int>(std::floor(std::clamp(least_y, -kFar, kFar)));
  for (int i = 0; i < PixelPlaces::kPixels; ++i) {
    places.x[i] = static_cast<float>(at[i].x - places.corner_x);
    places.y[i] = static_cast<float>(at[i].y - places.corner_y);
  }
  return places;
}

// The samples around a group of pixels that are no wider than samples: 4 x 4 of each, from its
// first on, and their weights.
struct PixelTaps {
  static constexpr int kPixels = PixelPlaces::kPixels;

  alignas(64) std::int32_t first_x[kPixels], first_y[kPixels];  // from the corner
  alignas(64) float weight_x[kPixels][4];
  alignas(64) float weight_y[4][kPixels];
};

inline void set_taps_of_pixels(const PixelPlaces& places, PixelTaps& taps) {
  const auto weigh = [](const float* from, std::int32_t* first, V(&w)[4]) {
    const V at = hn::Load(d, from);
    const V whole = hn::Floor(at);
    const V fraction = hn::Sub(at, whole);
    hn::Store(hn::Sub(nearest_integer(whole), hn::Set(di, 1)), di, first);
    const V one = hn::Set(d, 1.0F);
    w[0] = filter_weights(hn::Add(one, fraction));
    w[1] = filter_weights(fraction);
    w[2] = filter_weights(hn::Sub(one, fraction));
    w[3] = filter_weights(hn::Sub(hn::Set(d, 2.0F), fraction));
  };
  for (int i = 0; i < PixelTaps::kPixels; i += group_size()) {
    V w[4];
    weigh(places.x + i, taps.first_x + i, w);
#if HWY_TARGET == HWY_SCALAR
    for (int k = 0; k < 4; ++k) hn::Store(w[k], d, &taps.weight_x[i][k]);
#else
    hn::StoreInterleaved4(w[0], w[1], w[2], w[3], d, &taps.weight_x[i][0]);
#endif
    weigh(places.y + i, taps.first_y + i, w);
    for (int k = 0; k < 4; ++k) hn::Store(w[k], d, taps.weight_y[k] + i);
  }
}

#if HWY_TARGET == HWY_SCALAR
// Of 4 x 4 samples from `from` on, all of which exist.
inline void mean_of_sixteen(const float* from, std::ptrdiff_t row, const PixelTaps& taps, int i,
                            float* out) {
  Mean mean;
  std::copy_n(from, 4, mean.least.v);
  std::copy_n(from, 4, mean.greatest.v);
  for (int b = 0; b < 4; ++b) {
    for (int a = 0; a < 4; ++a) {
      const float weight = taps.weight_x[i][a] * taps.weight_y[b][i];
      for (int c = 0; c < 4; ++c) {
        const float sample = from[b * row + 4 * a + c];
        mean.value.v[c] += weight * sample;
        mean.least.v[c] = std::min(mean.least.v[c], sample);
        mean.greatest.v[c] = std::max(mean.greatest.v[c], sample);
      }
    }
  }
  std::copy_n(mean.bounded().v, 4, out);
}
#else
using D4 = hn::FixedTag<float, 4>;
using V4 = hn::Vec<D4>;
inline constexpr D4 d4;

// The blocks of four numbers of a vector, taken together.
template <class Op>
HWY_INLINE V4 fold_blocks(V v, const Op& op) {
#if HWY_MAX_BYTES >= 64
  const hn::FixedTag<float, 8> d8;
  const auto half = op(hn::LowerHalf(d8, v), hn::UpperHalf(d8, v));
  return op(hn::LowerHalf(d4, half), hn::UpperHalf(d4, half));
#elif HWY_MAX_BYTES >= 32
  return op(hn::LowerHalf(d4, v), hn::UpperHalf(d4, v));
#else
  (void)op;
  return v;
#endif
}

// Of 4 x 4 samples from `from` on, all of which exist, the mean of pixel i, between the least and
// the greatest of them.
HWY_INLINE void mean_of_sixteen(const float* from, std::ptrdiff_t row, const PixelTaps& taps, int i,
                                float* out) {
  const auto add = [](auto a, auto b) { return hn::Add(a, b); };
  const auto lesser = [](auto a, auto b) { return hn::Min(a, b); };
  const auto greater = [](auto a, auto b) { return hn::Max(a, b); };
  const V of_columns = hn::LoadDup128(d, taps.weight_x[i]);
  const VI sample_of_lane = hn::ShiftRight<2>(hn::Iota(di, 0));
  V sum = hn::Zero(d);
  V least = hn::LoadU(d, from);
  V greatest = least;
  for (int x = 0; x < 16; x += group_size()) {
    V of_rows = hn::Zero(d);
    for (int j = 0; j < 4; ++j) {
      const V samples = hn::LoadU(d, from + j * row + x);
      of_rows = hn::MulAdd(samples, hn::Set(d, taps.weight_y[j][i]), of_rows);
      least = hn::Min(least, samples);
      greatest = hn::Max(greatest, samples);
    }
    const VI sample = hn::Add(sample_of_lane, hn::Set(di, x / 4));
    const V weights = hn::TableLookupLanes(of_columns, hn::IndicesFromVec(d, sample));
    sum = hn::MulAdd(of_rows, weights, sum);
  }
  const V4 mean = fold_blocks(sum, add);
  const V4 lo = fold_blocks(least, lesser);
  const V4 hi = fold_blocks(greatest, greater);
  hn::StoreU(hn::Min(hn::Max(mean, lo), hi), d4, out);
}
#endif

// True if one of the samples from (x0, y0) to (x1, y1) may hold something.
inline bool holds_something(const BasePicture& samples, int x0, int y0, int x1, int y1) {
  for (int y = y0;; y = std::min(y + kSpotSize, y1)) {
    for (int x = x0;; x = std::min(x + kSpotSize, x1)) {
      if (samples.holds_something(x, y)) return true;
      if (x == x1) break;
    }
    if (y == y1) return false;
  }
}

// A pixel anywhere, of any width.
class AnyPixel {
 public:
  explicit AnyPixel(const WarpJob& job) : job_(job) {}

  void set(const PlaceInBase& at, float* rgba) {
    const view::BasePlane& base = job_.base;
    const double reach_x = kFilterReach * static_cast<double>(at.width_x);
    const double reach_y = kFilterReach * static_cast<double>(at.width_y);
    if (!(at.x > -reach_x && at.y > -reach_y && at.x < base.width - 1 + reach_x &&
          at.y < base.height - 1 + reach_y))
      return;
    x_.set(at.x, at.width_x, base.width);
    y_.set(at.y, at.width_y, base.height);
    if (x_.is_empty() || y_.is_empty() ||
        !holds_something(job_.samples, x_.first, y_.first, x_.last, y_.last))
      return;
    const Rgba color = mean_of_span(job_.samples.image, x_, y_);
    std::copy_n(color.v, 4, rgba);
  }

 private:
  const WarpJob& job_;
  FilterSpan x_, y_;
};

inline constexpr float kNoPlace = std::numeric_limits<float>::infinity();  // a depth

// The depth of a sample's place, of those that samples have.
HWY_INLINE float depth_of_sample(const WarpJob& job, int i, int j,
                                 const std::vector<float>& depths) {
  const float z = depths[static_cast<std::size_t>(j) * job.base.width + i];
  return static_cast<float>(job.base.depth_of(i, j, z));
}

// The least front depth of the samples that a pixel takes.
inline float least_front_depth(const WarpJob& job, const PlaceInBase& at) {
  const auto span_of = [](double middle, float width, int size) {
    const double reach = kFilterReach * static_cast<double>(width);
    return std::pair(static_cast<int>(std::max(std::ceil(middle - reach), 0.0)),
                     static_cast<int>(std::min(std::floor(middle + reach), size - 1.0)));
  };
  const auto [x0, x1] = span_of(at.x, at.width_x, job.base.width);
  const auto [y0, y1] = span_of(at.y, at.width_y, job.base.height);
  float least = kNoPlace;
  for (int j = y0; j <= y1; ++j) {
    for (int i = x0; i <= x1; ++i)
      least = std::min(least, depth_of_sample(job, i, j, job.samples.image.front_depth));
  }
  return least;
}

// The depths of a pixel whose colour is there: those of the nearest sample. Where it is seen and
// that one is not, others of its samples are.
HWY_INLINE void set_depths(const WarpJob& job, const PlaceInBase& at, std::size_t pixel,
                           Image& picture) {
  const auto i = static_cast<int>(std::floor(at.x + 0.5));
  const auto j = static_cast<int>(std::floor(at.y + 0.5));
  const bool exists = i >= 0 && j >= 0 && i < job.base.width && j < job.base.height;
  const Image& samples = job.samples.image;
  picture.depth[pixel] = exists ? depth_of_sample(job, i, j, samples.depth) : kNoPlace;
  float front = kNoPlace;
  if (picture.rgba[4 * pixel + 3] >= kLeastVisibleOpacity) {
    if (exists) front = depth_of_sample(job, i, j, samples.front_depth);
    if (front == kNoPlace) front = least_front_depth(job, at);
  }
  picture.front_depth[pixel] = front;
}

// A group's pixels, whose samples all exist. `first`: its first pixel.
inline void warp_group(const WarpJob& job, const PixelPlaces& places, int count, std::size_t first,
                       Image& picture) {
  PixelTaps taps;
  set_taps_of_pixels(places, taps);
  const Image& samples = job.samples.image;
  const std::ptrdiff_t row = 4 * static_cast<std::ptrdiff_t>(samples.width);
  const float* const corner = samples.rgba.data() + places.corner_y * row +
                              static_cast<std::ptrdiff_t>(4) * places.corner_x;
  for (int i = 0; i < count; ++i) {
    const std::size_t pixel = first + static_cast<std::size_t>(i);
    mean_of_sixteen(
        corner + taps.first_y[i] * row + static_cast<std::ptrdiff_t>(4) * taps.first_x[i], row,
        taps, i, picture.rgba.data() + 4 * pixel);
    set_depths(job,
               {places.corner_x + static_cast<double>(places.x[i]),
                places.corner_y + static_cast<double>(places.y[i]), 1.0F, 1.0F},
               pixel, picture);
  }
}

inline void warp_on_target(const WarpJob& job, const TileRect& strip, Image& picture) {
  const view::BasePlane& base = job.base;
  AnyPixel any(job);
  for (int y = strip.y0; y < strip.y1; ++y) {
    const PlacesInBase row(base, y);
    for (int x = strip.x0; x < strip.x1; x += PixelPlaces::kPixels) {
      const int count = std::min(PixelPlaces::kPixels, strip.x1 - x);
      const std::size_t first = static_cast<std::size_t>(y) * picture.width + x;
      const PixelPlaces places = places_of(row, x);
      const float* const right = std::max_element(places.x, places.x + PixelPlaces::kPixels);
      const float* const below = std::max_element(places.y, places.y + PixelPlaces::kPixels);
      // Of all samples that narrow pixels take.
      const auto end = [](int corner, float most) {
        return static_cast<double>(corner) + std::floor(static_cast<double>(most)) + 2;
      };
      const bool exist = places.corner_x >= 1 && places.corner_y >= 1 &&
                         end(places.corner_x, *right) < base.width &&
                         end(places.corner_y, *below) < base.height;
      if (exist && places.are_narrow) {
        if (holds_something(job.samples, places.corner_x - 1, places.corner_y - 1,
                            static_cast<int>(end(places.corner_x, *right)),
                            static_cast<int>(end(places.corner_y, *below))))
          warp_group(job, places, count, first, picture);
        continue;
      }
      for (int i = 0; i < count; ++i) {
        const PlaceInBase at = row[x + i];
        const std::size_t pixel = first + static_cast<std::size_t>(i);
        any.set(at, picture.rgba.data() + 4 * pixel);
        set_depths(job, at, pixel, picture);
      }
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
