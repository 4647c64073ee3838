// SPDX-License-Identifier: Apache-2.0
#include "histogram_2d.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "ovoid/error.h"
#include "ovoid/image.h"
#include "ovoid/io.h"
#include "ovoid/sampler.h"
#include "session.h"

namespace ovoid::cli {
namespace {

constexpr int kPlaces = 200'000;
constexpr int kFewerPlaces = 50'000;  // of lattices whose samples would be too much to copy

struct Seen {
  double value, gradient;
};

// The fractional parts of multiples of three numbers fill a box evenly and in no pattern of a
// lattice's: powers of the inverse of the root of x^4 = x + 1 [Roberts 2018].
std::vector<Vec3> places_in(const Bounds3& box, int count) {
  constexpr double kRoot = 1.2207440846057596;
  const Vec3 step(1 / kRoot, 1 / (kRoot * kRoot), 1 / (kRoot * kRoot * kRoot));
  std::vector<Vec3> places;
  places.reserve(static_cast<std::size_t>(count));
  for (int i = 1; i <= count; ++i) {
    const Vec3 share = (i * step).unaryExpr([](double x) { return x - std::floor(x); });
    places.emplace_back(box.min() + share.cwiseProduct(box.sizes()));
  }
  return places;
}

template <class Sampler>
std::vector<Seen> seen_at(const std::vector<Vec3>& places, const Sampler& sampler,
                          const std::stop_token& stop) {
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (i % 256 == 0 && stop.stop_requested()) throw Error(ErrorCode::kCancelled, "interrupted");
    const FieldSample sample = sampler.at(places[i]);
    const double gradient = sample.gradient.norm();
    if (sample.is_defined && std::isfinite(sample.value) && std::isfinite(gradient))
      seen.push_back({sample.value, gradient});
  }
  return seen;
}

std::vector<Seen> seen_in(const Field& field, const std::stop_token& stop,
                          std::int64_t most_copied) {
  const Bounds3 box = field.world_bounds();
  const bool is_copied = field.lattice() == nullptr || field.num_kernels() <= most_copied;
  if (is_copied) return seen_at(places_in(box, kPlaces), FieldSampler(field), stop);
  // Slab by slab, so that what a file's pages hold is asked for while they are there.
  constexpr double kSlabs = 64;
  std::vector<Vec3> places = places_in(box, kFewerPlaces);
  const auto slab_of = [&](const Vec3& place) {
    return std::floor((place.z() - box.min().z()) / box.sizes().z() * kSlabs);
  };
  std::stable_sort(places.begin(), places.end(), [&](const Vec3& a, const Vec3& b) {
    return std::pair(slab_of(a), a.y()) < std::pair(slab_of(b), b.y());
  });
  return seen_at(places, FieldProbe(field), stop);
}

}  // namespace

Histogram2D histogram_2d_of(const Field& field, const std::stop_token& stop,
                            std::int64_t most_copied) {
  constexpr double kTail = 1e-3;
  std::vector<Seen> seen = seen_in(field, stop, most_copied);
  if (seen.empty())
    throw Error(ErrorCode::kInvalidArgument,
                "no values and gradients: the field is defined nowhere");
  Histogram2D histogram;
  const auto by_value = [](const Seen& a, const Seen& b) { return a.value < b.value; };
  const auto [least, greatest] = std::minmax_element(seen.begin(), seen.end(), by_value);
  histogram.value_lo = least->value;
  histogram.value_hi = greatest->value;
  if (!(histogram.value_lo < histogram.value_hi)) histogram.value_hi = histogram.value_lo + 1;
  const auto steep =
      seen.end() - 1 - static_cast<std::ptrdiff_t>(kTail * static_cast<double>(seen.size()));
  std::nth_element(seen.begin(), steep, seen.end(),
                   [](const Seen& a, const Seen& b) { return a.gradient < b.gradient; });
  if (steep->gradient > 0) histogram.gradient_hi = steep->gradient;
  histogram.counts.resize(std::size_t{Histogram2D::kColumns} * Histogram2D::kRows);
  const double span = histogram.value_hi - histogram.value_lo;
  for (const Seen& one : seen) {
    if (one.gradient > histogram.gradient_hi) continue;
    const auto bin = [](double share, int count) {
      return static_cast<std::size_t>(std::min(share * count, count - 1.0));
    };
    const std::size_t row = bin(one.gradient / histogram.gradient_hi, Histogram2D::kRows);
    const std::size_t column = bin((one.value - histogram.value_lo) / span, Histogram2D::kColumns);
    ++histogram.counts[row * Histogram2D::kColumns + column];
  }
  return histogram;
}

std::vector<float> brightness_of(const Histogram2D& histogram) {
  // Spots of materials hold so much that arcs would be dark beside them.
  constexpr double kBright = 0.98;
  std::vector<std::uint32_t> found;
  for (const std::uint32_t count : histogram.counts) {
    if (count > 0) found.push_back(count);
  }
  const auto bright =
      found.begin() + static_cast<std::ptrdiff_t>(kBright * static_cast<double>(found.size() - 1));
  std::nth_element(found.begin(), bright, found.end());
  const double most = std::log1p(*bright);
  std::vector<float> brightness;
  brightness.reserve(histogram.counts.size());
  for (const std::uint32_t count : histogram.counts)
    brightness.push_back(static_cast<float>(std::min(std::log1p(count) / most, 1.0)));
  return brightness;
}

void write_histogram_2d(const Histogram2D& histogram, const std::string& path) {
  if (has_ending(path, ".json")) {
    nlohmann::ordered_json json;
    json["values"] = {histogram.value_lo, histogram.value_hi};
    json["gradients"] = {0.0, histogram.gradient_hi};
    json["size"] = {Histogram2D::kColumns, Histogram2D::kRows};
    json["counts"] = histogram.counts;
    return write_file(path, json.dump() + "\n");
  }
  const auto pixels = std::size_t{Histogram2D::kColumns} * Histogram2D::kRows;
  const std::vector<float> brightness = brightness_of(histogram);
  Image image;
  image.width = Histogram2D::kColumns;
  image.height = Histogram2D::kRows;
  image.rgba.assign(4 * pixels, 1);
  image.depth.assign(pixels, INFINITY);
  image.front_depth = image.depth;
  for (std::size_t i = 0; i < pixels; ++i) {
    const std::size_t row = Histogram2D::kRows - 1 - i / Histogram2D::kColumns;
    std::fill_n(&image.rgba[4 * i], 3,
                brightness[row * Histogram2D::kColumns + i % Histogram2D::kColumns]);
  }
  write_image(image, path);
}

}  // namespace ovoid::cli
