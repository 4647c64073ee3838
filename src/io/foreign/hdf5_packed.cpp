// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_HDF5

#include "io/foreign/hdf5_packed.h"

#include <fmt/format.h>

#include <cstring>
#include <functional>
#include <limits>
#include <type_traits>
#include <utility>

#include "data/lattice/relevant_runs.h"
#include "data/lattice/stored_number.h"
#include "data/scalar_visit.h"
#include "io/core/point_arrays.h"
#include "io/core/sample_parts.h"
#include "io/core/work_done.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/hdf5/hdf5_lattice_format.h"
#include "io/hdf5/stored_boxes.h"
#include "ovoid/lattice_boxes.h"
#include "ovoid/lattice_levels.h"

namespace ovoid::io {
namespace {

class Unpacker {
 public:
  Unpacker(const Hdf5Packed& packed, std::vector<std::string>* notes)
      : objects_(packed.objects), dims_(packed.dims), options_(packed.options), notes_(notes) {}

  DataArray of_runs(hid_t group, const std::string& place, DataArray description,
                    ReadProgress& progress) {
    std::int64_t stored_bytes = 0;
    const data::RelevantRuns runs = read_runs(group, place, progress, stored_bytes);
    description.type = runs.box().type;
    std::byte* to = nullptr;
    DataArray array = new_array(std::move(description), to);
    runs.decode({0, 0, 0}, runs.box().dims, to);
    notes_->push_back(fmt::format(
        "{}: '{}' is stored as runs: {} of {} samples ({:.1f} %) in {} runs, {} bytes in the "
        "file; the others are {:g}",
        objects_.name(), array.name, runs.num_relevant(), array.num_tuples,
        100.0 * static_cast<double>(runs.num_relevant()) / static_cast<double>(array.num_tuples),
        runs.num_runs(), stored_bytes, runs.background() * array.value_scale + array.value_offset));
    return array;
  }

  DataArray of_levels(hid_t group, const std::string& place, DataArray description,
                      ReadProgress& progress) {
    const ScalarType type = type_of_content(group, place);
    std::int64_t stored_bytes = 0;
    const LatticeLevels levels = read_levels(group, place, type, progress, stored_bytes);
    DataArray array = dense(place, std::move(description), type, [&] {
      return samples_of(levels, 0, options_.stop, counted_progress(num_samples(levels.dims)));
    });
    notes_->push_back(fmt::format(
        "{}: '{}' is stored as levels: {} kernels for {} samples, {} bytes in the file",
        objects_.name(), array.name, levels.num_kernels(), array.num_tuples, stored_bytes));
    return array;
  }

  DataArray of_boxes(hid_t group, const std::string& place, DataArray description,
                     ReadProgress& progress) {
    const ScalarType type = type_of_content(group, place);
    std::int64_t stored_bytes = 0;
    const LatticeBoxes boxes = read_boxes(group, place, type, progress, stored_bytes);
    DataArray array = dense(place, std::move(description), type, [&] {
      return samples_of(boxes, options_.stop, counted_progress(num_samples(boxes.dims)));
    });
    notes_->push_back(fmt::format(
        "{}: '{}' is stored as boxes: {} for {} samples, {} bytes in the file", objects_.name(),
        array.name, boxes.boxes.size(), array.num_tuples, stored_bytes));
    return array;
  }

