// SPDX-License-Identifier: Apache-2.0
#include "io/images/npz_volume.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <type_traits>
#include <utility>

#include "data/names_text.h"
#include "data/scalar_visit.h"
#include "io/core/axis_order.h"
#include "io/core/chunked_array.h"
#include "io/core/samples.h"
#include "io/core/short_floats.h"
#include "io/core/text_scanner.h"
#include "io/images/npy.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// An array that may be a lattice, or one of its channels.
struct VolumeEntry {
  const ZipEntry* entry = nullptr;
  NpyHeader header;
  std::string axes;
  std::array<std::int64_t, 4> sizes{1, 1, 1, 1};  // along x, y, z and time

  double num_samples() const {
    double product = 1;
    for (const std::int64_t size : sizes) product *= static_cast<double>(size);
    return product;
  }
};

std::vector<double> numbers_of(const DataArray& array) {
  std::vector<double> numbers;
  data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
    for (std::int64_t i = 0; i < array.num_tuples; ++i)
      numbers.push_back(static_cast<double>(data::load_scalar<T>(array.bytes.view.data(), i)));
  });
  return numbers;
}

class NpzVolumeReader {
 public:
  NpzVolumeReader(const ByteSource& source, const std::vector<ZipEntry>& entries,
                  const ReadOptions& options)
      : source_(source), entries_(entries), options_(options) {}

  Dataset read() {
    dataset_.source = source_.name();
    dataset_.format = "NPZ";
    for (const ZipEntry& entry : entries_) look_at(entry);
    const std::vector<VolumeEntry> chosen = choose();
    place(chosen[0].axes);
    tell_others();
    read_arrays(chosen);
    return std::move(dataset_);
  }

 private:
  void note(const std::string& what) {
    dataset_.notes.push_back(fmt::format("{}: {}", source_.name(), what));
  }

