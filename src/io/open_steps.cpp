// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <utility>

#include "io/core/byte_source.h"
#include "io/reader/reader_session.h"
#include "io/step_times.h"
#include "io/zarr/zarr.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/series.h"

namespace ovoid {
namespace {

class FileSteps final : public StepSource {
 public:
  FileSteps(std::vector<std::string> paths, ReadOptions options, const Dataset& first)
      : paths_(std::move(paths)),
        options_(std::move(options)),
        kind_(first.series),
        num_steps_(first.num_steps),
        times_(first.times) {
    name_ = paths_.size() == 1 ? paths_[0]
                               : fmt::format("{} and {} more", paths_[0], paths_.size() - 1);
    options_.progress = {};
    // Of files that are a step each, a reader has seen one.
    const bool is_file_each =
        times_.empty() && num_steps_ > 1 && num_steps_ == static_cast<std::int64_t>(paths_.size());
    if (is_file_each) times_ = times_of_files();
    has_times_ = static_cast<std::int64_t>(times_.size()) == num_steps_;
    if (has_times_) {
      io::check_step_times(is_file_each ? paths_ : std::vector{name_}, times_);
      return;
    }
    times_.resize(static_cast<std::size_t>(num_steps_));
    std::iota(times_.begin(), times_.end(), 0.0);
  }

  SeriesKind kind() const noexcept override { return kind_; }
  const std::string& name() const noexcept override { return name_; }
  std::int64_t num_steps() const noexcept override { return num_steps_; }
  const std::vector<double>& times() const noexcept override { return times_; }
  bool has_times() const noexcept override { return has_times_; }

  Dataset read(std::int64_t step, std::stop_token stop) const override {
    if (step < 0 || step >= num_steps_) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: step {}: expected 0 to {}", name_, step, num_steps_ - 1));
    }
    ReadOptions options = options_;
    options.step = step;
    options.stop = std::move(stop);
    return read_dataset(paths_, options);
  }

 private:
  // Empty unless all name theirs. Writers that know none may state the same in every file.
  std::vector<double> times_of_files() const {
    std::vector<double> times;
    for (const std::string& path : paths_) {
      const auto time = io::named_time(*io::open_file(io::zarr_description_of(path)));
      if (!time) return {};
      times.push_back(*time);
    }
    const bool is_one =
        std::all_of(times.begin(), times.end(), [&](double time) { return time == times.front(); });
    return is_one ? std::vector<double>() : times;
  }

  std::vector<std::string> paths_;
  ReadOptions options_;
  SeriesKind kind_;
  std::int64_t num_steps_;
  std::vector<double> times_;
  bool has_times_ = false;
  std::string name_;
};

}  // namespace

std::shared_ptr<const StepSource> open_steps(const std::vector<std::string>& paths,
                                             const ReadOptions& options) {
  ReadOptions all = options;
  if (!all.session) all.session = std::make_shared<ReaderSession>(paths);
  ReadOptions first = all;
  first.step = 0;
  const Dataset dataset = read_dataset(paths, first);
  return std::make_shared<FileSteps>(paths, std::move(all), dataset);
}

}  // namespace ovoid
