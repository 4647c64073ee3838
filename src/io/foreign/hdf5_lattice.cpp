// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/hdf5_lattice.h"

#include <fmt/format.h>

#include "ovoid/error.h"

#ifdef OVOID_IO_HDF5
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "data/relevant_runs.h"
#include "data/scalar_visit.h"
#include "data/stored_number.h"
#include "data/varies.h"
#include "io/core/point_arrays.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/foreign/hdf5_file.h"
#include "io/foreign/hdf5_storage.h"
#include "io/hdf5/hdf5_lattice_format.h"
#include "io/hdf5/stored_boxes.h"
#include "ovoid/lattice_boxes.h"
#include "ovoid/lattice_levels.h"
#endif

namespace ovoid::io {

#ifdef OVOID_IO_HDF5
namespace {

constexpr std::int64_t kMaxArrays = 1000;
constexpr std::int64_t kMostComponents = std::int64_t{1} << 20;

// What the file says of an array, and where its steps are.
struct ArrayInFile {
  Hdf5Handle group;
  std::string place;  // "array0"
  enum class Encoding { kDense, kRuns, kLevels, kBoxes } encoding = Encoding::kDense;
  DataArray description;  // without type and samples
};

class LatticeReader {
 public:
  LatticeReader(const std::string& path, const ReadOptions& options)
      : name_(path), source_(open_file(path)), options_(options) {
    file_ = {H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
    if (!file_.is_open()) fail("the HDF5 library cannot open it: is the file truncated?");
    root_ = {H5Gopen2(file_.get(), "/", H5P_DEFAULT), H5Gclose};
    if (!root_.is_open()) fail("the root group is broken");
  }

  // Does the file say that it is a lattice file?
  bool is_lattice() const { return hdf5_text(root_.get(), "format") == kHdf5LatticeFormat; }

  Dataset read() {
    dataset_.source = name_;
    dataset_.kind = DatasetKind::kLattice;
    read_header();
    read_times();
    open_arrays();
    dataset_.format = fmt::format("HDF5 lattice, {}", word_of(arrays_.front().encoding));
    const bool is_search = !options_.step && dataset_.num_steps > 1;
    if (options_.step) check_step(name_, *options_.step, dataset_.num_steps);
    if (!is_search || !find_step()) read_step(options_.step.value_or(0));
    const bool is_shifted = dataset_.series == SeriesKind::kStaggered && dataset_.step % 2 != 0;
    if (is_shifted) dataset_.lattice.world_from_index.translate(Vec3::Constant(0.5));
    dataset_.notes.insert(dataset_.notes.end(), storage_notes_.begin(), storage_notes_.end());
    return std::move(dataset_);
  }

 private:
  using Encoding = ArrayInFile::Encoding;
  static constexpr std::array<std::pair<Encoding, const char*>, 4> kEncodings{
      {{Encoding::kDense, "dense"},
       {Encoding::kRuns, "runs"},
       {Encoding::kLevels, "levels"},
       {Encoding::kBoxes, "boxes"}}};
  static const char* word_of(Encoding encoding) {
    return kEncodings[static_cast<std::size_t>(encoding)].second;
  }

  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFileFormat) const {
    throw Error(code, fmt::format("{}: {}", name_, what));
  }

  std::string text(hid_t object, const std::string& place, const char* name) const {
    if (!has_hdf5_attribute(object, name))
      fail(fmt::format("{}: attribute '{}' is missing", place, name));
    if (auto text = hdf5_text(object, name)) return *text;
    fail(fmt::format("{}: attribute '{}': expected text of a fixed length, at most {} bytes", place,
                     name, kMaxHdf5Text));
  }

  std::vector<double> numbers(hid_t object, const std::string& place, const char* name,
                              std::size_t count) const {
    if (!has_hdf5_attribute(object, name))
      fail(fmt::format("{}: attribute '{}' is missing", place, name));
    std::vector<double> values = hdf5_numbers(object, name, count);
    if (values.size() != count) {
      fail(fmt::format("{}: attribute '{}': expected {} number{}", place, name, count,
                       count == 1 ? "" : "s"));
    }
    for (const double value : values) {
      if (!std::isfinite(value))
        fail(fmt::format("{}: attribute '{}': {}: must be finite", place, name, value));
    }
    return values;
  }

