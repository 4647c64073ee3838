// SPDX-License-Identifier: Apache-2.0
// Steps -> kernel fields at moments before a time, or the one set that is the mean of these. First
// all steps are looked at for how far things move, then moment after moment is made.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <utility>

#include "data/kernels/kernel_shape.h"
#include "model/time/movement.h"
#include "model/time/trail_moments.h"
#include "ovoid/error.h"
#include "ovoid/slices.h"

namespace ovoid {
namespace {

using model::TimeShare;
using model::TrailPart;

// Beside a source's own bytes, while many become one: the columns of a kernel.
constexpr std::size_t kBytesOfColumns = 48;

int most_moments(const TrailOptions& options, const KernelField& now) {
  if (options.most_moments < 1)
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("most_moments = {}: must be >= 1", options.most_moments));
  const std::size_t bytes = now.source().resident_bytes() +
                            kBytesOfColumns * static_cast<std::size_t>(now.num_kernels()) + 1;
  return static_cast<int>(std::clamp<std::size_t>(options.memory_limit / bytes, 1,
                                                  static_cast<std::size_t>(options.most_moments)));
}

// The times between steps that a trail has.
std::vector<TrailPart> parts_of(const std::vector<double>& times, double from, double until) {
  std::vector<TrailPart> parts;
  for (std::size_t i = 0; i + 1 < times.size(); ++i) {
    const double first = std::max(times[i], from);
    const double last = std::min(times[i + 1], until);
    if (first < last) parts.push_back({first, last, times[i], times[i + 1]});
  }
  return parts;
}

// How far things move in each part, or why they do not; `apart`: what may lie between two moments.
void look_at_parts(const Series& series, double apart, std::stop_token stop,
                   std::vector<TrailPart>& parts, KernelTrail& trail) {
  std::string why;
  std::size_t num_still = 0;
  for (TrailPart& part : parts) {
    const std::int64_t step = series.nearest_step(part.first);
    const auto before = series.step(step, stop);
    const auto behind = series.step(step + 1, stop);
    const std::string difference = model::difference_of(*before, *behind);
    part.moves = difference.empty();
    if (!part.moves) {
      why = difference;
      ++num_still;
      continue;
    }
    const double share = (part.until - part.from) / (part.second - part.first);
    part.steps = share * model::usual_way(*before, *behind) / apart;
  }
  if (num_still > 0) {
    trail.notes.push_back(
        fmt::format("trail: {} of {} times between two steps show the steps themselves, since {}",
                    num_still, parts.size(), why));
  }
}

// Where kernels do not overlap from moment to moment.
void note_on_gaps(const std::vector<TrailPart>& parts, std::size_t num_moments,
                  const TrailOptions& options, KernelTrail& trail) {
  constexpr double kSeen = 2;  // sigmas: Gaussians so far apart have two peaks
  double wanted = 0;
  for (const TrailPart& part : parts) wanted += part.moves ? part.steps : 0;
  const double apart = wanted / static_cast<double>(num_moments);
  if (!(apart > kSeen)) return;
  const bool is_by_memory = num_moments < static_cast<std::size_t>(options.most_moments);
  trail.notes.push_back(fmt::format(
      "trail: its {} moments{} lie {:.1f} sigmas of a kernel apart where things are fast, and may "
      "be seen one by one: a shorter trail, or wider kernels, are smooth",
      num_moments, is_by_memory ? ", for which there is memory," : "", apart));
}

// Kernels of several sums, which become one set.
class JoinedSums {
 public:
  void add(const KernelField& field, double share) {
    const KernelSource& source = field.source();
    begin_with(field);
    for (std::int64_t b = 0; b < source.num_bricks(); ++b) {
      const KernelView view = source.acquire(b, 0.0);
      for (std::int32_t i = 0; i < view.count; ++i) {
        const Vec3 center = source.brick(b).origin + data::offset_of(view, i);
        centers_.insert(centers_.end(), {center[0], center[1], center[2]});
        const auto numbers = data::shape_numbers(view, columns_.shape, i);
        shapes_.insert(shapes_.end(), numbers.begin(),
                       numbers.begin() + num_shape_numbers(columns_.shape));
        weights_.push_back(static_cast<float>(share) * data::weight_of(view, i));
        for (std::size_t a = 0; a < values_.size(); ++a) values_[a].push_back(view.value[a][i]);
      }
    }
  }
  KernelField field(int threads) && {
    columns_.centers = centers_;
    columns_.shapes = shapes_;
    columns_.weights = weights_;
    for (const std::vector<float>& column : values_) columns_.values.push_back(column);
    for (const KernelAttribute& attribute : columns_.attributes)
      columns_.ranges.push_back(attribute.range);
    return {make_kernel_source(columns_, threads), Reconstruction::kSum, attribute_, color_};
  }

