// SPDX-License-Identifier: Apache-2.0
#include "data/step_likeness.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ovoid/error.h"

namespace ovoid::data {
namespace {

// Files round places to float32, and readers work directions out from rounded numbers.
constexpr double kSamePlace = 1e-3;  // spacings, at the lattice's farthest sample

std::string dims_text(const Index3& dims) {
  return fmt::format("{} x {} x {}", dims[0], dims[1], dims[2]);
}

const char* place_of(bool is_cell_data) { return is_cell_data ? "cells" : "nodes or samples"; }

}  // namespace

void check_times(const StepSource& source) {
  const std::vector<double>& times = source.times();
  const auto count = static_cast<std::int64_t>(times.size());
  if (source.num_steps() < 1 || count != source.num_steps()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: {} times of {} steps: expected one each, and at least one",
                            source.name(), count, source.num_steps()));
  }
  for (std::size_t i = 0; i < times.size(); ++i) {
    if (std::isfinite(times[i]) && (i == 0 || times[i] > times[i - 1])) continue;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: times[{}] = {}: expected finite times that rise", source.name(), i,
                            times[i]));
  }
}

StepLikeness::StepLikeness(const Dataset& first, std::int64_t step, SeriesKind series)
    : kind_(first.kind), lattice_(first.lattice), step_(step), series_(series) {
  for (const DataArray& array : first.arrays)
    arrays_.push_back({array.name, array.type, array.num_components, array.is_cell_data});
}

void StepLikeness::fail(const Dataset& dataset, std::int64_t step, const std::string& what) const {
  throw Error(
      ErrorCode::kFileFormat,
      fmt::format("{}: step {}: {}: the steps of a series are alike", dataset.source, step, what));
}

void StepLikeness::check(const Dataset& dataset, std::int64_t step) const {
  if (dataset.kind != kind_) {
    fail(dataset, step,
         fmt::format("holds {}, step {} {}", name_of(dataset.kind), step_, name_of(kind_)));
  }
  if (kind_ == DatasetKind::kLattice) check_lattice(dataset, step);
  check_arrays(dataset, step);
}

void StepLikeness::check_lattice(const Dataset& dataset, std::int64_t step) const {
  const LatticeGeometry& lattice = dataset.lattice;
  if (lattice.kind != lattice_.kind) {
    fail(dataset, step,
         fmt::format("is a {} lattice, step {} a {} one", name_of(lattice.kind), step_,
                     name_of(lattice_.kind)));
  }
  if (lattice.dims != lattice_.dims) {
    fail(dataset, step,
         fmt::format("has {} samples, step {} has {}", dims_text(lattice.dims), step_,
                     dims_text(lattice_.dims)));
  }
  const Vec3 last(static_cast<double>(lattice.dims[0]), static_cast<double>(lattice.dims[1]),
                  static_cast<double>(lattice.dims[2]));
  const Mat3 turned = lattice.world_from_index.linear() - lattice_.world_from_index.linear();
  const double spacing = lattice_.world_from_index.linear().colwise().norm().minCoeff();
  if (!((turned * last.asDiagonal()).cwiseAbs().sum() <= kSamePlace * spacing))
    fail(dataset, step, fmt::format("its axes are not those of step {}", step_));
  // Half of each axis vector, to the one side or the other, between even and odd steps.
  const Vec3 moved =
      lattice.world_from_index.translation() - lattice_.world_from_index.translation();
  const bool is_shifted = series_ == SeriesKind::kStaggered && (step - step_) % 2 != 0;
  const Vec3 shift =
      is_shifted ? Vec3(0.5 * lattice_.world_from_index.linear().rowwise().sum()) : Vec3::Zero();
  const double off = std::min((moved - shift).norm(), (moved + shift).norm());
  if (!(off <= kSamePlace * spacing)) {
    fail(dataset, step,
         is_shifted
             ? fmt::format("lies {:.3g} off half of each axis vector from step {}", off, step_)
             : fmt::format("lies {:.3g} off the place of step {}", off, step_));
  }
}

void StepLikeness::check_arrays(const Dataset& dataset, std::int64_t step) const {
  const bool is_alone = arrays_.size() == 1 && dataset.arrays.size() == 1;
  for (const Array& wanted : arrays_) {
    const auto found =
        std::find_if(dataset.arrays.begin(), dataset.arrays.end(), [&](const DataArray& array) {
          return is_alone ||
                 (array.name == wanted.name && array.is_cell_data == wanted.is_cell_data);
        });
    if (found == dataset.arrays.end()) {
      fail(dataset, step,
           fmt::format("has no array '{}' of {}, step {} has", wanted.name,
                       place_of(wanted.is_cell_data), step_));
    }
    if (found->is_cell_data != wanted.is_cell_data) {
      fail(dataset, step,
           fmt::format("array '{}' is of {}, in step {} of {}", found->name,
                       place_of(found->is_cell_data), step_, place_of(wanted.is_cell_data)));
    }
    if (found->type != wanted.type) {
      fail(dataset, step,
           fmt::format("array '{}' is {}, in step {} {}", found->name, name_of(found->type), step_,
                       name_of(wanted.type)));
    }
    if (found->num_components != wanted.num_components) {
      fail(dataset, step,
           fmt::format("array '{}' has {} components, in step {} {}", found->name,
                       found->num_components, step_, wanted.num_components));
    }
  }
}

}  // namespace ovoid::data