  void look_at(const ZipEntry& entry) {
    const std::string name(npz_array_name(entry.name));
    try {
      std::optional<NpyHeader> header = npz_header(source_, entry);
      if (!header) return others_.push_back(name);
      has_arrays_ = true;
      if (keep_place(entry, *header)) return;
      const std::string axes = axes_of(*header);
      npy_type_of(source_.name(), header->descr);
      if (axes.empty()) return others_.push_back(name);
      VolumeEntry volume{&entry, std::move(*header), axes};
      constexpr std::string_view kLetters = "xyzt";
      for (std::size_t i = 0; i < kLetters.size(); ++i)
        if (const auto axis = axis_place(axes, kLetters[i]))
          volume.sizes[i] = volume.header.shape[*axis];
      volumes_.push_back(std::move(volume));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kUnsupported) throw;
      has_arrays_ = true;
      const std::string what = error.what();
      const std::size_t begin = what.find("descr: ");
      note(fmt::format("{} is left out: {}", data::name_text(name),
                       begin == std::string::npos ? what : what.substr(begin)));
    }
  }

  // What the axes of a volume are; empty for what is none. A table's columns and points are none:
  // two axes of space at least have more than one sample.
  std::string axes_of(const NpyHeader& header) const {
    const auto& shape = header.shape;
    if (std::any_of(shape.begin(), shape.end(), [](std::int64_t size) { return size < 1; }))
      return {};
    std::string axes;
    if (options_.raw.axis_order.empty()) {
      if (shape.size() > 2) axes = usual_axis_order(shape).value_or("");
    } else {
      axes = order_with_passed_axes(options_.raw.axis_order, shape);
      if (axes.size() != shape.size()) return {};
      check_axis_order(source_.name(), axes, shape);
    }
    int num_long = 0;
    for (const char letter : {'x', 'y', 'z'}) {
      const auto axis = axis_place(axes, letter);
      if (axis && shape[*axis] > 1) ++num_long;
    }
    return num_long >= 2 ? axes : std::string();
  }

  // Those of one size: of the array that is asked for, or with most samples.
  std::vector<VolumeEntry> choose() {
    if (volumes_.empty() && !has_arrays_) {
      throw Error(ErrorCode::kUnsupported,
                  fmt::format("{}: is a zip file without arrays of NumPy's (.npy); it has {}",
                              source_.name(), data::names_text(others_)));
    }
    if (volumes_.empty() && others_.empty() && !dataset_.notes.empty())
      throw Error(ErrorCode::kUnsupported, dataset_.notes.front());
    if (volumes_.empty()) {
      throw Error(
          ErrorCode::kFileFormat,
          fmt::format("{}: has neither an array 'positions' of shape (N, 3) nor a volume of "
                      "three axes; it has {}",
                      source_.name(), data::names_text(others_)));
    }
    const auto name = [](const VolumeEntry& volume) { return npz_array_name(volume.entry->name); };
    auto best = std::find_if(volumes_.begin(), volumes_.end(), [&](const VolumeEntry& volume) {
      return !options_.array.empty() && options_.array == name(volume);
    });
    const bool is_named = best != volumes_.end();
    if (!is_named) {
      best = std::max_element(volumes_.begin(), volumes_.end(),
                              [](const VolumeEntry& a, const VolumeEntry& b) {
                                return a.num_samples() < b.num_samples();
                              });
    }
    const std::array<std::int64_t, 4> sizes = best->sizes;
    std::vector<VolumeEntry> chosen;
    std::vector<std::string> left_out;
    for (VolumeEntry& volume : volumes_) {
      if (volume.sizes != sizes)
        left_out.emplace_back(name(volume));
      else if (!is_named || options_.array == name(volume))
        chosen.push_back(std::move(volume));
    }
    if (!left_out.empty() && !is_named) {
      note(fmt::format("volumes of another size are left out: {}; choose with --array",
                       data::names_text(left_out)));
    }
    return chosen;
  }

  void read_arrays(const std::vector<VolumeEntry>& chosen) {
    std::vector<ChunkedArray> arrays;
    for (const VolumeEntry& volume : chosen) {
      const auto member = std::make_shared<ZipMember>(open_zip_entry(source_, *volume.entry));
      ChunkedArray array =
          npy_array(std::shared_ptr<const ByteSource>(member, member->source.get()), volume.header,
                    volume.axes, dataset_.notes);
      array.name = npz_array_name(volume.entry->name);
      if (options_.raw.axis_order.empty() && volume.axes.size() > 3) {
        note(fmt::format("{}: shape ({}) taken as {}; --axis-order says another",
                         data::name_text(array.name), fmt::join(volume.header.shape, ", "),
                         axis_names(volume.axes)));
      }
      arrays.push_back(std::move(array));
    }
    ReadOptions options = options_;
    options.may_stay_in_file = false;  // what is unpacked is this reader's
    shorten_notes(dataset_.notes);
    read_chunked(arrays, options, dataset_);
  }

  void tell_others() {
    if (others_.empty()) return;
    note(fmt::format("what is no volume is left out: {}", data::names_text(others_)));
  }

  // --- places
  // -------------------------------------------------------------------------------------

  enum PlaceKey : std::size_t { kSpacing, kOrigin, kDirection, kAffine, kNumKeys };

  // Keeps the numbers of a small array that is called like a place.
  bool keep_place(const ZipEntry& entry, const NpyHeader& header) {
    const std::string name = lower(npz_array_name(entry.name));
    const auto key =
        name == "spacing" || name == "voxel_size" || name == "voxelsize" || name == "voxel_spacing"
            ? kSpacing
        : name == "origin"    ? kOrigin
        : name == "direction" ? kDirection
        : name == "affine"    ? kAffine
                              : kNumKeys;
    constexpr std::int64_t kMostNumbers = 16;
    const auto count = checked_product(header.shape);
    if (key == kNumKeys || header.shape.empty() || header.shape.size() > 2 || !count ||
        *count < 1 || *count > kMostNumbers)
      return false;
    const ZipMember member = open_zip_entry(source_, entry);
    NpySamples read = read_npy_samples(*member.source, {});
    DataArray array;
    array.type = read.type.type;
    array.num_tuples = *count;
    array.bytes = read.samples.release();
    widen_short_floats(read.type.short_float, array);
    std::vector<double> numbers = numbers_of(array);
    if (header.is_fortran_order && header.shape.size() == 2) {
      std::vector<double> columns = numbers;
      const auto rows = static_cast<std::size_t>(header.shape[0]);
      const std::size_t width = numbers.size() / rows;
      for (std::size_t i = 0; i < numbers.size(); ++i)
        numbers[(i % rows) * width + i / rows] = columns[i];
    }
    places_[key] = {std::string(npz_array_name(entry.name)), std::move(numbers)};
    return true;
  }

  void place(const std::string& axes) {
    Affine3& world = dataset_.lattice.world_from_index;
    if (options_.raw.spacing) {
      world.linear() = options_.raw.spacing->asDiagonal();
      check_geometry("spacing", world);
      return;
    }
    const std::string used =
        !places_[kAffine].second.empty() ? place_by_affine(axes) : place_along_axes();
    if (used.empty()) return;
    try {
      check_geometry(source_.name(), world);
      note(used);
    } catch (const Error&) {
      world = Affine3::Identity();
      note("its arrays of places (spacing, origin, affine) are degenerate and not used");
    }
  }

  // The columns of a matrix are those of the array's axes, in their order.
  std::string place_by_affine(const std::string& axes) {
    const std::vector<double>& numbers = places_[kAffine].second;
    std::string space;
    for (const char letter : axes)
      if (letter == 'x' || letter == 'y' || letter == 'z') space += letter;
    if ((numbers.size() != 12 && numbers.size() != 16) || space.size() != 3) return {};
    Affine3& world = dataset_.lattice.world_from_index;
    for (Eigen::Index row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column)
        world.linear()(row, space[column] - 'x') =
            numbers[static_cast<std::size_t>(row) * 4 + column];
      world.translation()[row] = numbers[static_cast<std::size_t>(row) * 4 + 3];
    }
    return fmt::format("'{}' places the samples, its columns as the array's axes ({})",
                       places_[kAffine].first, fmt::join(space, ", "));
  }

  // Along x, y and z, as programs of medicine keep them beside an array of (z, y, x).
  std::string place_along_axes() {
    const std::vector<double>& spacing = places_[kSpacing].second;
    const std::vector<double>& origin = places_[kOrigin].second;
    const std::vector<double>& direction = places_[kDirection].second;
    Affine3& world = dataset_.lattice.world_from_index;
    std::vector<std::string> used;
    if (direction.size() == 9) {
      world.linear() =
          Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(direction.data());
      used.push_back(places_[kDirection].first);
    }
    if (spacing.size() == 3 || spacing.size() == 1) {
      const Vec3 lengths = spacing.size() == 3 ? Vec3(spacing.data()) : Vec3::Constant(spacing[0]);
      world.linear() = world.linear() * lengths.asDiagonal();
      used.push_back(places_[kSpacing].first);
    }
    if (origin.size() == 3) {
      world.translation() = Vec3(origin.data());
      used.push_back(places_[kOrigin].first);
    }
    if (used.empty()) return {};
    return fmt::format("{} {} the samples, as numbers along x, y and z; --spacing says others",
                       data::names_text(used), used.size() == 1 ? "places" : "place");
  }

  const ByteSource& source_;
  const std::vector<ZipEntry>& entries_;
  const ReadOptions& options_;
  Dataset dataset_;
  std::vector<VolumeEntry> volumes_;
  std::vector<std::string> others_;
  bool has_arrays_ = false;
  std::array<std::pair<std::string, std::vector<double>>, kNumKeys> places_;
};

}  // namespace