 private:
  void begin_with(const KernelField& field) {
    const KernelSource& source = field.source();
    const auto attributes = source.attributes();
    if (centers_.empty()) {
      columns_.shape = source.shape();
      columns_.profile = source.profile();
      columns_.cutoff = source.cutoff();
      columns_.attributes.assign(attributes.begin(), attributes.end());
      values_.resize(attributes.size());
      attribute_ = field.attribute();
      color_ = field.color_attribute();
    }
    if (source.shape() != columns_.shape || source.profile() != columns_.profile ||
        source.cutoff() != columns_.cutoff || attributes.size() != values_.size())
      throw Error(ErrorCode::kInvalidArgument,
                  "trail: steps make kernels of several shapes, which no trail can add up");
    for (std::size_t a = 0; a < attributes.size(); ++a) {
      ValueRange& all = columns_.attributes[a].range;
      all = {std::min(all.lo, attributes[a].range.lo), std::max(all.hi, attributes[a].range.hi)};
    }
  }

  KernelColumns columns_;
  std::vector<double> centers_;
  std::vector<float> shapes_, weights_;
  std::vector<std::vector<float>> values_;
  int attribute_ = 0, color_ = -1;
};

KernelTrail trail_at(const Series& series, const std::vector<TimeShare>& times,
                     const TrailOptions& options, const KernelModelOptions& model) {
  KernelTrail trail;
  JoinedSums sums;
  bool are_sums = false;
  for (const auto& [time, share] : times) {
    const Dataset slice =
        slice_at_time(series, time, {.threads = options.threads, .stop = options.stop});
    KernelField field = make_kernel_field(slice, model, nullptr, options.stop);
    are_sums = times.size() > 1 && field.reconstruction() == Reconstruction::kSum;
    if (are_sums) {
      sums.add(field, share);
    } else {
      trail.moments.push_back({std::move(field), share});
    }
  }
  if (are_sums) trail.moments = {{std::move(sums).field(options.threads), 1}};
  return trail;
}

}  // namespace

KernelTrail kernel_trail_before(const Series& series, double time, const TrailOptions& options,
                                const KernelModelOptions& model, const KernelField& now) {
  const std::vector<double>& all = series.times();
  try {
    weights_of_trail(all, time, options.length, options.decay);  // refuses what is no trail
    const int most = most_moments(options, now);
    if (time == all.front()) return trail_at(series, {{time, 1}}, options, model);
    KernelTrail noted;
    std::vector<TrailPart> parts =
        parts_of(all, std::max(time - options.length, all.front()), time);
    // Where there are as many steps as moments it does not matter how far things move in one.
    const bool is_looked_at = parts.size() < static_cast<std::size_t>(most);
    const double apart = 0.5 * now.default_sampling_distance();
    if (is_looked_at) look_at_parts(series, apart, options.stop, parts, noted);
    const std::vector<TimeShare> times =
        model::moments_of(parts, {time, options.length, options.decay}, most);
    KernelTrail trail = trail_at(series, times, options, model);
    trail.notes = std::move(noted.notes);
    if (is_looked_at) note_on_gaps(parts, times.size(), options, trail);
    return trail;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kOutOfMemory, fmt::format("time = {:g}: no memory for a trail", time));
  }
}

}  // namespace ovoid