  std::int64_t whole_number(double value, const std::string& place, const char* name,
                            std::int64_t most, std::int64_t least = 1) const {
    if (value >= static_cast<double>(least) && value <= static_cast<double>(most) &&
        value == std::floor(value))
      return static_cast<std::int64_t>(value);
    fail(fmt::format("{}: attribute '{}': {}: expected a whole number from {} to {}", place, name,
                     value, least, most));
  }
  std::int64_t count(hid_t object, const std::string& place, const char* name,
                     std::int64_t most) const {
    return whole_number(numbers(object, place, name, 1)[0], place, name, most);
  }

  void read_header() {
    const hid_t root = root_.get();
    const std::string place = "root";
    const double version = numbers(root, place, "version", 1)[0];
    if (version > static_cast<double>(kHdf5LatticeVersion)) {
      fail(fmt::format("is version {} of a lattice file: expected {}: a later Ovoid wrote it",
                       version, kHdf5LatticeVersion),
           ErrorCode::kUnsupported);
    }
    whole_number(version, place, "version", kHdf5LatticeVersion);
    const std::string word = text(root, place, "lattice");
    const auto* const known =
        std::find_if(kHdf5LatticeWords.begin(), kHdf5LatticeWords.end(),
                     [&](const Hdf5LatticeWord& candidate) { return word == candidate.word; });
    if (known == kHdf5LatticeWords.end()) {
      fail(
          fmt::format("root: attribute 'lattice': '{}': expected cartesian, body-centred, cc4 or "
                      "d4star",
                      word));
    }
    LatticeGeometry& lattice = dataset_.lattice;
    lattice.kind = known->kind;
    dataset_.series = known->series;
    const std::vector<double> dims = numbers(root, place, "dims", 3);
    for (std::size_t a = 0; a < 3; ++a)
      lattice.dims[a] = whole_number(dims[a], place, "dims", kMaxAxisSize);
    checked_num_bytes(fmt::format("{}: root: attribute 'dims'", name_), lattice.dims,
                      ScalarType::kUInt8);
    const std::vector<double> rows = numbers(root, place, "world_from_index", 12);
    for (int i = 0; i < 12; ++i)
      lattice.world_from_index(i / 4, i % 4) = rows[static_cast<std::size_t>(i)];
    check_geometry(fmt::format("{}: root: attribute 'world_from_index'", name_),
                   lattice.world_from_index);
    read_space();
    dataset_.num_steps = count(root, place, "num_steps", std::int64_t{1} << 53);
    check_num_steps(name_, dataset_.num_steps);
  }

  void read_space() {
    const std::string word = text(root_.get(), "root", "space");
    for (const Space space : {Space::kNone, Space::kLps, Space::kRas}) {
      if (word != name_of(space)) continue;
      dataset_.space = space;
      return;
    }
    fail(fmt::format("root: attribute 'space': '{}': expected none, LPS or RAS", word));
  }

  // An object by its name in a group, if it is of the file's own and of that type.
  Hdf5Handle open(hid_t group, const std::string& name, const std::string& place,
                  H5O_type_t type) const {
    const bool is_group = type == H5O_TYPE_GROUP;
    H5O_info_t info{};
    if (!is_hard_link(group, name) ||
        H5Oget_info_by_name(group, name.c_str(), &info, H5P_DEFAULT) < 0 || info.type != type)
      fail(fmt::format("{} '{}' is missing", is_group ? "group" : "dataset", place));
    Hdf5Handle object(H5Oopen(group, name.c_str(), H5P_DEFAULT), H5Oclose);
    if (!object.is_open())
      fail(fmt::format("{} '{}' is broken", is_group ? "group" : "dataset", place));
    return object;
  }

  // What a dataset of numbers holds, checked against the file.
  Hdf5Extent extent_of(hid_t dataset, const std::string& place) const {
    Hdf5Extent extent;
    extent.where = fmt::format("{}: '{}'", name_, place);
    const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
    const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
    const auto known = type.is_open() ? hdf5_type_of(type.get()) : std::nullopt;
    if (!known) fail(fmt::format("'{}' holds no integers or IEEE floats", place));
    extent.type = *known;
    const int rank = space.is_open() ? H5Sget_simple_extent_ndims(space.get()) : -1;
    std::array<hsize_t, Hdf5Extent::kMaxRank> dims{};
    if (rank < 1 || rank > static_cast<int>(dims.size()) ||
        H5Sget_simple_extent_dims(space.get(), dims.data(), nullptr) != rank)
      fail(fmt::format("'{}': expected 1 to {} axes", place, dims.size()));
    for (int i = 0; i < rank; ++i) {
      extent.dims.push_back(static_cast<std::int64_t>(
          std::min(dims[static_cast<std::size_t>(i)], static_cast<hsize_t>(kMaxNumBytes))));
    }
    checked_num_bytes(extent.where, extent.dims, extent.type.type);
    check_hdf5_storage(dataset, extent, *source_);
    return extent;
  }

