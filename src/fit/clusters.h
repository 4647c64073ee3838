// SPDX-License-Identifier: Apache-2.0
// Source kernels in clusters, each of which becomes one kernel. A cluster is halved where more
// kernels are wanted.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fit/source_kernels.h"

namespace ovoid::fit {

// Source kernels order[begin] to order[end - 1].
struct Cluster {
  std::uint32_t begin = 0, end = 0;
  // Of each attribute: the kernel's value as it was fitted last, less the mean of what it stands
  // for. What a cluster's halves begin with.
  std::array<double, kMaxAttributes> excess{};

  std::uint32_t count() const noexcept { return end - begin; }
};

// How the kernel of a cluster is made of the kernels that it stands for.
struct MergeRule {
  KernelShape shape = KernelShape::kEllipsoids;
  // The covariance is the mean of theirs, and so many times that of their centres. 1 keeps the
  // moments of a sum; 3 makes of a lattice's kernels those of a coarser lattice.
  double spread = 3;
  int amplitude_passes = 3;  // of a normalized field
};

// Kernels, one for each cluster.
struct MergedKernels {
  std::vector<double> centers;             // [n, 3]
  std::vector<float> shapes;               // [n, 6]
  std::vector<float> weights;              // [n]
  std::vector<std::vector<double>> means;  // of each attribute [n]: of what the cluster stands for

  KernelColumns columns(double cutoff) const;
  // Weight times det L: what a kernel's value is multiplied by in the integral of a sum.
  double mass(std::size_t i) const noexcept;
};

class Clusters {
 public:
  // One cluster of all. `source` is borrowed. At least one kernel, fewer than 2^32.
  Clusters(const SourceKernels& source, int threads);

  std::vector<Cluster> list;

  // Halves these clusters, numbers into `list`, each of two kernels or more: the first half takes
  // the cluster's place, the second stands at the list's end, in their order. A cluster is halved
  // across the axis along which two straight lines fit its values best, of those that are not short
  // against its own kernels. Throws Error(kCancelled).
  void halve(const std::vector<std::uint32_t>& which, const std::stop_token& stop);

  MergedKernels merged(const MergeRule& rule, const std::stop_token& stop) const;

 private:
  const SourceKernels* source_;
  int threads_;
  std::vector<std::uint32_t> order_;
};

}  // namespace ovoid::fit
