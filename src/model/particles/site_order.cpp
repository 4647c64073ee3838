// SPDX-License-Identifier: Apache-2.0
#include "model/particles/site_order.h"

#include <algorithm>
#include <cmath>

#include "data/kernels/morton.h"
#include "data/parallel.h"

namespace ovoid::model {

namespace {

constexpr std::int64_t kOrderGrain = 65536;

struct OrderItem {
  std::uint64_t key;
  std::uint32_t site;
};

}  // namespace

std::vector<std::uint32_t> morton_order(std::span<const double> sites, int threads) {
  const std::size_t count = sites.size() / 3;
  const auto at = [&](std::size_t i) {
    return Vec3(sites[3 * i], sites[3 * i + 1], sites[3 * i + 2]);
  };
  Bounds3 box;
  for (std::size_t i = 0; i < count; ++i) box.extend(at(i));
  const double edge = count == 0 ? 0.0 : box.sizes().maxCoeff();
  const double scale =
      edge > 0 && std::isfinite(edge) ? std::ldexp(1 - 1e-12, data::kMortonBits) / edge : 0.0;
  std::vector<OrderItem> items(count);
  data::parallel_ranges(
      {static_cast<std::int64_t>(count), kOrderGrain, threads},
      [&](std::int64_t begin, std::int64_t end) {
        for (auto i = static_cast<std::size_t>(begin); i < static_cast<std::size_t>(end); ++i) {
          const Vec3 place = scale > 0 ? Vec3((at(i) - box.min()) * scale) : Vec3(Vec3::Zero());
          items[i] = {data::morton_key(place), static_cast<std::uint32_t>(i)};
        }
      });
  std::sort(items.begin(), items.end(), [](const OrderItem& a, const OrderItem& b) {
    return a.key != b.key ? a.key < b.key : a.site < b.site;
  });
  std::vector<std::uint32_t> order(count);
  std::transform(items.begin(), items.end(), order.begin(),
                 [](const OrderItem& item) { return item.site; });
  return order;
}

}  // namespace ovoid::model
