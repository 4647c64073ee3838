// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "data/field_samples.h"
#include "data/lattice/page_cache.h"
#include "data/lattice/resident_lattice.h"
#include "data/lattice/rise_samples.h"
#include "data/lattice/sample_survey.h"
#include "data/lattice/shared_layers.h"
#include "ovoid/dataset.h"
#include "ovoid/field.h"

namespace ovoid {

// A brick source over samples that stay in their file, x fastest. Pages are boxes of whole rows,
// kPageEdge of them along y and z, so that a page is read in as many pieces as it has layers; those
// that were used last are kept. What is asked of samples from everywhere is found when they are
// read first: ranges of bricks, FieldSamples, labels. Memory: the pages, 8 bytes per brick of 8
// cells along each axis, and some 5 MB of samples. Immutable to its users; all members may be
// called from many threads.
class PagedLattice final : public BrickSource {
 public:
  static constexpr int kBrickEdge = 8;
  static constexpr int kPageEdge = 32;

  // Cartesian. The type is one that ResidentLattice shows. Throws Error: kInvalidArgument for
  // anything else, and in all processes of a team if their files differ, kCancelled, what reading
  // throws. Cost: the file is read once, by processes of a team, which all call it, each a part.
  PagedLattice(const LatticeGeometry& geometry, ScalarType type,
               std::shared_ptr<const StoredSamples> samples,
               const ResidentLatticeOptions& options = {},
               std::shared_ptr<KernelTeam> team = nullptr);

  const LatticeGeometry& geometry() const noexcept override { return geometry_; }
  int brick_edge() const noexcept override { return kBrickEdge; }
  double value_scale() const noexcept override { return value_scale_; }
  double value_offset() const noexcept override { return value_offset_; }
  ValueRange brick_range(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept override;
  double range_reach() const noexcept override { return range_reach_; }
  bool has_missing(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept override;
  // The brick's page, pinned by the view. Throws what reading throws.
  BrickView acquire(std::int64_t bx, std::int64_t by, std::int64_t bz, double time) const override;
  std::size_t resident_bytes() const noexcept override;

  // What data::take_samples() and data::labels_of() give.
  const data::FieldSamples& field_samples() const noexcept { return field_samples_; }
  const std::vector<int>& labels() const noexcept { return labels_; }
  // What data::take_rises() gives: found when it is first asked for.
  const std::vector<data::RiseSample>& rises() const;
  // Whole layers of pages.
  data::SharedLayers layers() const noexcept;

 private:
  using Page = std::unique_ptr<std::byte[]>;  // samples

  std::size_t brick_index(std::int64_t bx, std::int64_t by, std::int64_t bz) const noexcept;
  template <class T>
  void look_at_samples(const ResidentLatticeOptions& options, data::SampleSurvey& survey);
  void require_one_file() const;
  void take_ranges_of_all();
  // The samples of a page: whole rows y, layers z.
  struct PageBox {
    std::int64_t y0, y1, z0, z1;
  };
  PageBox box_of(std::int64_t number) const noexcept;
  void read_rows(const PageBox& box, std::byte* to) const;

  LatticeGeometry geometry_;
  ScalarType type_;
  std::shared_ptr<const StoredSamples> samples_;
  double range_reach_, value_scale_, value_offset_;
  Index3 num_bricks_{};
  std::vector<ValueRange> ranges_;     // values, of all bricks
  std::vector<std::uint8_t> missing_;  // of all bricks; empty if no sample is
  std::int64_t pages_along_y_ = 1;
  std::shared_ptr<KernelTeam> team_;  // or null
  data::FieldSamples field_samples_;
  std::vector<int> labels_;
  mutable std::once_flag has_rises_;
  mutable std::vector<data::RiseSample> rises_;
  mutable std::optional<data::PageCache<Page>> pages_;
};

}  // namespace ovoid
