// SPDX-License-Identifier: Apache-2.0
// Kernels merged with their neighbours. Input: any kernel source. Output: one in memory. A task is
// a brick, whose kernels are near each other and of similar size: it is halved, again and again,
// across its longest axis in units of its kernels, until about eight are left, or until what is
// left may become one.
#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "data/kernels/kernel_shape.h"
#include "data/parallel.h"
#include "model/coarse_field.h"

namespace ovoid::model {
namespace {

constexpr std::int64_t kGroupKernels = 8;

// Two kernels of weight 1 and distance D sum to 2 exp(-D^2 / 8) half-way, in units of their sigma.
// Where that is under KernelField::kLeastWeight a normalized field has a hole: D^2 = 8 ln 10.
const double kGreatestGap = std::sqrt(8 * std::log(2 / KernelField::kLeastWeight));

// The greatest variance of places, in units of the kernels': what becomes one of them is at most
// three times as wide. Of eight at the corners of a cube, two sigmas apart, it is 1.
constexpr double kGreatestSpread = 3 * 3 - 1;

struct Member {
  Vec3 offset;        // from the brick's origin
  Mat3 factor;        // of the covariance
  double weight = 0;  // of the kernel
  double mass = 0;    // w det L: the integral of w phi, but for the profile's
  double part = 0;    // of the mass, or, of a sum, of what is summed: how much it counts
  std::int32_t index = 0;
};

// Results of a brick, or of all, as make_kernel_source() takes them.
struct Columns {
  std::vector<double> centers;
  std::vector<float> shapes, weights;
  std::vector<std::vector<float>> values;

  void append(const Columns& other) {
    const auto add = [](auto& to, const auto& from) {
      to.insert(to.end(), from.begin(), from.end());
    };
    add(centers, other.centers);
    add(shapes, other.shapes);
    add(weights, other.weights);
    values.resize(other.values.size());
    for (std::size_t a = 0; a < values.size(); ++a) add(values[a], other.values[a]);
  }
};

// Merges the kernels of one brick.
class BrickMerger {
 public:
  BrickMerger(const KernelField& field, double length, double variance)
      : field_(field), source_(field.source()), length_(length), variance_(variance) {
    out_.values.resize(source_.attributes().size());
  }

  Columns merge(std::int64_t brick) {
    origin_ = source_.brick(brick).origin;
    view_ = source_.acquire(brick, 0.0);
    members_.clear();
    for (std::int32_t i = 0; i < view_.count; ++i) add_member(i);
    split(members_);
    Columns result = std::move(out_);
    out_ = {};
    out_.values.resize(result.values.size());
    return result;
  }

 private:
  using Members = std::span<Member>;

  bool is_sum() const noexcept { return field_.reconstruction() == Reconstruction::kSum; }
  double value(int attribute, const Member& member) const noexcept {
    return view_.value[static_cast<std::size_t>(attribute)][member.index];
  }

  void add_member(std::int32_t i) {
    Member member;
    member.offset = data::offset_of(view_, i);
    member.factor =
        data::factor_of(source_.shape(), data::shape_numbers(view_, source_.shape(), i).data());
    member.weight = data::weight_of(view_, i);
    member.mass = member.weight * member.factor.diagonal().prod();
    member.index = i;
    member.part =
        is_sum() ? member.mass * std::abs(value(field_.attribute(), member)) : member.mass;
    members_.push_back(member);
  }

  bool is_within_length(Members members) const {
    Bounds3 box;
    for (const Member& member : members) box.extend(member.offset);
    return box.sizes().maxCoeff() <= length_;
  }

  // Offsets in units of the members' mean kernel, so that cells a thousand times as long as they
  // are thick are as far apart along each axis.
  Eigen::LLT<Mat3> mean_kernel(Members members) const {
    Mat3 covariance = Mat3::Zero();
    for (const Member& member : members) covariance += member.factor * member.factor.transpose();
    return Eigen::LLT<Mat3>(covariance * (variance_ / static_cast<double>(members.size())));
  }