  // The array without its samples, if memory does not hold them and they may stay in the file.
  std::optional<DataArray> left_in_file(hid_t dataset, const Hdf5Extent& extent,
                                        const ArrayInFile& array) const {
    const bool is_chosen = options_.step || dataset_.num_steps == 1;
    if (!is_chosen || array.encoding != Encoding::kDense || array.description.num_components != 1 ||
        !stays_in_file(extent.type.type, extent.num_bytes(), options_))
      return std::nullopt;
    const std::optional<StoredPlace> place = place_of_hdf5_storage(file_.get(), dataset, extent);
    if (!place) return std::nullopt;
    DataArray left = array.description;
    left.type = extent.type.type;
    left.stored = samples_told(*place);
    return left;
  }

  DataArray samples(hid_t dataset, const Hdf5Extent& extent, DataArray description,
                    ReadProgress& progress) const {
    description.type = extent.type.type;
    std::byte* to = nullptr;
    DataArray array = new_array(std::move(description), to);
    read_hdf5_storage(dataset, extent, to, progress);
    return array;
  }

  void read_times() {
    if (H5Lexists(root_.get(), "times", H5P_DEFAULT) <= 0) return;
    const Hdf5Handle times = open(root_.get(), "times", "times", H5O_TYPE_DATASET);
    const Hdf5Extent extent = extent_of(times.get(), "times");
    if (extent.dims != std::vector<std::int64_t>{dataset_.num_steps})
      fail(fmt::format("'times' has shape [{}]: expected [{}]", fmt::join(extent.dims, ", "),
                       dataset_.num_steps));
    ReadProgress progress(options_, 0);
    DataArray description;
    description.num_tuples = dataset_.num_steps;
    const DataArray array =
        floating_values(samples(times.get(), extent, std::move(description), progress));
    for (std::int64_t i = 0; i < dataset_.num_steps; ++i) {
      const double time =
          array.type == ScalarType::kFloat64
              ? data::load_scalar<double>(array.bytes.view.data(), i)
              : static_cast<double>(data::load_scalar<float>(array.bytes.view.data(), i));
      if (!std::isfinite(time)) fail(fmt::format("times[{}] = {}: must be finite", i, time));
      dataset_.times.push_back(time);
    }
    if (dataset_.series == SeriesKind::kStaggered && !are_staggered_times(dataset_.times))
      fail("times: must rise in equal distances, since every second step is of the other half");
    if (has_hdf5_attribute(times.get(), "unit"))
      dataset_.time_unit = text(times.get(), "times", "unit");
  }

  void open_arrays() {
    const std::int64_t num_arrays = count(root_.get(), "root", "num_arrays", kMaxArrays);
    std::string names;
    for (std::int64_t i = 0; i < num_arrays; ++i) {
      const std::string place = fmt::format("array{}", i);
      ArrayInFile stored{open(root_.get(), place, place, H5O_TYPE_GROUP), place, {}, {}};
      const hid_t group = stored.group.get();
      DataArray& array = stored.description;
      array.name = text(group, place, "name");
      names += fmt::format("{}'{}'", names.empty() ? "" : ", ", array.name);
      if (!options_.array.empty() && array.name != options_.array) continue;
      array.unit = has_hdf5_attribute(group, "unit") ? text(group, place, "unit") : "";
      array.num_components = static_cast<int>(count(group, place, "components", kMostComponents));
      array.value_scale = numbers(group, place, "value_scale", 1)[0];
      array.value_offset = numbers(group, place, "value_offset", 1)[0];
      if (array.value_scale == 0)
        fail(fmt::format("{}: attribute 'value_scale': must not be 0", place));
      array.num_tuples = num_samples(dataset_.lattice.dims);
      const std::string encoding = text(group, place, "encoding");
      const auto* const known =
          std::find_if(kEncodings.begin(), kEncodings.end(),
                       [&](const auto& candidate) { return encoding == candidate.second; });
      if (known == kEncodings.end()) {
        fail(fmt::format("{}: attribute 'encoding': '{}': expected dense, runs, levels or boxes",
                         place, encoding));
      }
      stored.encoding = known->first;
      if (stored.encoding != Encoding::kDense && array.num_components != 1) {
        fail(fmt::format("{}: has {} components: {} hold arrays of one", place,
                         array.num_components, encoding));
      }
      const bool is_cartesian = dataset_.lattice.kind == LatticeKind::kCartesian;
      if ((stored.encoding == Encoding::kLevels || stored.encoding == Encoding::kBoxes) &&
          !is_cartesian)
        fail(fmt::format("{}: {} of a lattice that is not cartesian", place, encoding));
      arrays_.push_back(std::move(stored));
    }
    if (!arrays_.empty()) return;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("array '{}': not in '{}', which has {}", options_.array, name_, names));
  }

