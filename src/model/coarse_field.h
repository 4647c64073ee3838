// SPDX-License-Identifier: Apache-2.0
// The two kinds of coarse fields. docs/numerics.md, "Coarse fields", is the definition.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>

#include "ovoid/coarse.h"

namespace ovoid::model {

LatticeField coarse_lattice(const LatticeField& field, const CoarseOptions& options);
KernelField coarse_kernels(const KernelField& field, const CoarseOptions& options);

// Tells how much of `total` is done, in order, whoever does it.
class CoarseProgress {
 public:
  CoarseProgress(const CoarseOptions& options, std::int64_t total)
      : report_(options.progress), total_(total) {}

  void add(std::int64_t count) {
    if (!report_) return;
    const std::scoped_lock lock(mutex_);
    done_ += count;
    report_(static_cast<double>(done_) / static_cast<double>(total_));
  }

 private:
  const std::function<void(double)>& report_;
  const std::int64_t total_;
  std::int64_t done_ = 0;
  std::mutex mutex_;
};

}  // namespace ovoid::model
