// SPDX-License-Identifier: Apache-2.0
// Explicit kernels: balls and ellipsoids with a centre, a shape, a weight and up to four values.
// docs/numerics.md, "Kernel sets", is the definition.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <ranges>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "ovoid/export.h"
#include "ovoid/kernels.h"
#include "ovoid/math.h"

namespace OVOID_API ovoid {

inline constexpr int kMaxAttributes = 4;

// What distinguishes one kernel's shape from another's.
enum class KernelShape {
  kBalls,       // one number: sigma, world units
  kEllipsoids,  // six: the lower triangle L of the covariance S = L L^T, row by row (xx, yx, yy,
                // zx, zy, zz), world units. A factor keeps its digits where a flat ellipsoid's
                // covariance would lose them.
};

inline int num_shape_numbers(KernelShape shape) noexcept {
  return shape == KernelShape::kBalls ? 1 : 6;
}

// phi as a function of the Mahalanobis distance m = |L^-1 (x - c)|; 0 for m > cutoff, where the
// value and, but for Epanechnikov's, the slope reach 0. All but the Gaussian are functions of t = m
// / cutoff alone.
enum class KernelProfile {
  kGaussian,      // exp(-m^2 / 2) less its tangent over m^2 at the cut-off
  kCubicSpline,   // SPH's M4 with support 2h, t = r / 2h
  kWendlandC2,    // (1 - t)^4 (1 + 4 t)
  kEpanechnikov,  // 1 - t^2
};

const char* name_of(KernelProfile profile) noexcept;  // "gaussian", "cubic-spline", ...

// The profile's value at Mahalanobis distance `m`, and the integral of phi over a kernel of unit
// covariance (multiply by det L).
double profile_value(KernelProfile profile, double m, double cutoff) noexcept;
double profile_integral(KernelProfile profile, double cutoff) noexcept;

// One attribute of a kernel set.
struct KernelAttribute {
  std::string name;
  std::string unit;  // empty if unknown
  ValueRange range;  // of the kernels' values
};

// A few kernels that are near each other and of similar size. Positions are float offsets from the
// brick's own double origin; a brick is so small, compared with its kernels, that the offsets'
// rounding is under kMaxOffsetError of the smallest sigma in it, unless it holds one kernel alone.
struct KernelBrick {
  Vec3 origin = Vec3::Zero();  // world
  Bounds3 support;             // world: box around the supports (radius `cutoff`) of its kernels
  Bounds3 cells;               // world: box around its kernels of one sigma
  float least_sigma = 0;       // the smallest semi-axis of any kernel in it, world units
  float greatest_sigma = 0;    // the largest
  std::int32_t count = 0;      // kernels, 1 to kMaxBrickKernels
  std::array<ValueRange, kMaxAttributes> ranges;  // of each attribute's values

  static constexpr int kMaxBrickKernels = 256;
  static constexpr double kMaxOffsetError = 1e-3;
};

// The kernels of one brick, as columns of `count` floats.
struct KernelView {
  std::int32_t count = 0;
  std::array<const float*, 3> center{};  // offset from the brick's origin, world units
  std::array<const float*, 6> shape{};   // num_shape_numbers() columns; or null: `shared_shape`
  const float* weight = nullptr;         // or null: `shared_weight` for all
  std::array<const float*, kMaxAttributes> value{};  // num_attributes columns
  std::array<float, 6> shared_shape{};
  float shared_weight = 1;
  std::shared_ptr<const void> pin;  // keeps the columns valid while the view lives; may be empty
};

// Where a kernel field gets its kernels: in memory, out of core, varying in time or kept by another
// process. Implementations are immutable and all members are called from many threads at once.
class KernelSource {
 public:
  virtual ~KernelSource() = default;