std::string_view npz_array_name(std::string_view entry) {
  if (entry.ends_with(".npy")) entry.remove_suffix(4);
  return entry;
}

std::optional<NpyHeader> npz_header(const ByteSource& source, const ZipEntry& entry) {
  // Nearly all headers have less; the longest that are read have 64 KiB.
  constexpr std::int64_t kUsual = 1024, kLongest = 70'000;
  std::string start = zip_entry_start(source, entry, kUsual);
  if (!looks_like_npy(start)) return std::nullopt;
  const std::string name = fmt::format("{}: {}", source.name(), entry.name.substr(0, 80));
  if (start.find('\n') == std::string::npos && entry.size > kUsual)
    start = zip_entry_start(source, entry, kLongest);
  return read_npy_header(*open_memory(name, std::as_bytes(std::span(start))));
}

Dataset read_npz_volume(const ByteSource& source, const std::vector<ZipEntry>& entries,
                        const ReadOptions& options) {
  return NpzVolumeReader(source, entries, options).read();
}

void refuse_other_zip(const ByteSource& source, const std::vector<ZipEntry>& entries) {
  // By how the name of an entry ends.
  static constexpr std::array<const char*, 3> kKinds[] = {
      {"data.pkl", "a file of PyTorch's (.pt)",
       "an array, by numpy.save('a.npy', torch.load('a.pt').numpy())"},
      {".mrml", "a scene of 3D Slicer's (.mrb)", "the volume in it, saved by itself"},
      {"[Content_Types].xml", "a document of an office program", "a table in CSV"},
      {"3dmodel.model", "a 3MF model", "the model as STL, OBJ or PLY"},
      {".kml", "a map in KML", "another file"}};
  for (const auto& [ending, name, expected] : kKinds) {
    for (const ZipEntry& entry : entries) {
      if (!entry.name.ends_with(ending)) continue;
      throw Error(ErrorCode::kUnsupported, fmt::format("{}: is {}, which is not read: expected {}",
                                                       source.name(), name, expected));
    }
  }
}

}  // namespace ovoid::io