  // Reads steps until one varies.
  bool find_step() {
    for (std::int64_t step = 0; step < dataset_.num_steps; ++step) {
      read_step(step);
      if (!std::any_of(dataset_.arrays.begin(), dataset_.arrays.end(), data::varies)) continue;
      dataset_.notes.push_back(chosen_step_note(name_, step, dataset_.num_steps));
      return true;
    }
    return false;
  }

  void read_step(std::int64_t step) {
    dataset_.step = step;
    dataset_.arrays.clear();
    storage_notes_.clear();
    struct Part {
      Hdf5Handle object;
      std::string place;
      Hdf5Extent extent;  // dense
    };
    std::vector<Part> parts;
    std::int64_t num_bytes = 0;
    for (const ArrayInFile& array : arrays_) {
      const std::string name = fmt::format("step{}", step);
      Part part{{}, fmt::format("{}/{}", array.place, name), {}};
      part.object = open(array.group.get(), name, part.place,
                         array.encoding == Encoding::kDense ? H5O_TYPE_DATASET : H5O_TYPE_GROUP);
      if (array.encoding == Encoding::kDense) {
        part.extent = extent_of(part.object.get(), part.place);
        check_shape(part.extent, array.description.num_components);
        num_bytes += part.extent.num_bytes();
      }
      parts.push_back(std::move(part));
    }
    ReadProgress progress(options_, num_bytes);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const hid_t object = parts[i].object.get();
      const DataArray& description = arrays_[i].description;
      if (std::optional<DataArray> left = left_in_file(object, parts[i].extent, arrays_[i])) {
        dataset_.arrays.push_back(std::move(*left));
        continue;
      }
      dataset_.arrays.push_back(read_samples(object, parts[i].place, parts[i].extent,
                                             arrays_[i].encoding, description, progress));
    }
  }

  DataArray read_samples(hid_t object, const std::string& place, const Hdf5Extent& extent,
                         Encoding encoding, const DataArray& description, ReadProgress& progress) {
    switch (encoding) {
      case Encoding::kDense:
        break;
      case Encoding::kRuns:
        return dense_of_runs(object, place, description, progress);
      case Encoding::kLevels:
        return dense_of_levels(object, place, description, progress);
      case Encoding::kBoxes:
        return dense_of_boxes(object, place, description, progress);
    }
    return samples(object, extent, description, progress);
  }

  // One of the datasets of runs or levels, if it has that shape.
  DataArray list(hid_t group, const std::string& group_place, const char* name,
                 const std::vector<std::int64_t>& dims, ReadProgress& progress,
                 std::int64_t& stored_bytes) const {
    const std::string place = fmt::format("{}/{}", group_place, name);
    const Hdf5Handle dataset = open(group, name, place, H5O_TYPE_DATASET);
    const Hdf5Extent extent = extent_of(dataset.get(), place);
    if (extent.dims != dims) {
      fail(fmt::format("'{}' has shape [{}]: expected [{}]", place, fmt::join(extent.dims, ", "),
                       fmt::join(dims, ", ")));
    }
    stored_bytes += static_cast<std::int64_t>(H5Dget_storage_size(dataset.get()));
    DataArray description;
    description.name = place;
    description.num_tuples = checked_product(dims).value_or(0);
    return samples(dataset.get(), extent, std::move(description), progress);
  }

