// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <unordered_map>
#include <utility>

#include "data/out_of_memory.h"
#include "data/scalar_visit.h"
#include "ovoid/error.h"
#include "ovoid/labels.h"

namespace ovoid {
namespace {

constexpr std::size_t kMostSegments = 65'000;

struct Segment {
  std::uint16_t number = 0;  // in what is merged
  std::int64_t count = 0;    // of samples
};

// The segments of one layer by their labels in it.
class LayerSegments {
 public:
  Segment& at(std::int64_t label) {
    if (last_ == nullptr || label != last_label_) {
      last_ = &segments_[label];
      last_label_ = label;
    }
    return *last_;
  }
  // Of all layers together at most kMostSegments.
  std::size_t size() const { return segments_.size(); }

  template <class Visit>
  void each(const Visit& visit) {
    std::set<std::int64_t> labels;
    for (const auto& segment : segments_) labels.insert(segment.first);
    for (const std::int64_t label : labels) visit(label, segments_.at(label));
  }

 private:
  std::unordered_map<std::int64_t, Segment> segments_;  // whose values stay where they are
  Segment* last_ = nullptr;
  std::int64_t last_label_ = 0;
};

template <class T>
std::int64_t label_of(T value, const Dataset& dataset) {
  constexpr double kMost = 1 << 24;
  const auto number = static_cast<double>(value);
  if (!(std::abs(number) <= kMost) || number != std::floor(number)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}': holds {}, expected labels: whole numbers of at most 24 bits",
                            dataset.source, number));
  }
  return static_cast<std::int64_t>(number);
}

const DataArray& layers_of(const Dataset& dataset) {
  const bool has_samples = dataset.kind == DatasetKind::kLattice && !dataset.arrays.empty() &&
                           dataset.arrays.front().stored == nullptr &&
                           !dataset.arrays.front().is_scaled();
  if (has_samples) return dataset.arrays.front();
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("'{}': expected a lattice of labels, in memory and without a scale",
                          dataset.source));
}

class Merger {
 public:
  Merger(const Dataset& dataset, const std::vector<std::vector<LabelEntry>>& tables)
      : dataset_(dataset),
        array_(layers_of(dataset)),
        tables_(tables),
        layers_(static_cast<std::size_t>(array_.num_components)) {}

  MergedLayers merged() {
    return data::visit_scalar(array_.type, [&](auto type) {
      using T = typename decltype(type)::type;
      count<T>();
      MergedLayers merged;
      merged.table = give_numbers();
      merged.dataset = with_samples(choose<T>());
      return merged;
    });
  }

 private:
  // Calls `visit(tuple, layer, label)` for all labels but 0.
  template <class T, class Visit>
  void each_label(const Visit& visit) const {
    const std::byte* const bytes = array_.bytes.view.data();
    std::int64_t at = 0;
    for (std::int64_t i = 0; i < array_.num_tuples; ++i) {
      for (std::size_t layer = 0; layer < layers_.size(); ++layer, ++at) {
        const T value = data::load_scalar<T>(bytes, at);
        if (value != T{}) visit(i, layer, label_of(value, dataset_));
      }
    }
  }

  template <class T>
  void count() {
    each_label<T>([&](std::int64_t, std::size_t layer, std::int64_t label) {
      ++layers_[layer].at(label).count;
      if (layers_[layer].size() > kMostSegments) refuse_so_many();
    });
    std::size_t all = 0;
    for (const LayerSegments& layer : layers_) all += layer.size();
    if (all > kMostSegments) refuse_so_many();
  }

  [[noreturn]] void refuse_so_many() const {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("'{}': has more than {} segments", dataset_.source, kMostSegments));
  }

  static bool may_stay(std::int64_t label) { return label > 0 && label <= INT16_MAX; }

  std::vector<LabelEntry> give_numbers() {
    std::set<std::int64_t> wanted;
    for (LayerSegments& layer : layers_)
      layer.each([&](std::int64_t label, const Segment&) { wanted.insert(label); });
    std::set<std::int64_t> given;
    std::int64_t next = 1;
    std::vector<LabelEntry> table;
    for (std::size_t layer = 0; layer < layers_.size(); ++layer) {
      layers_[layer].each([&](std::int64_t label, Segment& segment) {
        std::int64_t number = label;
        if (!may_stay(label) || given.contains(label)) {
          while (wanted.contains(next) || given.contains(next)) ++next;
          number = next;
        }
        given.insert(number);
        segment.number = static_cast<std::uint16_t>(number);
        LabelEntry entry = entry_of(layer, label);
        entry.label = static_cast<int>(number);
        table.push_back(std::move(entry));
      });
    }
    return table;
  }

  LabelEntry entry_of(std::size_t layer, std::int64_t label) const {
    if (layer < tables_.size()) {
      for (const LabelEntry& entry : tables_[layer])
        if (entry.label == label) return entry;
    }
    return {};
  }

  template <class T>
  std::shared_ptr<const std::vector<std::uint16_t>> choose() {
    auto samples = std::make_shared<std::vector<std::uint16_t>>(
        static_cast<std::size_t>(array_.num_tuples), std::uint16_t{0});
    std::int64_t place = -1;
    std::int64_t fewest = 0;
    each_label<T>([&](std::int64_t i, std::size_t layer, std::int64_t label) {
      const Segment& segment = layers_[layer].at(label);
      if (i == place && segment.count >= fewest) return;
      place = i;
      fewest = segment.count;
      (*samples)[static_cast<std::size_t>(i)] = segment.number;
    });
    return samples;
  }

  Dataset with_samples(std::shared_ptr<const std::vector<std::uint16_t>> samples) const {
    Dataset merged = dataset_;
    DataArray array;
    array.name = array_.name;
    array.type = ScalarType::kUInt16;
    array.num_tuples = array_.num_tuples;
    array.is_cell_data = array_.is_cell_data;
    const std::span<const std::byte> bytes = std::as_bytes(std::span(*samples));
    array.bytes = {std::move(samples), bytes};
    merged.arrays = {std::move(array)};
    return merged;
  }

  const Dataset& dataset_;
  const DataArray& array_;
  const std::vector<std::vector<LabelEntry>>& tables_;
  std::vector<LayerSegments> layers_;
};

}  // namespace

MergedLayers merge_layers(const Dataset& dataset,
                          const std::vector<std::vector<LabelEntry>>& tables) try {
  return Merger(dataset, tables).merged();
} catch (const std::bad_alloc&) {
  data::throw_out_of_memory("the layers of a segmentation, merged", 0);
}

}  // namespace ovoid
