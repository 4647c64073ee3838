// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/series.h"

namespace ovoid::model {

// The steps of a lattice in space and time that are made when they are read.
class LatticeSteps : public StepSource {
 public:
  SeriesKind kind() const noexcept override { return kind_; }
  const std::string& name() const noexcept override { return name_; }
  std::int64_t num_steps() const noexcept override {
    return static_cast<std::int64_t>(times_.size());
  }
  const std::vector<double>& times() const noexcept override { return times_; }
  bool has_times() const noexcept override { return true; }
  Dataset read(std::int64_t step, std::stop_token stop) const final;

 protected:
  LatticeSteps(SeriesKind kind, std::string name) : kind_(kind), name_(std::move(name)) {}

  // The even steps' lattice, and the steps' times; to be called by the constructor.
  void set_steps(const LatticeGeometry& lattice, std::vector<double> times) {
    lattice_ = lattice;
    times_ = std::move(times);
  }
  // Source, format, space and arrays of a step, whose lattice is given.
  virtual Dataset make(std::int64_t step, const LatticeGeometry& lattice,
                       const std::stop_token& stop) const = 0;

 private:
  SeriesKind kind_;
  std::string name_;
  LatticeGeometry lattice_;
  std::vector<double> times_;
};

}  // namespace ovoid::model
