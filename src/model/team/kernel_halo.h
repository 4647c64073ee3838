// SPDX-License-Identifier: Apache-2.0
// Kernels of a team's other processes that reach places of one's own.
#pragma once

#include <span>
#include <vector>

#include "data/kernels/letters.h"
#include "model/particles/kernel_parts.h"

namespace ovoid::model {

class KernelHalo {
 public:
  // Appends to `parts`, ellipsoids, those of others that may reach one of its centres, without
  // values. All call it.
  KernelHalo(const ModelRun& run, KernelParts& parts);

  // Brings the others' weights, which have changed as one's own have, into the column. All call it.
  void renew(std::vector<float>& weights) const;

  // Takes the others out again.
  void remove_from(KernelParts& parts) const;

 private:
  const ModelRun& run_;
  std::size_t num_own_;
  data::RowLists lists_;  // of one's own kernels, who else needs them
};

}  // namespace ovoid::model
