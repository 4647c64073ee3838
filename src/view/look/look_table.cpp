// SPDX-License-Identifier: Apache-2.0
// In: a transfer function. Out: the table, and two running counts that answer any_opacity() for a
// range of values in constant time. Everything that decides about zero goes through coordinate(),
// in float, as the reader of the table does: it rises with the value, so what holds for the two
// ends of a range of floats holds between them.
#include "view/look/look_table.h"

#include <cmath>
#include <limits>

#include "view/look/opacity_curve.h"
#include "view/look/value_scale.h"

namespace ovoid::view {
namespace {

// Entries lie this far (in cells) inside the outermost points, so that float rounding of a
// coordinate up to 4096 (2^-12 cells for the difference and the product) cannot put such a point on
// the wrong side of its entry.
constexpr double kMargin = 1.0 / 512;

// Keeps value - origin and value * scale of all floats finite or rightly infinite.
constexpr double kMaxValue = 1e38;
constexpr double kMinCell = 1e-36;

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// The greatest float <= x and the least float >= x.
float floor_to_float(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) > x ? std::nextafter(f, -kInfinity) : f;
}

float ceil_to_float(double x) {
  const auto f = static_cast<float>(x);
  return static_cast<double>(f) < x ? std::nextafter(f, kInfinity) : f;
}

// The greatest float < x and the least float > x.
float before(double x) {
  const float f = floor_to_float(x);
  return static_cast<double>(f) < x ? f : std::nextafter(f, -kInfinity);
}

float beyond(double x) {
  const float f = ceil_to_float(x);
  return static_cast<double>(f) > x ? f : std::nextafter(f, kInfinity);
}

// Where the piece of the curve between two points passes half of its change.
double middle_of(const TransferFunction& tf, const OpacityPoint& left, double right) {
  const double lo = along(tf.scale, tf.linear_width, left.x);
  const double hi = along(tf.scale, tf.linear_width, right);
  const double midpoint = std::clamp(left.midpoint, kMinMidpoint, kMaxMidpoint);
  return value_at(tf.scale, tf.linear_width, lo + midpoint * (hi - lo));
}

// What LookAxis::warped() approximates from below, of any double and with the fraction that an
// integer lacks.
double warped_position(const LookAxis& axis, double value) {
  const auto bits_of = [](double x) {
    int exponent = 0;
    const double mantissa = 2.0 * std::frexp(x, &exponent);  // in [1, 2)
    return (exponent - 1 + 127 + mantissa - 1.0) * 0x1p23;
  };
  if (axis.scale == ValueScale::kLog)
    return bits_of(std::max(value, static_cast<double>(LookAxis::kLeast)));
  return std::copysign(bits_of(1.0 + std::abs(value) * axis.inverse_width) - bits_of(1.0), value);
}

// Undoes warped_position().
double unwarped(const LookAxis& axis, double position) {
  const auto number_of = [](double bits) {
    const double octaves = bits * 0x1p-23;
    const double whole = std::floor(octaves);
    return std::ldexp(1.0 + (octaves - whole), static_cast<int>(whole) - 127);
  };
  if (axis.scale == ValueScale::kLog) return number_of(position);
  constexpr double kBitsOfOne = 127 * 0x1p23;
  return std::copysign((number_of(std::abs(position) + kBitsOfOne) - 1.0) / axis.inverse_width,
                       position);
}

struct Span {
  double lo, hi;
};

// The values that the table must tell apart (see the header, "Coverage").
Span covered(const TransferFunction& tf) {
  const auto& points = tf.opacities;
  Span all = tf.colors.empty() ? Span{0.0, 1.0} : Span{tf.colors.front().x, tf.colors.back().x};
  if (points.empty()) return all;
  all = {std::min(all.lo, points.front().x), std::max(all.hi, points.back().x)};

  const auto shows = [](const OpacityPoint& p) { return p.opacity > 0.0; };
  const auto first = std::find_if(points.begin(), points.end(), shows);
  const auto last = std::find_if(points.rbegin(), points.rend(), shows);
  if (first == points.end()) return all;
  return {first == points.begin() ? all.lo : first[-1].x,
          last == points.rbegin() ? all.hi : last.base()->x};
}

}  // namespace

