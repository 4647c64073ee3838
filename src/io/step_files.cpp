// SPDX-License-Identifier: Apache-2.0
#include "io/step_files.h"

#include <fmt/format.h>

#include "data/shown_step.h"
#include "io/core/byte_source.h"
#include "io/core/row_share.h"
#include "io/core/sample_parts.h"
#include "io/formats.h"
#include "io/input_files.h"
#include "io/read_source.h"
#include "io/step_outline.h"
#include "ovoid/error.h"

namespace ovoid::io {

Dataset read_one_step(
    const std::string& name, std::int64_t num_steps, const ReadOptions& options,
    const std::function<Dataset(std::int64_t step, const ReadOptions& own)>& read) {
  if (options.step) check_step(name, *options.step, num_steps);
  const auto read_step = [&](std::int64_t step, ReadOptions own) {
    own.step.reset();
    Dataset dataset = read(step, own);
    if (dataset.num_steps > 1) {
      throw Error(
          ErrorCode::kUnsupported,
          fmt::format("{}: has {} steps of its own: several inputs are steps of one dataset, "
                      "one each",
                      dataset.source, dataset.num_steps));
    }
    dataset.num_steps = num_steps;
    dataset.step = step;
    dataset.times.clear();  // those of the others are not known
    return dataset;
  };
  if (options.step) return read_step(*options.step, options);
  // Of a step's rows, shares would choose each its own.
  check_share(options.share);
  ReadOptions whole = options;
  whole.share.reset();
  Dataset dataset = data::shown_step({}, num_steps, options.array,
                                     [&](std::int64_t step) { return read_step(step, whole); });
  cut_to_share(dataset, options.share);
  return dataset;
}

Dataset read_step_files(const std::vector<std::string>& paths, const ReadOptions& options) {
  const auto num_steps = static_cast<std::int64_t>(paths.size());
  const std::string name = fmt::format("{} and {} more", paths[0], num_steps - 1);
  for (const std::string& path : paths) open_file(path);
  if (are_sorted_by_reader(paths)) {
    return read_source(*open_file(paths[0]), options, opener_of_named_files(paths[0], options),
                       paths);
  }
  if (options.step) check_step(name, *options.step, num_steps);
  // Whoever goes through a series asks for step after step: all are compared when it is opened.
  const bool is_opened = options.step.value_or(0) == 0;
  check_step_outlines(paths[0], is_opened
                                    ? std::vector(paths.begin() + 1, paths.end())
                                    : std::vector{paths[static_cast<std::size_t>(*options.step)]});
  return read_one_step(name, num_steps, options, [&](std::int64_t step, const ReadOptions& own) {
    const std::string& path = paths[static_cast<std::size_t>(step)];
    return read_source(*open_file(path), own, opener_of_named_files(path, own), paths);
  });
}

}  // namespace ovoid::io