  std::vector<std::uint32_t> counts_of(const DataArray& array) const {
    return data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
      std::vector<std::uint32_t> counts;
      counts.reserve(static_cast<std::size_t>(array.num_tuples));
      for (std::int64_t i = 0; i < array.num_tuples; ++i) {
        const auto number = static_cast<double>(data::load_scalar<T>(array.bytes.view.data(), i));
        if (!(number >= 0 && number <= static_cast<double>(kMaxAxisSize)))
          fail(fmt::format("'{}'[{}] = {}: expected 0 to {}", array.name, i, number, kMaxAxisSize));
        counts.push_back(static_cast<std::uint32_t>(number));
      }
      return counts;
    });
  }

  data::RelevantRuns read_runs(hid_t group, const std::string& place, ReadProgress& progress,
                               std::int64_t& stored_bytes) const {
    const auto background = hdf5_number(group, "background");
    if (!background) fail(fmt::format("{}: attribute 'background': expected a number", place));
    const std::int64_t num_runs =
        whole_number(numbers(group, place, "num_runs", 1)[0], place, "num_runs", kMaxNumBytes, 0);
    const std::int64_t num_relevant = whole_number(numbers(group, place, "num_relevant", 1)[0],
                                                   place, "num_relevant", kMaxNumBytes, 0);
    const data::SampleBox box{background->type, dataset_.lattice.dims};
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
        fail(fmt::format("'{}/values' are {}: expected {}, as the background", place,
                         name_of(values.type), name_of(box.type)));
      }
    }
    try {
      return {box, lists, values.bytes.view, background->bytes};
    } catch (const Error& error) {
      fail(fmt::format("'{}': {}", place, error.what()));
    }
  }

  // Runs of nothing may stand for any number of samples; a claim is believed up to what files have
  // that hold something.
  void check_expansion(const std::string& place, const data::SampleBox& box) const {
    constexpr double kMostOfByte = 65536, kAlways = 64 << 20;
    const double num_bytes =
        static_cast<double>(num_samples(box.dims)) * static_cast<double>(size_of(box.type));
    if (num_bytes <= kAlways + kMostOfByte * static_cast<double>(source_->size())) return;
    fail(fmt::format("'{}': {} from a file of {} bytes: expected at most {} for a byte", place,
                     layout_text(box.dims, box.type), source_->size(), kMostOfByte),
         ErrorCode::kUnsupported);
  }

  DataArray dense_of_runs(hid_t group, const std::string& place, DataArray description,
                          ReadProgress& progress) {
    std::int64_t stored_bytes = 0;
    const data::RelevantRuns runs = read_runs(group, place, progress, stored_bytes);
    description.type = runs.box().type;
    std::byte* to = nullptr;
    DataArray array = new_array(std::move(description), to);
    runs.decode({0, 0, 0}, runs.box().dims, to);
    storage_notes_.push_back(fmt::format(
        "{}: '{}' is stored as runs: {} of {} samples ({:.1f} %) in {} runs, {} bytes in the "
        "file; the others are {:g}",
        name_, array.name, runs.num_relevant(), array.num_tuples,
        100.0 * static_cast<double>(runs.num_relevant()) / static_cast<double>(array.num_tuples),
        runs.num_runs(), stored_bytes, runs.background() * array.value_scale + array.value_offset));
    return array;
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
          fail(fmt::format("'{}'[{}] = {}: expected {} to {}", array.name, i, number, least,
                           greatest));
        numbers.push_back(static_cast<std::int64_t>(number));
      }
      return numbers;
    });
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
        fail(fmt::format("'{}/gaps{}': go beyond the level's {} nodes", place, index, num_nodes));
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
    const std::int64_t count = num_samples(dataset_.lattice.dims);
    const std::int64_t num_holes = whole_number(numbers(group, place, "num_holes", 1)[0], place,
                                                "num_holes", (count + 1) / 2, 1);
    const std::vector<std::int64_t> lengths = whole_numbers(
        list(group, place, "holes", {2 * num_holes}, progress, stored_bytes), 0, count);
    return {lengths.begin(), lengths.end()};
  }

  LatticeLevels read_levels(hid_t group, const std::string& place, ScalarType type,
                            ReadProgress& progress, std::int64_t& stored_bytes) const {
    const auto number = [&](const char* name) { return numbers(group, place, name, 1)[0]; };
    LatticeLevels levels;
    levels.dims = dataset_.lattice.dims;
    levels.offset = number("offset");
    levels.least = number("least");
    levels.greatest = number("greatest");
    levels.whole = !is_floating(type);
    levels.step = number("step");
    if (num_samples(levels.dims) > std::int64_t{std::numeric_limits<std::uint32_t>::max()})
      fail(fmt::format("{}: levels hold at most 2^32 samples", place), ErrorCode::kUnsupported);
    levels.holes = read_holes(group, place, progress, stored_bytes);
    const std::int64_t num_levels =
        whole_number(number("num_levels"), place, "num_levels", LatticeLevels::kMostLevels, 0);
    if (num_levels == 0) return levels;
    const std::vector<double> counts =
        numbers(group, place, "num_kernels", static_cast<std::size_t>(num_levels));
    for (int l = 0; l < static_cast<int>(num_levels); ++l) {
      const std::int64_t num_nodes = num_samples(levels.nodes(l));
      const std::int64_t count =
          whole_number(counts[static_cast<std::size_t>(l)], place, "num_kernels", num_nodes, 0);
      levels.levels.push_back(
          read_level(group, place, l, count, num_nodes, progress, stored_bytes));
    }
    return levels;
  }

  DataArray dense_of_levels(hid_t group, const std::string& place, DataArray description,
                            ReadProgress& progress) {
    const ScalarType type = type_of_content(group, place);
    std::int64_t stored_bytes = 0;
    const LatticeLevels levels = read_levels(group, place, type, progress, stored_bytes);
    DataArray array = dense(place, std::move(description), type, [&] {
      return samples_of(levels, 0, options_.stop, options_.progress);
    });
    storage_notes_.push_back(
        fmt::format("{}: '{}' is stored as levels: {} kernels for {} samples, {} bytes in the file",
                    name_, array.name, levels.num_kernels(), array.num_tuples, stored_bytes));
    return array;
  }

  DataArray dense_of_boxes(hid_t group, const std::string& place, DataArray description,
                           ReadProgress& progress) {
    const ScalarType type = type_of_content(group, place);
    std::int64_t stored_bytes = 0;
    const LatticeBoxes boxes = read_boxes(group, place, type, progress, stored_bytes);
    DataArray array = dense(place, std::move(description), type,
                            [&] { return samples_of(boxes, options_.stop, options_.progress); });
    storage_notes_.push_back(
        fmt::format("{}: '{}' is stored as boxes: {} for {} samples, {} bytes in the file", name_,
                    array.name, boxes.boxes.size(), array.num_tuples, stored_bytes));
    return array;
  }

  LatticeBoxes read_boxes(hid_t group, const std::string& place, ScalarType type,
                          ReadProgress& progress, std::int64_t& stored_bytes) const {
    const auto number = [&](const char* name) { return numbers(group, place, name, 1)[0]; };
    LatticeBoxes all;
    all.dims = dataset_.lattice.dims;
    all.least = number("least");
    all.greatest = number("greatest");
    all.background = number("background");
    all.whole = !is_floating(type);
    all.step = number("step");
    const std::int64_t count =
        whole_number(number("num_boxes"), place, "num_boxes", num_samples(all.dims), 0);
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

  // The samples' type, of levels or boxes.
  ScalarType type_of_content(hid_t group, const std::string& place) const {
    const auto least = hdf5_number(group, "least");
    if (!least || !are_simple_samples(least->type)) {
      fail(fmt::format("{}: attribute 'least': expected a number, float32 or of 1 or 2 bytes",
                       place));
    }
    check_expansion(place, {ScalarType::kFloat32, dataset_.lattice.dims});
    return least->type;
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
      fail(fmt::format("'{}': {}", place, error.what()));
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

  void check_shape(const Hdf5Extent& extent, int num_components) const {
    const Index3& dims = dataset_.lattice.dims;
    std::vector<std::int64_t> expected{dims[2], dims[1], dims[0]};
    if (num_components > 1) expected.push_back(num_components);
    if (extent.dims == expected) return;
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{} has shape [{}]: expected [{}]", extent.where,
                            fmt::join(extent.dims, ", "), fmt::join(expected, ", ")));
  }

  std::string name_;
  std::unique_ptr<ByteSource> source_;
  const ReadOptions& options_;
  Hdf5Silence silence_;
  Hdf5Handle file_, root_;
  std::vector<ArrayInFile> arrays_;
  std::vector<std::string> storage_notes_;  // of the step that was read last
  Dataset dataset_;
};

}  // namespace

bool is_hdf5_lattice(const ByteSource& source) {
  try {
    return LatticeReader(source.name(), {}).is_lattice();
  } catch (const Error&) {
    return false;  // whatever is wrong with it, it does not say so
  }
}

Dataset read_hdf5_lattice(const ByteSource& source, const ReadOptions& options) {
  return LatticeReader(source.name(), options).read();
}

#endif

}  // namespace ovoid::io