  // Looks along the axis along which the members are furthest apart.
  bool leaves_no_hole(Members members, const Eigen::LLT<Mat3>& unit) {
    Vec3 mean = Vec3::Zero();
    for (const Member& member : members) mean += member.offset;
    mean /= static_cast<double>(members.size());
    Mat3 spread = Mat3::Zero();
    for (const Member& member : members) {
      const Vec3 off = unit.matrixL().solve(member.offset - mean);
      spread += off * off.transpose();
    }
    spread /= static_cast<double>(members.size());
    Eigen::SelfAdjointEigenSolver<Mat3> solver;
    solver.computeDirect(spread);
    if (!(solver.eigenvalues()[2] <= kGreatestSpread)) return false;
    line_.clear();
    for (const Member& member : members)
      line_.push_back(solver.eigenvectors().col(2).dot(unit.matrixL().solve(member.offset - mean)));
    std::sort(line_.begin(), line_.end());
    for (std::size_t i = 1; i < line_.size(); ++i)
      if (!(line_[i] - line_[i - 1] <= kGreatestGap)) return false;
    return true;
  }

  void split(Members members) {
    const auto count = static_cast<std::int64_t>(members.size());
    if (count == 1) {
      keep(members[0]);
      return;
    }
    const std::int64_t groups =
        std::max<std::int64_t>((count + kGroupKernels / 2) / kGroupKernels, 1);
    const Eigen::LLT<Mat3> unit = mean_kernel(members);
    if (is_within_length(members) || (groups == 1 && leaves_no_hole(members, unit))) {
      unite(members);
      return;
    }
    const std::int64_t left = groups > 1 ? count * (groups / 2) / groups : count / 2;
    halve(members, static_cast<std::size_t>(left), unit);
    split(members.first(static_cast<std::size_t>(left)));
    split(members.subspan(static_cast<std::size_t>(left)));
  }

  // The members furthest to the left come first.
  void halve(Members members, std::size_t left, const Eigen::LLT<Mat3>& unit) {
    order_.clear();
    Bounds3 box;
    for (std::size_t i = 0; i < members.size(); ++i) {
      order_.push_back({unit.matrixL().solve(members[i].offset), i});
      box.extend(order_.back().place);
    }
    Eigen::Index axis = 0;
    box.sizes().maxCoeff(&axis);
    // The index decides between equals, so that the order is one.
    std::nth_element(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(left),
                     order_.end(), [axis](const Place& a, const Place& b) {
                       return a.place[axis] != b.place[axis] ? a.place[axis] < b.place[axis]
                                                             : a.index < b.index;
                     });
    scratch_.assign(members.begin(), members.end());
    for (std::size_t i = 0; i < members.size(); ++i) members[i] = scratch_[order_[i].index];
  }

  void keep(const Member& member) {
    add_center(member.offset);
    add_shape(member.factor);
    out_.weights.push_back(static_cast<float>(member.weight));
    for (std::size_t a = 0; a < out_.values.size(); ++a)
      out_.values[a].push_back(view_.value[a][member.index]);
  }

  void add_center(const Vec3& offset) {
    const Vec3 center = origin_ + offset;
    out_.centers.insert(out_.centers.end(), {center[0], center[1], center[2]});
  }

  void add_shape(const Mat3& factor) {
    if (source_.shape() == KernelShape::kBalls) {
      out_.shapes.push_back(static_cast<float>(factor(0, 0)));
      return;
    }
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c <= r; ++c) out_.shapes.push_back(static_cast<float>(factor(r, c)));
  }

  void unite(Members members) {
    double mass = 0, parts = 0;
    for (const Member& member : members) {
      mass += member.mass;
      parts += member.part;
    }
    if (!(parts > 0)) {  // nothing is summed: all count by their mass
      for (Member& member : members) member.part = member.mass;
      parts = mass;
    }
    Vec3 center = Vec3::Zero();
    for (const Member& member : members) center += member.part / parts * member.offset;
    const Mat3 factor = united_factor(members, center, parts);
    add_center(center);
    add_shape(factor);
    out_.weights.push_back(static_cast<float>(mass / factor.diagonal().prod()));
    for (std::size_t a = 0; a < out_.values.size(); ++a)
      out_.values[a].push_back(united_value(members, static_cast<int>(a), mass, parts));
  }