  virtual KernelShape shape() const noexcept = 0;
  virtual KernelProfile profile() const noexcept = 0;
  virtual double cutoff() const noexcept = 0;  // sigmas: support is m <= cutoff
  virtual std::span<const KernelAttribute> attributes() const noexcept = 0;  // 1 to kMaxAttributes
  virtual std::int64_t num_kernels() const noexcept = 0;
  virtual std::int64_t num_bricks() const noexcept = 0;
  virtual const KernelBrick& brick(std::int64_t index) const noexcept = 0;
  // The kernels of one brick at a time (ignored by data without time). Throws Error.
  virtual KernelView acquire(std::int64_t index, double time) const = 0;
  virtual std::size_t resident_bytes() const noexcept = 0;
  // Every `stride`-th kernel alone, counted from the first brick on, for sources that bring these
  // more cheaply than all: those of a brick together, whose header they have but for their count;
  // bricks without any are left out. Null: acquire() is as cheap. Throws Error.
  virtual std::shared_ptr<const KernelSource> every(std::int64_t stride) const;
};

// What stays where it is when a span of it has been made: a temporary does not.
template <typename Range, typename T>
concept BorrowableAs = std::convertible_to<Range, std::span<const T>> &&
    (std::is_lvalue_reference_v<Range> || std::ranges::borrowed_range<Range>);

// Values that are somebody else's and stay where they are. Made of anything in one piece that has a
// name; a temporary, which would be gone before the values are used, does not compile.
template <typename T>
class BorrowedValues : public std::span<const T> {
 public:
  BorrowedValues() = default;
  template <BorrowableAs<T> Range>  // implicit, as a span's is
  // NOLINTNEXTLINE(google-explicit-constructor,bugprone-forwarding-reference-overload)
  BorrowedValues(Range&& range) : std::span<const T>(std::forward<Range>(range)) {}
};

// What make_kernel_source() sorts into bricks. All values are borrowed for the call.
struct KernelColumns {
  KernelShape shape = KernelShape::kBalls;
  KernelProfile profile = KernelProfile::kGaussian;
  double cutoff = 4.0;             // sigmas, in [1, kMaxCutoff]
  BorrowedValues<double> centers;  // [num_kernels, 3] x y z, world units, finite
  BorrowedValues<float> shapes;    // [num_kernels, 1 or 6] as KernelShape says, or one for all
  BorrowedValues<float> weights;   // [num_kernels] > 0; or one for all
  std::vector<BorrowedValues<float>> values;  // one [num_kernels] per attribute, finite
  std::vector<KernelAttribute> attributes;    // as many; `range` is ignored
  // As many, or none: of values that kernels here stand for; the set's ranges hold them, too.
  std::vector<ValueRange> ranges;

  static constexpr double kMaxCutoff = 16.0;
};

// Kernels in memory, in bricks along a Morton curve, those of similar size together. At most 24
// bytes per ball and 48 per ellipsoid with one attribute, beside the bricks (about a byte per
// kernel unless kernels are far apart compared with their size). Throws Error(kInvalidArgument)
// that names column and index: no kernels, wrong lengths, centres or values that are not finite,
// sigmas or weights that are not positive, a factor whose diagonal is not positive. Cost: a sort;
// peak memory twice the result.
std::shared_ptr<const KernelSource> make_kernel_source(const KernelColumns& columns,
                                                       int threads = 0);

// A summed field at the centres of every `stride`-th of its kernels, counted from the first brick
// on: what its range and looks are made of.
struct KernelSums {
  std::int64_t stride = 1;
  std::vector<float> values;
};

// What is drawn of a kernel source: which attribute gives opacity and surfaces, which one colour,
// and how kernels are summed. The colour's value is a mean in both cases: sum w c phi / sum w phi,
// and of a sum, weighted by what is summed, sum w v c phi / sum w v phi. A value type: copies share
// the data. Equal (id, version) means equal data.
class KernelField {
 public:
  // An empty field: no kernels, empty bounds and ranges. source() is not to be called on it, and
  // functions that take a field refuse it, Error(kInvalidArgument).
  KernelField() = default;
  // Attributes by index; `color_attribute` -1: the same. Throws Error(kInvalidArgument).
  KernelField(std::shared_ptr<const KernelSource> source, Reconstruction reconstruction,
              int attribute = 0, int color_attribute = -1);
  // A sum, of which the values at the kernels are known, one for each `stride`-th; it looks at no
  // kernels but for their sizes. Throws Error(kInvalidArgument).
  KernelField(std::shared_ptr<const KernelSource> source, KernelSums sums, int attribute = 0,
              int color_attribute = -1);