LookTable::LookTable(const TransferFunction& tf) : tables_(std::make_unique<Tables>()) {
  place(tf);
  fill(tf);
  keep_steps(tf);
  keep_zeros(tf);
  count_opaque_entries();
  find_showing(tf);
}

double LookAxis::value_of_entry(double i) const noexcept {
  const double steps = i / static_cast<double>(cells_per_step);
  return scale == ValueScale::kLinear ? static_cast<double>(origin) + steps
                                      : unwarped(*this, origin_bits + steps);
}

void LookTable::place(const TransferFunction& tf) {
  auto [lo, hi] = covered(tf);
  lo = std::clamp(lo, -kMaxValue, kMaxValue);
  hi = std::clamp(hi, -kMaxValue, kMaxValue);
  axis_.scale = tf.scale;
  double least_cell = 1.0;  // of warped bits
  if (tf.scale == ValueScale::kLinear) {
    // A cell is at least one step of float at these values; more would not be told apart, and
    // origin would be lost in rounding.
    const double magnitude = std::max(std::abs(lo), std::abs(hi));
    const double float_step =
        magnitude > 0.0
            ? std::ldexp(1.0, std::ilogb(magnitude) + 1 - std::numeric_limits<float>::digits)
            : 0.0;
    least_cell = std::max(float_step, kMinCell);
  } else {
    axis_.inverse_width = static_cast<float>(std::clamp(1.0 / tf.linear_width, 1e-30, 1e30));
    lo = warped_position(axis_, lo);
    hi = warped_position(axis_, hi);
  }
  const double cell = std::max((hi - lo) / (kCells - 2 + 2 * kMargin), least_cell);
  const double first = lo - (1.0 - kMargin) * cell;
  if (tf.scale == ValueScale::kLinear) {
    axis_.origin = static_cast<float>(first);
  } else {
    axis_.origin_bits = static_cast<std::int32_t>(first);
  }
  axis_.cells_per_step = static_cast<float>(1.0 / cell);
}

void LookTable::fill(const TransferFunction& tf) {
  for (int i = 0; i < kEntries; ++i) {
    const double value = entry_value(i);
    const Rgb rgb = tf.color_at(value);
    tables_->r[i] = static_cast<float>(rgb[0]);
    tables_->g[i] = static_cast<float>(rgb[1]);
    tables_->b[i] = static_cast<float>(rgb[2]);
    tables_->opacity[i] = static_cast<float>(tf.opacity_at(value));
  }
  for (float* x : {tables_->r, tables_->g, tables_->b, tables_->opacity}) {
    std::fill(x + kEntries, x + kPaddedEntries, x[kCells]);
  }
}

// Makes the table change its side at `value`. The entries decide which cell that is, because they
// were read from one side or the other.
void LookTable::keep_step_at(double value) {
  int i = std::clamp(static_cast<int>(coordinate(static_cast<float>(value))), 0, kCells - 1);
  if (i > 0 && entry_value(i) >= value) --i;
  if (i + 1 < kCells && entry_value(i + 1) < value) ++i;
  const float t = coordinate(ceil_to_float(value)) - static_cast<float>(i);
  tables_->step[i] = std::clamp(t, 0.0F, 1.0F);
  has_steps_ = true;
}

void LookTable::keep_steps(const TransferFunction& tf) {
  std::fill_n(tables_->step, kPaddedEntries, -1.0F);
  const auto& colors = tf.colors;
  for (std::size_t k = 0; k + 1 < colors.size(); ++k) {
    if (tf.color_space == ColorSpace::kStep || colors[k].x == colors[k + 1].x)
      keep_step_at(colors[k].x);
  }
  if (tf.below_color && !colors.empty()) keep_step_at(colors.front().x);
  if (tf.above_color && !colors.empty())
    keep_step_at(std::nextafter(colors.back().x, std::numeric_limits<double>::infinity()));
  const auto& points = tf.opacities;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const double width = points[k + 1].x - points[k].x;
    if (width == 0.0) keep_step_at(points[k].x);
    if (width > 0.0 && points[k].sharpness > kStepSharpness)
      keep_step_at(middle_of(tf, points[k], points[k + 1].x));
  }
}