 private:
  data::RelevantRuns read_runs(hid_t group, const std::string& place, ReadProgress& progress,
                               std::int64_t& stored_bytes) const {
    const auto background = hdf5_number(group, "background");
    if (!background)
      objects_.fail(fmt::format("{}: attribute 'background': expected a number", place));
    const std::int64_t num_runs = objects_.whole_number(
        objects_.numbers(group, place, "num_runs", 1)[0], place, "num_runs", kMaxNumBytes, 0);
    const std::int64_t num_relevant =
        objects_.whole_number(objects_.numbers(group, place, "num_relevant", 1)[0], place,
                              "num_relevant", kMaxNumBytes, 0);
    const data::SampleBox box{background->type, dims_};
    check_expansion(place, box);
    const auto counts = [&](const char* name, const std::vector<std::int64_t>& dims) {
      return counts_of(list(group, place, name, dims, progress, stored_bytes));
    };
    data::RunLists lists;
    lists.row_runs = counts("row_runs", {box.dims[2], box.dims[1]});
    if (num_runs > 0) {
      lists.starts = counts("starts", {num_runs});
      lists.lengths = counts("lengths", {num_runs});
    }
    DataArray values;
    if (num_relevant > 0) {
      values = list(group, place, "values", {num_relevant}, progress, stored_bytes);
      if (values.type != box.type) {
        objects_.fail(fmt::format("'{}/values' are {}: expected {}, as the background", place,
                                  name_of(values.type), name_of(box.type)));
      }
    }
    try {
      return {box, lists, values.bytes.view, background->bytes};
    } catch (const Error& error) {
      objects_.fail(fmt::format("'{}': {}", place, error.what()));
    }
  }

  LatticeLevels read_levels(hid_t group, const std::string& place, ScalarType type,
                            ReadProgress& progress, std::int64_t& stored_bytes) const {
    const auto number = [&](const char* name) {
      return objects_.numbers(group, place, name, 1)[0];
    };
    LatticeLevels levels;
    levels.dims = dims_;
    levels.offset = number("offset");
    levels.least = number("least");
    levels.greatest = number("greatest");
    levels.whole = !is_floating(type);
    levels.step = number("step");
    if (num_samples(levels.dims) > std::int64_t{std::numeric_limits<std::uint32_t>::max()})
      objects_.fail(fmt::format("{}: levels hold at most 2^32 samples", place),
                    ErrorCode::kUnsupported);
    levels.holes = read_holes(group, place, progress, stored_bytes);
    const std::int64_t num_levels = objects_.whole_number(number("num_levels"), place, "num_levels",
                                                          LatticeLevels::kMostLevels, 0);
    if (num_levels == 0) return levels;
    const std::vector<double> counts =
        objects_.numbers(group, place, "num_kernels", static_cast<std::size_t>(num_levels));
    for (int l = 0; l < static_cast<int>(num_levels); ++l) {
      const std::int64_t num_nodes = num_samples(levels.nodes(l));
      const std::int64_t count = objects_.whole_number(counts[static_cast<std::size_t>(l)], place,
                                                       "num_kernels", num_nodes, 0);
      levels.levels.push_back(
          read_level(group, place, l, count, num_nodes, progress, stored_bytes));
    }
    return levels;
  }

  LatticeLevel read_level(hid_t group, const std::string& place, int index, std::int64_t count,
                          std::int64_t num_nodes, ReadProgress& progress,
                          std::int64_t& stored_bytes) const {
    LatticeLevel level;
    if (count == 0) return level;
    const auto numbers = [&](const char* name, std::int64_t least, std::int64_t greatest) {
      return whole_numbers(list(group, place, fmt::format("{}{}", name, index).c_str(), {count},
                                progress, stored_bytes),
                           least, greatest);
    };
    std::int64_t node = -1;
    for (const std::int64_t gap : numbers("gaps", 0, num_nodes - 1)) {
      node += gap + 1;
      if (node >= num_nodes)
        objects_.fail(
            fmt::format("'{}/gaps{}': go beyond the level's {} nodes", place, index, num_nodes));
      level.nodes.push_back(static_cast<std::uint32_t>(node));
    }
    constexpr std::int64_t kMost = std::numeric_limits<std::int32_t>::max();
    for (const std::int64_t weight : numbers("weights", -kMost, kMost))
      level.weights.push_back(static_cast<std::int32_t>(weight));
    return level;
  }