  bool is_empty() const noexcept { return source_ == nullptr; }
  const KernelSource& source() const noexcept { return *source_; }
  const std::shared_ptr<const KernelSource>& shared_source() const noexcept { return source_; }
  Reconstruction reconstruction() const noexcept { return reconstruction_; }
  int attribute() const noexcept { return attribute_; }
  int color_attribute() const noexcept { return color_attribute_; }
  bool has_own_color() const noexcept { return color_attribute_ != attribute_; }

  std::int64_t num_kernels() const noexcept { return source_ ? source_->num_kernels() : 0; }
  Bounds3 world_bounds() const noexcept { return bounds_; }  // of the centres, half a spacing wider
  // Normalized: of the kernels' values. `sum`: of the field at the kernels' centres.
  ValueRange value_range() const noexcept { return value_range_; }
  ValueRange color_range() const noexcept { return color_range_; }
  // Of a sum what its range was found by, some thousands of values; null: these are means.
  const KernelSums* sums() const noexcept { return sums_.get(); }
  // Twice the median sigma, but at least a 512th of the bounds' diagonal: for a lattice's kernels
  // that is the spacing.
  double default_sampling_distance() const noexcept { return sampling_distance_; }
  // Where pieces between sheets are refined: twice the sigma than which kernels of a fifth of all
  // area are narrower along some axis, in [1/4, 1/2] of the default sampling distance.
  double refined_sampling_distance() const noexcept { return refined_distance_; }
  std::uint64_t id() const noexcept { return id_; }
  std::uint64_t version() const noexcept { return version_; }

  // Where a normalized field's sum of weights is less, the field is undefined and transparent.
  static constexpr double kLeastWeight = 0.2;

 private:
  void look_at_kernels(int attribute, int color_attribute);
  void take_sums(KernelSums sums);

  std::shared_ptr<const KernelSource> source_;
  Reconstruction reconstruction_ = Reconstruction::kNormalized;
  int attribute_ = 0;
  int color_attribute_ = 0;
  Bounds3 bounds_;
  ValueRange value_range_, color_range_;
  std::shared_ptr<const KernelSums> sums_;
  double sampling_distance_ = 1;
  double refined_distance_ = 0.5;
  std::uint64_t id_ = 0;
  std::uint64_t version_ = 0;
};

// A field at one moment of several, and its share of the time.
struct KernelMoment {
  KernelField field;
  double share = 1;  // > 0
};

// The field of kernels at any place.
struct KernelSample {
  double value = 0;
  double color_value = 0;        // of the attribute that gives colour
  Vec3 gradient = Vec3::Zero();  // of `value`, world units: the kernels' own derivative
  double weight = 0;             // sum w phi: about 1 inside
  bool is_defined = false;
};

// Evaluates a kernel field at places, in double precision, through a tree of its bricks. Immutable;
// any number of threads may ask at once. Cost: in proportion to the kernels near the place.
class KernelSampler {
 public:
  explicit KernelSampler(KernelField field);  // throws what the source throws
  ~KernelSampler();
  KernelSampler(KernelSampler&&) noexcept;
  KernelSampler& operator=(KernelSampler&&) noexcept;

  KernelSample at(const Vec3& world) const;

 private:
  struct Impl;
  std::unique_ptr<const Impl> impl_;
};

}  // namespace ovoid
