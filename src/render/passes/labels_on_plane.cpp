// SPDX-License-Identifier: Apache-2.0
// In: a label map and a plane in a picture. Out: shares of pixels that labels and their outlines
// have. Lines lie within their labels, so that two that meet have a line each, and are as wide
// whatever the view.
#include "render/passes/labels_on_plane.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "data/parallel.h"

namespace ovoid {
namespace {

constexpr std::int64_t kRowsAtATime = 8;

void put_over(std::array<float, 4>& rgba, const Rgb& color, double opacity) {
  const auto a = static_cast<float>(opacity);
  for (std::size_t c = 0; c < 3; ++c)
    rgba[c] = a * static_cast<float>(color[c]) + (1 - a) * rgba[c];
  rgba[3] = a + (1 - a) * rgba[3];
}

}  // namespace

LabelsOnPlane::LabelsOnPlane(const LabelSurfaces& labels, const PlaneView& view, int width,
                             int height, double line_width, int threads,
                             const std::stop_token& stop)
    : labels_(labels),
      width_(width),
      height_(height),
      reach_(static_cast<int>(std::ceil(line_width))) {
  const double places = kPlaces * line_width;
  const int most = static_cast<int>(std::ceil(places));
  for (int y = -most; y <= most; ++y) {
    for (int x = -most; x <= most; ++x) {
      // To the nearest side of the place there.
      const double away =
          std::hypot(std::max(std::abs(x) - 0.5, 0.0), std::max(std::abs(y) - 0.5, 0.0));
      if ((x != 0 || y != 0) && away < places) around_.push_back({x, y});
    }
  }
  const auto square = [](const std::array<int, 2>& a) { return a[0] * a[0] + a[1] * a[1]; };
  std::stable_sort(around_.begin(), around_.end(),
                   [&](const auto& a, const auto& b) { return square(a) < square(b); });
  find_marks(view, threads, stop);
  if (labels.slice_lines > 0) find_edges(threads, stop);
}

void LabelsOnPlane::find_marks(const PlaneView& view, int threads, const std::stop_token& stop) {
  std::unordered_map<int, Mark> mark_of;
  for (const LabelStyle& style : labels_.styles) {
    if (style.opacity <= 0) continue;
    colors_.push_back(style.color);
    mark_of.emplace(style.label, static_cast<Mark>(colors_.size()));
  }
  marks_.assign(row() * static_cast<std::size_t>(kPlaces) * static_cast<std::size_t>(height_), 0);
  data::parallel_ranges(
      {height_, kRowsAtATime, threads, stop}, [&](std::int64_t begin, std::int64_t end) {
        for (auto y = static_cast<int>(begin); y < end; ++y) {
          for (int x = 0; x < width_; ++x) {
            const auto hit = view.hit(x, y);
            if (!hit) continue;
            for (int j = 0; j < kPlaces; ++j) {
              for (int i = 0; i < kPlaces; ++i) {
                const auto aside = [](int n) { return (n + 0.5) / kPlaces - 0.5; };
                const auto label =
                    labels_.map->label_at(hit->at + aside(i) * hit->per_x + aside(j) * hit->per_y);
                const auto found = label ? mark_of.find(*label) : mark_of.end();
                if (found == mark_of.end()) continue;
                marks_[static_cast<std::size_t>(kPlaces * y + j) * row() +
                       static_cast<std::size_t>(kPlaces * x + i)] = found->second;
              }
            }
          }
        }
      });
}

void LabelsOnPlane::find_edges(int threads, const std::stop_token& stop) {
  edges_.assign(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), 0);
  data::parallel_ranges(
      {height_, kRowsAtATime, threads, stop}, [&](std::int64_t begin, std::int64_t end) {
        for (auto y = static_cast<int>(begin); y < end; ++y) {
          for (int x = 0; x < width_; ++x) {
            // With the places before it, so that one of two that meet knows of it.
            const Mark first = mark(std::max(kPlaces * x - 1, 0), std::max(kPlaces * y - 1, 0));
            bool is_edge = false;
            for (int j = std::max(kPlaces * y - 1, 0); j < kPlaces * (y + 1); ++j) {
              for (int i = std::max(kPlaces * x - 1, 0); i < kPlaces * (x + 1); ++i)
                is_edge |= mark(i, j) != first;
            }
            edges_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                   static_cast<std::size_t>(x)] = is_edge ? 1 : 0;
          }
        }
      });
}

bool LabelsOnPlane::has_edge_near(int x, int y) const {
  const int reach = reach_ + 1;
  for (int j = std::max(y - reach, 0); j <= std::min(y + reach, height_ - 1); ++j) {
    const auto row = edges_.begin() + static_cast<std::ptrdiff_t>(j) * width_;
    const auto begin = row + std::max(x - reach, 0);
    const auto end = row + std::min(x + reach, width_ - 1) + 1;
    if (std::find(begin, end, 1) != end) return true;
  }
  return false;
}

// Whether another label, or none, is as near as a line is wide.
bool LabelsOnPlane::is_on_line(int x, int y) const {
  const Mark own = mark(x, y);
  return std::any_of(around_.begin(), around_.end(), [&](const std::array<int, 2>& aside) {
    const int i = x + aside[0];
    const int j = y + aside[1];
    return i >= 0 && j >= 0 && i < kPlaces * width_ && j < kPlaces * height_ && mark(i, j) != own;
  });
}

void LabelsOnPlane::draw_over(int x, int y, std::array<float, 4>& rgba) const {
  const bool may_have_lines = labels_.slice_lines > 0 && has_edge_near(x, y);
  std::array<float, 4> sum{};
  for (int j = kPlaces * y; j < kPlaces * (y + 1); ++j) {
    for (int i = kPlaces * x; i < kPlaces * (x + 1); ++i) {
      std::array<float, 4> place = rgba;
      if (const Mark own = mark(i, j); own > 0) {
        const Rgb& color = colors_[own - 1U];
        put_over(place, color, labels_.slice_areas);
        if (may_have_lines && is_on_line(i, j)) put_over(place, color, labels_.slice_lines);
      }
      for (std::size_t c = 0; c < 4; ++c) sum[c] += place[c] / (kPlaces * kPlaces);
    }
  }
  rgba = sum;
}

}  // namespace ovoid