  // None where the attribute is not there.
  std::vector<std::uint32_t> read_holes(hid_t group, const std::string& place,
                                        ReadProgress& progress, std::int64_t& stored_bytes) const {
    if (!has_hdf5_attribute(group, "num_holes")) return {};
    const std::int64_t count = num_samples(dims_);
    const std::int64_t num_holes = objects_.whole_number(
        objects_.numbers(group, place, "num_holes", 1)[0], place, "num_holes", (count + 1) / 2, 1);
    const std::vector<std::int64_t> lengths = whole_numbers(
        list(group, place, "holes", {2 * num_holes}, progress, stored_bytes), 0, count);
    return {lengths.begin(), lengths.end()};
  }

  LatticeBoxes read_boxes(hid_t group, const std::string& place, ScalarType type,
                          ReadProgress& progress, std::int64_t& stored_bytes) const {
    const auto number = [&](const char* name) {
      return objects_.numbers(group, place, name, 1)[0];
    };
    LatticeBoxes all;
    all.dims = dims_;
    all.least = number("least");
    all.greatest = number("greatest");
    all.background = number("background");
    all.whole = !is_floating(type);
    all.step = number("step");
    const std::int64_t count =
        objects_.whole_number(number("num_boxes"), place, "num_boxes", num_samples(all.dims), 0);
    if (count == 0) return all;
    for (const BoxNumber& kind : kBoxNumbers) {
      const std::vector<std::int64_t> numbers_read =
          whole_numbers(list(group, place, kind.name, {count}, progress, stored_bytes), kind.least,
                        kind.greatest.value_or(num_samples(all.dims)));
      all.boxes.resize(numbers_read.size());
      for (std::size_t i = 0; i < all.boxes.size(); ++i) kind.put(all.boxes[i], numbers_read[i]);
    }
    return all;
  }

  // Runs of nothing may stand for any number of samples; a claim is believed up to what files have
  // that hold something.
  void check_expansion(const std::string& place, const data::SampleBox& box) const {
    constexpr double kMostOfByte = 65536, kAlways = 64 << 20;
    const double num_bytes =
        static_cast<double>(num_samples(box.dims)) * static_cast<double>(size_of(box.type));
    if (num_bytes <= kAlways + kMostOfByte * static_cast<double>(objects_.source().size())) return;
    objects_.fail(
        fmt::format("'{}': {} from a file of {} bytes: expected at most {} for a byte", place,
                    layout_text(box.dims, box.type), objects_.source().size(), kMostOfByte),
        ErrorCode::kUnsupported);
  }

  // The samples' type, of levels or boxes.
  ScalarType type_of_content(hid_t group, const std::string& place) const {
    const auto least = hdf5_number(group, "least");
    if (!least || !are_simple_samples(least->type)) {
      objects_.fail(fmt::format(
          "{}: attribute 'least': expected a number, float32 or of 1 or 2 bytes", place));
    }
    check_expansion(place, {ScalarType::kFloat32, dims_});
    return least->type;
  }

  // Passed on, and counted: few numbers in the file stand for many samples.
  std::function<void(double)> counted_progress(std::int64_t num_samples) const {
    const auto num_bytes = static_cast<double>(num_samples) * sizeof(float);
    return [this, num_bytes, told = 0.0](double fraction) mutable {
      if (fraction > told && fraction <= 1)
        add_work_done(
            static_cast<std::int64_t>(num_bytes * (fraction - std::exchange(told, fraction))));
      if (options_.progress) options_.progress(fraction);
    };
  }

  // An array of that type of what make_samples() returns.
  template <class MakeSamples>
  DataArray dense(const std::string& place, DataArray description, ScalarType type,
                  const MakeSamples& make_samples) const {
    std::vector<float> values;
    try {
      values = make_samples();
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kInvalidArgument) throw;
      objects_.fail(fmt::format("'{}': {}", place, error.what()));
    }
    description.type = type;
    std::byte* to = nullptr;
    DataArray array = new_array(std::move(description), to);
    data::visit_scalar(type, [&]<class T>(std::type_identity<T>) {
      for (std::size_t i = 0; i < values.size(); ++i) {
        const T value = data::stored_number<T>(static_cast<double>(values[i]));
        std::memcpy(to + i * sizeof(T), &value, sizeof(T));
      }
    });
    return array;
  }

