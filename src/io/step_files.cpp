// SPDX-License-Identifier: Apache-2.0
#include "io/step_files.h"

#include <fmt/format.h>

#include "data/shown_step.h"
#include "io/core/byte_source.h"
#include "io/core/row_share.h"
#include "io/core/sample_parts.h"
#include "io/input_files.h"
#include "io/read_source.h"
#include "io/step_outline.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

Dataset read_step_file(const std::vector<std::string>& paths, std::int64_t step,
                       const ReadOptions& options) {
  ReadOptions own = options;
  own.step.reset();
  const std::string& path = paths[static_cast<std::size_t>(step)];
  Dataset dataset = read_source(*open_file(path), own, opener_of_named_files(path, own), paths);
  if (dataset.num_steps > 1) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("{}: has {} steps of its own: several inputs are steps of one dataset, "
                            "one each",
                            dataset.source, dataset.num_steps));
  }
  dataset.num_steps = static_cast<std::int64_t>(paths.size());
  dataset.step = step;
  dataset.times.clear();  // those of the others are not known
  return dataset;
}

}  // namespace

Dataset read_step_files(const std::vector<std::string>& paths, const ReadOptions& options) {
  const auto num_steps = static_cast<std::int64_t>(paths.size());
  const std::string name = fmt::format("{} and {} more", paths[0], num_steps - 1);
  if (options.step) check_step(name, *options.step, num_steps);
  for (const std::string& path : paths) open_file(path);
  // Whoever goes through a series asks for step after step: all are compared when it is opened.
  const bool is_opened = options.step.value_or(0) == 0;
  check_step_outlines(paths[0], is_opened
                                    ? std::vector(paths.begin() + 1, paths.end())
                                    : std::vector{paths[static_cast<std::size_t>(*options.step)]});
  if (options.step) return read_step_file(paths, *options.step, options);
  // Of a step's rows, shares would choose each its own.
  check_share(options.share);
  ReadOptions whole = options;
  whole.share.reset();
  Dataset dataset = data::shown_step({}, num_steps, options.array, [&](std::int64_t step) {
    return read_step_file(paths, step, whole);
  });
  cut_to_share(dataset, options.share);
  return dataset;
}

}  // namespace ovoid::io