// Makes the table read zero at `value`, the last or first of a stretch of zeros.
void LookTable::keep_zero_at(float value) {
  const float t = coordinate(value);
  const int i = static_cast<int>(t);
  tables_->opacity[i] = 0.0F;
  if (t > static_cast<float>(i)) tables_->opacity[i + 1] = 0.0F;
}

void LookTable::keep_zeros(const TransferFunction& tf) {
  const auto& points = tf.opacities;
  const auto shows = [&](std::size_t k) { return points[k].opacity > 0.0; };
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (shows(k)) continue;
    const bool has_left = k > 0;
    const bool has_right = k + 1 < points.size();
    const bool rises = has_right && shows(k + 1) && points[k].x < points[k + 1].x &&
                       points[k].sharpness <= kStepSharpness;
    const bool falls = has_left && shows(k - 1) && points[k - 1].x < points[k].x &&
                       points[k - 1].sharpness <= kStepSharpness;
    if (rises && (!has_left || !shows(k - 1))) keep_zero_at(floor_to_float(points[k].x));
    if (falls && (!has_right || !shows(k + 1))) keep_zero_at(ceil_to_float(points[k].x));
  }
}

void LookTable::count_opaque_entries() {
  int count = 0;
  for (int i = 0; i < kEntries; ++i) {
    tables_->opaque_entries_before[i] = static_cast<std::int16_t>(count);
    if (tables_->opacity[i] > 0.0F) ++count;
  }
  tables_->opaque_entries_before[kEntries] = static_cast<std::int16_t>(count);
}

void LookTable::find_showing(const TransferFunction& tf) {
  const auto add = [this](float first, float last) {
    if (first > last) return;
    if (!showing_.empty() && first <= std::nextafter(showing_.back().last, kInfinity)) {
      showing_.back().last = std::max(showing_.back().last, last);
    } else {
      showing_.push_back({first, last});
    }
  };
  const auto& points = tf.opacities;
  if (points.empty()) {
    add(-kInfinity, kInfinity);
    max_opacity_ = 1.0F;
    return;
  }
  if (points.front().opacity > 0.0) add(-kInfinity, floor_to_float(points.front().x));
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const OpacityPoint& a = points[k];
    const OpacityPoint& b = points[k + 1];
    if (!(a.x < b.x) || !(a.opacity > 0.0 || b.opacity > 0.0)) continue;
    // Exactly where a step by sharpness lies is a matter of rounding: a float more on the safe
    // side.
    const bool is_step = a.sharpness > kStepSharpness;
    const double middle = middle_of(tf, a, b.x);
    add(a.opacity > 0.0 ? ceil_to_float(a.x)
        : is_step       ? before(middle)
                        : beyond(a.x),
        b.opacity > 0.0 ? floor_to_float(b.x)
        : is_step       ? beyond(middle)
                        : before(b.x));
  }
  if (points.back().opacity > 0.0) add(ceil_to_float(points.back().x), kInfinity);
  for (const OpacityPoint& p : points)
    max_opacity_ = std::max(max_opacity_, static_cast<float>(p.opacity));
}

bool LookTable::any_opacity(float lo, float hi) const noexcept {
  if (!(lo <= hi)) return false;
  const float t_lo = coordinate(lo);
  const float t_hi = coordinate(hi);
  // A piece, straight or a step, is zero between two zeros: the ends of the range and the entries
  // within it decide.
  if (read(tables_->opacity, t_lo) > 0.0F || read(tables_->opacity, t_hi) > 0.0F) return true;
  const std::int16_t* entries_before = tables_->opaque_entries_before;
  if (entries_before[static_cast<int>(t_hi) + 1] > entries_before[static_cast<int>(t_lo) + 1])
    return true;
  const auto reaches_lo = [](const Interval& i, float v) { return i.last < v; };
  const auto next = std::lower_bound(showing_.begin(), showing_.end(), lo, reaches_lo);
  return next != showing_.end() && next->first <= hi;
}

}  // namespace ovoid::view