  // One of the datasets of runs or levels, if it has that shape.
  DataArray list(hid_t group, const std::string& group_place, const char* name,
                 const std::vector<std::int64_t>& dims, ReadProgress& progress,
                 std::int64_t& stored_bytes) const {
    const std::string place = fmt::format("{}/{}", group_place, name);
    const Hdf5Handle dataset = objects_.open(group, name, place, H5O_TYPE_DATASET);
    const Hdf5Extent extent = objects_.extent_of(dataset.get(), place);
    if (extent.dims != dims) {
      objects_.fail(fmt::format("'{}' has shape [{}]: expected [{}]", place,
                                fmt::join(extent.dims, ", "), fmt::join(dims, ", ")));
    }
    stored_bytes += static_cast<std::int64_t>(H5Dget_storage_size(dataset.get()));
    DataArray description;
    description.name = place;
    description.num_tuples = checked_product(dims).value_or(0);
    return objects_.samples(dataset.get(), extent, std::move(description), progress);
  }

  std::vector<std::uint32_t> counts_of(const DataArray& array) const {
    return data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
      std::vector<std::uint32_t> counts;
      counts.reserve(static_cast<std::size_t>(array.num_tuples));
      for (std::int64_t i = 0; i < array.num_tuples; ++i) {
        const auto number = static_cast<double>(data::load_scalar<T>(array.bytes.view.data(), i));
        if (!(number >= 0 && number <= static_cast<double>(kMaxAxisSize)))
          objects_.fail(
              fmt::format("'{}'[{}] = {}: expected 0 to {}", array.name, i, number, kMaxAxisSize));
        counts.push_back(static_cast<std::uint32_t>(number));
      }
      return counts;
    });
  }

  // Whole numbers of a list, within [least, greatest].
  std::vector<std::int64_t> whole_numbers(const DataArray& array, std::int64_t least,
                                          std::int64_t greatest) const {
    return data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
      std::vector<std::int64_t> numbers;
      numbers.reserve(static_cast<std::size_t>(array.num_tuples));
      for (std::int64_t i = 0; i < array.num_tuples; ++i) {
        const auto number = static_cast<double>(data::load_scalar<T>(array.bytes.view.data(), i));
        if (!(number >= static_cast<double>(least) && number <= static_cast<double>(greatest)))
          objects_.fail(fmt::format("'{}'[{}] = {}: expected {} to {}", array.name, i, number,
                                    least, greatest));
        numbers.push_back(static_cast<std::int64_t>(number));
      }
      return numbers;
    });
  }

  const Hdf5Objects& objects_;
  const Index3& dims_;
  const ReadOptions& options_;
  std::vector<std::string>* notes_;
};

}  // namespace

DataArray samples_of_runs(const Hdf5Packed& packed, DataArray description, ReadProgress& progress,
                          std::vector<std::string>* notes) {
  return Unpacker(packed, notes)
      .of_runs(packed.group, packed.place, std::move(description), progress);
}

DataArray samples_of_levels(const Hdf5Packed& packed, DataArray description, ReadProgress& progress,
                            std::vector<std::string>* notes) {
  return Unpacker(packed, notes)
      .of_levels(packed.group, packed.place, std::move(description), progress);
}

DataArray samples_of_boxes(const Hdf5Packed& packed, DataArray description, ReadProgress& progress,
                           std::vector<std::string>* notes) {
  return Unpacker(packed, notes)
      .of_boxes(packed.group, packed.place, std::move(description), progress);
}

}  // namespace ovoid::io

#endif
