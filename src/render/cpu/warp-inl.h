// SPDX-License-Identifier: Apache-2.0
// Stage "warp" of one strip of the picture.
//
// In:  the base plane's samples, red, green, blue and opacity side by side.
// Out: pixels. One that is no wider than a sample takes 4 x 4 of them: four samples of a row are
// summed as one vector, whichever row they are of, and its four blocks are weighted at the end.
#if defined(OVOID_RENDER_CPU_WARP_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef OVOID_RENDER_CPU_WARP_INL_H_
#undef OVOID_RENDER_CPU_WARP_INL_H_
#else
#define OVOID_RENDER_CPU_WARP_INL_H_
#endif

#include "render/cpu/simd-inl.h"
#include "render/cpu/warp.h"

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

// Of a step of one sample that is `per_sample` / `scale` pixels long.
inline float width_of_pixel(const Eigen::Vector2d& per_sample, double scale) {
  const double wide = scale * scale / per_sample.squaredNorm();
  // Rounding makes no pixel wider than a sample.
  return wide < 1 + 1e-6 ? 1.0F : static_cast<float>(std::sqrt(wide));
}

inline PlaceInBase place_in_base(const view::BasePlane& base, int x, int y) {
  const Eigen::Vector2d at = base.base_from_picture(x, y);
  const Mat3& map = base.picture_from_base.matrix;
  const double scale = map(2, 0) * at[0] + map(2, 1) * at[1] + map(2, 2);
  const auto width = [&](int a) {
    return width_of_pixel({map(0, a) - x * map(2, a), map(1, a) - y * map(2, a)}, scale);
  };
  return {at[0], at[1], width(0), width(1)};
}

// The pixels of a row. In parallel projection the steps between them are all the same.
class PlacesInBase {
 public:
  PlacesInBase(const view::BasePlane& base, int y)
      : base_(base), y_(y), first_(place_in_base(base, 0, y)) {
    if (!base.is_parallel) return;
    const Mat3& map = base.base_from_picture.matrix;
    step_x_ = map(0, 0) / map(2, 2);
    step_y_ = map(1, 0) / map(2, 2);
  }

  PlaceInBase operator[](int x) const {
    if (!base_.is_parallel) return place_in_base(base_, x, y_);
    return {first_.x + x * step_x_, first_.y + x * step_y_, first_.width_x, first_.width_y};
  }

 private:
  const view::BasePlane& base_;
  const int y_;
  const PlaceInBase first_;
  double step_x_ = 0;
  double step_y_ = 0;
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

// The four weights of samples floor(at) - 1 and following, of a filter of width 1.
HWY_INLINE void four_filter_weights(float fraction, float* weights) {
  weights[0] = filter_weight(1 + fraction);
  weights[1] = filter_weight(fraction);
  weights[2] = filter_weight(1 - fraction);
  weights[3] = filter_weight(2 - fraction);
}

// Of 4 x 4 samples from `from` on, all of which exist.
HWY_INLINE Rgba mean_of_sixteen(const float* from, std::ptrdiff_t row, float x, float y) {
  float own[4];
  float of_row[4];
  four_filter_weights(x, own);
  four_filter_weights(y, of_row);
  alignas(64) float weights[16];
  for (int i = 0; i < 16; ++i) weights[i] = own[i / 4];
  alignas(64) float sums[16], least[16], greatest[16];
  for (int i = 0; i < 16; i += group_size()) {
    const V first = hn::LoadU(d, from + i);
    V sum = hn::Mul(first, hn::Set(d, of_row[0]));
    V lo = first;
    V hi = first;
    for (int j = 1; j < 4; ++j) {
      const V sample = hn::LoadU(d, from + j * row + i);
      sum = hn::MulAdd(sample, hn::Set(d, of_row[j]), sum);
      lo = hn::Min(lo, sample);
      hi = hn::Max(hi, sample);
    }
    hn::Store(hn::Mul(sum, hn::Load(d, weights + i)), d, sums + i);
    hn::Store(lo, d, least + i);
    hn::Store(hi, d, greatest + i);
  }
  Mean mean;
  for (int c = 0; c < 4; ++c) {
    mean.value.v[c] = sums[c] + sums[c + 4] + sums[c + 8] + sums[c + 12];
    mean.least.v[c] =
        std::min(std::min(least[c], least[c + 4]), std::min(least[c + 8], least[c + 12]));
    mean.greatest.v[c] = std::max(std::max(greatest[c], greatest[c + 4]),
                                  std::max(greatest[c + 8], greatest[c + 12]));
  }
  return mean.bounded();
}

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

inline void warp_on_target(const WarpJob& job, const TileRect& strip, Image& picture) {
  const view::BasePlane& base = job.base;
  const Image& samples = job.samples.image;
  const std::ptrdiff_t row = 4 * static_cast<std::ptrdiff_t>(samples.width);
  FilterSpan span_x;
  FilterSpan span_y;
  for (int y = strip.y0; y < strip.y1; ++y) {
    const PlacesInBase places(base, y);
    for (int x = strip.x0; x < strip.x1; ++x) {
      const PlaceInBase at = places[x];
      const double reach_x = kFilterReach * static_cast<double>(at.width_x);
      const double reach_y = kFilterReach * static_cast<double>(at.width_y);
      if (!(at.x > -reach_x && at.y > -reach_y && at.x < base.width - 1 + reach_x &&
            at.y < base.height - 1 + reach_y))
        continue;
      const auto x0 = static_cast<int>(std::floor(at.x));
      const auto y0 = static_cast<int>(std::floor(at.y));
      const bool takes_sixteen = at.width_x == 1.0F && at.width_y == 1.0F && x0 >= 1 && y0 >= 1 &&
                                 x0 + 2 < base.width && y0 + 2 < base.height;
      Rgba color;
      if (takes_sixteen) {
        if (!holds_something(job.samples, x0 - 1, y0 - 1, x0 + 2, y0 + 2)) continue;
        color = mean_of_sixteen(samples.rgba.data() + (y0 - 1) * row + 4 * (x0 - 1), row,
                                static_cast<float>(at.x - x0), static_cast<float>(at.y - y0));
      } else {
        span_x.set(at.x, at.width_x, base.width);
        span_y.set(at.y, at.width_y, base.height);
        if (span_x.is_empty() || span_y.is_empty() ||
            !holds_something(job.samples, span_x.first, span_y.first, span_x.last, span_y.last))
          continue;
        color = mean_of_span(samples, span_x, span_y);
      }
      const std::size_t pixel = static_cast<std::size_t>(y) * picture.width + x;
      std::copy_n(color.v, 4, picture.rgba.data() + 4 * pixel);
      const auto i = static_cast<int>(std::round(at.x));
      const auto j = static_cast<int>(std::round(at.y));
      if (i < 0 || j < 0 || i >= base.width || j >= base.height) continue;
      const float z = samples.depth[static_cast<std::size_t>(j) * base.width + i];
      picture.depth[pixel] = static_cast<float>(base.depth_of(i, j, z));
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ovoid::cpu
HWY_AFTER_NAMESPACE();

#endif
