// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/hdf5_lattice.h"

#include <fmt/format.h>

#include "ovoid/error.h"

#ifdef OVOID_IO_HDF5
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "data/scalar_visit.h"
#include "data/varies.h"
#include "io/core/point_arrays.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/foreign/hdf5_objects.h"
#include "io/foreign/hdf5_packed.h"
#include "io/foreign/hdf5_storage.h"
#include "io/hdf5/hdf5_lattice_format.h"
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
      : name_(path), source_(open_file(path)), objects_(path, *source_), options_(options) {
    file_ = {H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose};
    if (!file_.is_open()) objects_.fail("the HDF5 library cannot open it: is the file truncated?");
    root_ = {H5Gopen2(file_.get(), "/", H5P_DEFAULT), H5Gclose};
    if (!root_.is_open()) objects_.fail("the root group is broken");
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

  void read_header() {
    const hid_t root = root_.get();
    const std::string place = "root";
    const double version = objects_.numbers(root, place, "version", 1)[0];
    if (version > static_cast<double>(kHdf5LatticeVersion)) {
      objects_.fail(
          fmt::format("is version {} of a lattice file: expected {}: a later Ovoid wrote it",
                      version, kHdf5LatticeVersion),
          ErrorCode::kUnsupported);
    }
    objects_.whole_number(version, place, "version", kHdf5LatticeVersion);
    const std::string word = objects_.text(root, place, "lattice");
    const auto* const known =
        std::find_if(kHdf5LatticeWords.begin(), kHdf5LatticeWords.end(),
                     [&](const Hdf5LatticeWord& candidate) { return word == candidate.word; });
    if (known == kHdf5LatticeWords.end()) {
      objects_.fail(
          fmt::format("root: attribute 'lattice': '{}': expected cartesian, body-centred, cc4 or "
                      "d4star",
                      word));
    }
    LatticeGeometry& lattice = dataset_.lattice;
    lattice.kind = known->kind;
    dataset_.series = known->series;
    const std::vector<double> dims = objects_.numbers(root, place, "dims", 3);
    for (std::size_t a = 0; a < 3; ++a)
      lattice.dims[a] = objects_.whole_number(dims[a], place, "dims", kMaxAxisSize);
    checked_num_bytes(fmt::format("{}: root: attribute 'dims'", name_), lattice.dims,
                      ScalarType::kUInt8);
    const std::vector<double> rows = objects_.numbers(root, place, "world_from_index", 12);
    for (int i = 0; i < 12; ++i)
      lattice.world_from_index(i / 4, i % 4) = rows[static_cast<std::size_t>(i)];
    check_geometry(fmt::format("{}: root: attribute 'world_from_index'", name_),
                   lattice.world_from_index);
    read_space();
    dataset_.num_steps = objects_.count(root, place, "num_steps", std::int64_t{1} << 53);
    check_num_steps(name_, dataset_.num_steps);
  }

  void read_space() {
    const std::string word = objects_.text(root_.get(), "root", "space");
    for (const Space space : {Space::kNone, Space::kLps, Space::kRas}) {
      if (word != name_of(space)) continue;
      dataset_.space = space;
      return;
    }
    objects_.fail(fmt::format("root: attribute 'space': '{}': expected none, LPS or RAS", word));
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

  void read_times() {
    if (H5Lexists(root_.get(), "times", H5P_DEFAULT) <= 0) return;
    const Hdf5Handle times = objects_.open(root_.get(), "times", "times", H5O_TYPE_DATASET);
    const Hdf5Extent extent = objects_.extent_of(times.get(), "times");
    if (extent.dims != std::vector<std::int64_t>{dataset_.num_steps})
      objects_.fail(fmt::format("'times' has shape [{}]: expected [{}]",
                                fmt::join(extent.dims, ", "), dataset_.num_steps));
    ReadProgress progress(options_, 0);
    DataArray description;
    description.num_tuples = dataset_.num_steps;
    const DataArray array =
        floating_values(objects_.samples(times.get(), extent, std::move(description), progress));
    for (std::int64_t i = 0; i < dataset_.num_steps; ++i) {
      const double time =
          array.type == ScalarType::kFloat64
              ? data::load_scalar<double>(array.bytes.view.data(), i)
              : static_cast<double>(data::load_scalar<float>(array.bytes.view.data(), i));
      if (!std::isfinite(time))
        objects_.fail(fmt::format("times[{}] = {}: must be finite", i, time));
      dataset_.times.push_back(time);
    }
    if (dataset_.series == SeriesKind::kStaggered && !are_staggered_times(dataset_.times))
      objects_.fail(
          "times: must rise in equal distances, since every second step is of the other half");
    if (has_hdf5_attribute(times.get(), "unit"))
      dataset_.time_unit = objects_.text(times.get(), "times", "unit");
  }

  void open_arrays() {
    const std::int64_t num_arrays = objects_.count(root_.get(), "root", "num_arrays", kMaxArrays);
    std::string names;
    for (std::int64_t i = 0; i < num_arrays; ++i) {
      const std::string place = fmt::format("array{}", i);
      ArrayInFile stored{objects_.open(root_.get(), place, place, H5O_TYPE_GROUP), place, {}, {}};
      const hid_t group = stored.group.get();
      DataArray& array = stored.description;
      array.name = objects_.text(group, place, "name");
      names += fmt::format("{}'{}'", names.empty() ? "" : ", ", array.name);
      if (!options_.array.empty() && array.name != options_.array) continue;
      array.unit = has_hdf5_attribute(group, "unit") ? objects_.text(group, place, "unit") : "";
      array.num_components =
          static_cast<int>(objects_.count(group, place, "components", kMostComponents));
      array.value_scale = objects_.numbers(group, place, "value_scale", 1)[0];
      array.value_offset = objects_.numbers(group, place, "value_offset", 1)[0];
      if (array.value_scale == 0)
        objects_.fail(fmt::format("{}: attribute 'value_scale': must not be 0", place));
      array.num_tuples = num_samples(dataset_.lattice.dims);
      const std::string encoding = objects_.text(group, place, "encoding");
      const auto* const known =
          std::find_if(kEncodings.begin(), kEncodings.end(),
                       [&](const auto& candidate) { return encoding == candidate.second; });
      if (known == kEncodings.end()) {
        objects_.fail(
            fmt::format("{}: attribute 'encoding': '{}': expected dense, runs, levels or boxes",
                        place, encoding));
      }
      stored.encoding = known->first;
      if (stored.encoding != Encoding::kDense && array.num_components != 1) {
        objects_.fail(fmt::format("{}: has {} components: {} hold arrays of one", place,
                                  array.num_components, encoding));
      }
      const bool is_cartesian = dataset_.lattice.kind == LatticeKind::kCartesian;
      if ((stored.encoding == Encoding::kLevels || stored.encoding == Encoding::kBoxes) &&
          !is_cartesian)
        objects_.fail(fmt::format("{}: {} of a lattice that is not cartesian", place, encoding));
      check_steps(stored);
      arrays_.push_back(std::move(stored));
    }
    if (!arrays_.empty()) return;
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("array '{}': not in '{}', which has {}", options_.array, name_, names));
  }

  // A group of more members than steps belongs to a file whose number of steps, or names, are
  // wrong.
  void check_steps(const ArrayInFile& array) const {
    H5G_info_t members{};
    if (H5Gget_info(array.group.get(), &members) < 0)
      objects_.fail(fmt::format("group '{}' is broken", array.place));
    if (members.nlinks <= static_cast<hsize_t>(dataset_.num_steps)) return;
    objects_.fail(fmt::format("group '{}' has {} members: expected {}, one for each of num_steps",
                              array.place, members.nlinks, dataset_.num_steps));
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
      part.object =
          objects_.open(array.group.get(), name, part.place,
                        array.encoding == Encoding::kDense ? H5O_TYPE_DATASET : H5O_TYPE_GROUP);
      if (array.encoding == Encoding::kDense) {
        part.extent = objects_.extent_of(part.object.get(), part.place);
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
    const Hdf5Packed packed{objects_, object, place, dataset_.lattice.dims, options_};
    switch (encoding) {
      case Encoding::kDense:
        break;
      case Encoding::kRuns:
        return samples_of_runs(packed, description, progress, &storage_notes_);
      case Encoding::kLevels:
        return samples_of_levels(packed, description, progress, &storage_notes_);
      case Encoding::kBoxes:
        return samples_of_boxes(packed, description, progress, &storage_notes_);
    }
    return objects_.samples(object, extent, description, progress);
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
  Hdf5Objects objects_;
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
