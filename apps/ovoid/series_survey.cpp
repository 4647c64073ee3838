// SPDX-License-Identifier: Apache-2.0
#include "series_survey.h"

#include <algorithm>
#include <vector>

#include "apply_crop.h"
#include "make_look.h"
#include "setting_forms.h"

namespace ovoid::cli {
namespace {

constexpr double kSurveyBytes = 2.0 * (1 << 30);

double bytes_of(const Dataset& dataset) {
  double bytes = static_cast<double>(dataset.positions.bytes.view.size());
  for (const DataArray& array : dataset.arrays)
    bytes += static_cast<double>(array.bytes.view.size());
  return std::max(bytes, 1.0);
}

// `first`, then the others in order.
std::vector<std::int64_t> affordable_steps(std::int64_t num_steps, std::int64_t first,
                                           double bytes_each) {
  const auto affordable = static_cast<std::int64_t>(
      std::clamp(kSurveyBytes / bytes_each, 2.0, static_cast<double>(num_steps)));
  std::vector<std::int64_t> steps{first};
  for (std::int64_t i = 0; i < affordable; ++i) {
    const std::int64_t step = affordable > 1 ? i * (num_steps - 1) / (affordable - 1) : first;
    if (step != first && step != steps.back()) steps.push_back(step);
  }
  return steps;
}

void widen(ValueRange& range, const ValueRange& by) {
  if (by.is_empty()) return;
  range = range.is_empty() ? by : ValueRange{std::min(range.lo, by.lo), std::max(range.hi, by.hi)};
}

double span_of(const ValueRange& range) {
  return range.is_empty() ? -1.0 : static_cast<double>(range.hi) - range.lo;
}

// A range or a file says what the colours mean, and so do the integrals of an x-ray; then only the
// bounds of what moves are left.
bool needs_values(const LookFlags& look) {
  return !look.range && look.file.empty() && look.mode != Mode::kXray;
}

}  // namespace

Dataset data_at(const Series& series, double time, const DrawingFlags& drawing, Session& session) {
  TimeSliceOptions options;
  options.filter = drawing.time_filter;
  options.threads = drawing.run.threads;
  options.stop = session.stop();
  return slice_at_time(series, time, options);
}

Modelled field_at(const Series& series, double time, const DrawingFlags& drawing,
                  Session& session) {
  return make_field(data_at(series, time, drawing, session), drawing.model, drawing.run.threads,
                    session);
}

std::vector<std::int64_t> steps_to_survey(const Series& series, std::int64_t first,
                                          const Dataset& dataset, const LookFlags& look) {
  const bool is_needed = dataset.kind != DatasetKind::kLattice || needs_values(look);
  if (!is_needed || series.num_steps() == 1) return {first};
  return affordable_steps(series.num_steps(), first, bytes_of(dataset));
}

Survey survey(const Series& series, const std::vector<double>& times, const DrawingFlags& drawing,
              Session& session) {
  Survey survey;
  survey.look_time = times.front();
  survey.num_steps = static_cast<std::int64_t>(times.size());
  double widest = -1;
  const Quiet quiet(session);
  Progress progress("looking at the steps");
  for (std::size_t i = 0; i < times.size(); ++i) {
    session.check_stop();
    const Field field = field_at(series, times[i], drawing, session).field;
    const double span = span_of(field.value_range());
    if (span > widest) {
      widest = span;
      survey.look_time = times[i];
    }
    widen(survey.values, field.value_range());
    widen(survey.colors, field.color_range());
    survey.bounds.extend(field.world_bounds());
    progress.show(static_cast<double>(i + 1) / static_cast<double>(times.size()));
  }
  if (!needs_values(drawing.look)) survey.look_time = times.front();
  return survey;
}

LookFlags with_range_of(const Survey& survey, const LookFlags& flags, const Field& field) {
  LookFlags fixed = flags;
  const bool has_own_span = !flags.file.empty() || !flags.preset.empty();
  const KernelField* const set = field.kernels();
  const bool has_own_color = set != nullptr && set->has_own_color();
  const ValueRange range = has_own_color ? survey.colors : survey.values;
  // Lists of colours stand where they say, and an x-ray's colours are integrals.
  const bool is_told = flags.range || has_own_span || is_list_of_colors(flags.color_map) ||
                       flags.mode == Mode::kXray || range.is_empty() || !(range.lo < range.hi);
  // The default look is more than a range; it is that of the step whose values span the most.
  if (is_told || survey.num_steps == 1 || (uses_default_look(flags) && !has_own_color))
    return fixed;
  fixed.range = {range.lo, range.hi};
  return fixed;
}

Box box_of_all(const Survey& survey, const CropFlags& crop, const Field& field,
               RenderOptions* options) {
  Box box = apply_crop(crop, field, options);
  if (field.lattice() != nullptr) return box;
  return {Affine3::Identity(),
          crop.world ? survey.bounds.intersection(*crop.world) : survey.bounds};
}

}  // namespace ovoid::cli