  // A sum's own value keeps the sum of mass times value; its colour is weighted by what is summed.
  float united_value(Members members, int attribute, double mass, double parts) const {
    const bool is_color =
        is_sum() && attribute == field_.color_attribute() && field_.has_own_color();
    double sum = 0;
    for (const Member& member : members)
      sum += value(attribute, member) * (is_color ? member.part / parts : member.mass / mass);
    return static_cast<float>(sum);
  }

  // S = L L^T is the mean covariance and that of the centres. L^T is the triangle of the
  // decomposition of all the factors' rows, one below the other: S itself would lose the digits of
  // what is flat.
  Mat3 united_factor(Members members, const Vec3& center, double parts) {
    if (source_.shape() == KernelShape::kBalls) {
      double square = 0;
      for (const Member& member : members) {
        const double sigma = member.factor(0, 0);
        square += member.part / parts *
                  (sigma * sigma + (member.offset - center).squaredNorm() / (3 * variance_));
      }
      return Mat3::Identity() * std::sqrt(square);
    }
    rows_.resize(static_cast<Eigen::Index>(4 * members.size()), 3);
    for (std::size_t i = 0; i < members.size(); ++i) {
      const auto first = static_cast<Eigen::Index>(4 * i);
      const double root = std::sqrt(members[i].part / parts);
      rows_.middleRows<3>(first) = root * members[i].factor.transpose();
      rows_.row(first + 3) = root / std::sqrt(variance_) * (members[i].offset - center).transpose();
    }
    const Eigen::HouseholderQR<Eigen::Ref<Eigen::MatrixX3d>> decomposition(rows_);
    Mat3 factor = rows_.topRows<3>().triangularView<Eigen::Upper>().transpose();
    for (int c = 0; c < 3; ++c)
      if (factor(c, c) < 0) factor.col(c) *= -1;
    return factor;
  }

  const KernelField& field_;
  const KernelSource& source_;
  const double length_, variance_;
  Vec3 origin_;
  KernelView view_;
  std::vector<Member> members_;
  Columns out_;

  struct Place {
    Vec3 place;
    std::size_t index;
  };
  std::vector<Place> order_;  // while halving
  std::vector<Member> scratch_;
  std::vector<double> line_;  // while looking for holes
  Eigen::MatrixX3d rows_;     // while uniting
};

// Bricks per task: a millisecond or so.
constexpr std::int64_t kBricksPerTask = 16;

}  // namespace

KernelField coarse_kernels(const KernelField& field, const CoarseOptions& options) {
  const KernelSource& source = field.source();
  const std::int64_t num_bricks = source.num_bricks();
  std::vector<Columns> parts(
      static_cast<std::size_t>((num_bricks + kBricksPerTask - 1) / kBricksPerTask));
  const double variance = data::profile_variance(source.profile(), source.cutoff());
  CoarseProgress progress(options, num_bricks);
  data::parallel_ranges({num_bricks, kBricksPerTask, options.threads, options.stop},
                        [&](std::int64_t begin, std::int64_t end) {
                          BrickMerger merger(field, options.length, variance);
                          Columns& part = parts[static_cast<std::size_t>(begin / kBricksPerTask)];
                          for (std::int64_t b = begin; b < end; ++b) part.append(merger.merge(b));
                          progress.add(end - begin);
                        });
  Columns all;
  for (const Columns& part : parts) all.append(part);
  parts.clear();
  KernelColumns columns;
  columns.shape = source.shape();
  columns.profile = source.profile();
  columns.cutoff = source.cutoff();
  columns.centers = all.centers;
  columns.shapes = all.shapes;
  columns.weights = all.weights;
  columns.values.assign(all.values.begin(), all.values.end());
  columns.attributes.assign(source.attributes().begin(), source.attributes().end());
  return {make_kernel_source(columns, options.threads), field.reconstruction(), field.attribute(),
          field.has_own_color() ? field.color_attribute() : -1};
}

}  // namespace ovoid::model
