// SPDX-License-Identifier: Apache-2.0
// The normal equations of few kernels on levels, as a sparse matrix: what each kernel shares with
// those near it. Where kernels are few a product with it costs a small part of a pass over the
// samples.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "data/lattice/level_basis.h"

namespace ovoid::fit {

// What kernels of one level share with those of another, along one axis.
class SharedAlong {
 public:
  SharedAlong(const data::LevelAxis& of, const data::LevelAxis& with);

  // The nodes `with` that node `i` shares samples with, from the first on.
  std::int64_t first(std::int64_t i) const noexcept { return firsts_[static_cast<std::size_t>(i)]; }
  std::span<const float> products(std::int64_t i) const noexcept {
    const auto at = static_cast<std::size_t>(i);
    return std::span(products_).subspan(begins_[at], begins_[at + 1] - begins_[at]);
  }

 private:
  std::vector<std::int64_t> firsts_;
  std::vector<std::size_t> begins_;
  std::vector<float> products_;
};

class LevelPairs {
 public:
  explicit LevelPairs(const data::LevelBasis& basis);

  // The matrix of these kernels: nodes, rising. False if more than `most` entries would have to be
  // kept, of 8 bytes; then there is none. Throws Error(kCancelled).
  bool assemble(std::span<const std::uint32_t> nodes, std::size_t most,
                const data::LevelWork& work);
  // out = the matrix times `values`, both as long as the nodes.
  void multiply(std::span<const double> values, std::span<double> out,
                const data::LevelWork& work) const;

 private:
  // Rows of the matrix, one behind the other: of what is shared with the same level and coarser
  // ones, where there is little to look through; the rest is the same mirrored.
  struct Rows {
    std::vector<std::uint32_t> columns;
    std::vector<float> products;
    std::vector<std::size_t> ends;
  };

  void add_row(std::uint32_t node, Rows& rows) const;
  static void multiply_rows(const Rows& rows, std::size_t first, std::span<const double> values,
                            std::vector<double>& sums);

  const data::LevelBasis& basis_;
  std::vector<std::vector<std::array<SharedAlong, 3>>> shared_;  // [of][with - of] levels
  std::vector<std::uint32_t>
      number_of_;  // of each node: which kernel it is, counted from 1; 0: none
  std::vector<std::uint32_t> nodes_;
  std::vector<Rows> rows_;  // of kRows kernels each
};

}  // namespace ovoid::fit
