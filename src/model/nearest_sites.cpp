// SPDX-License-Identifier: Apache-2.0
#include "model/nearest_sites.h"

#include <cstddef>
#include <nanoflann.hpp>

namespace ovoid::model {

namespace {

// The sites as nanoflann asks for them.
struct SiteTable {
  std::span<const double> sites;

  std::size_t kdtree_get_point_count() const { return sites.size() / 3; }
  double kdtree_get_pt(std::size_t site, std::size_t axis) const { return sites[3 * site + axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};

using SiteTree = nanoflann::KDTreeSingleIndexAdaptor<
    nanoflann::L2_Simple_Adaptor<double, SiteTable, double, std::uint32_t>, SiteTable, 3,
    std::uint32_t>;

constexpr std::size_t kLeafSites = 16;  // of 8 to 64, the fastest for 32 neighbours

}  // namespace

struct NearestSites::Impl {
  SiteTable table;
  SiteTree tree;

  explicit Impl(std::span<const double> sites)
      : table{sites}, tree(3, table, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSites)) {}
};

NearestSites::NearestSites(std::span<const double> sites)
    : impl_(std::make_unique<const Impl>(sites)) {}
NearestSites::~NearestSites() = default;

std::size_t NearestSites::find(const Vec3& place, std::span<std::uint32_t> indices,
                               std::span<double> squares) const {
  return impl_->tree.knnSearch(place.data(), indices.size(), indices.data(), squares.data());
}

}  // namespace ovoid::model
