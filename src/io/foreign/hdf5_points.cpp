// SPDX-License-Identifier: Apache-2.0
#include "io/foreign/hdf5_points.h"

#include <fmt/format.h>

#include <string>

#include "ovoid/error.h"

#ifdef OVOID_IO_HDF5
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "data/scalar_visit.h"
#include "io/core/point_arrays.h"
#include "io/core/row_share.h"
#include "io/core/samples.h"
#include "io/core/text_scanner.h"
#include "io/foreign/hdf5_file.h"
#include "io/foreign/hdf5_positions.h"
#include "io/foreign/hdf5_simulation.h"
#endif

namespace ovoid::io {

#ifdef OVOID_IO_HDF5
namespace {

// The box from 0 to its edges that Gadget's header tells; nothing if it tells none.
std::optional<Bounds3> gadget_box(const Hdf5File& file) {
  const std::vector<double> size = file.numbers("/Header", "BoxSize");
  if (size.size() != 1 && size.size() != 3) return std::nullopt;
  Vec3 hi;
  for (std::size_t axis = 0; axis < 3; ++axis)
    hi[static_cast<Eigen::Index>(axis)] = size.size() == 1 ? size[0] : size[axis];
  if (!(hi.minCoeff() > 0) || !hi.allFinite()) return std::nullopt;
  return Bounds3(Vec3::Zero(), hi);
}

// Are the points within the box, by the axes from `axis` on, as many as they have components?
bool are_within(const Bounds3& box, const DataArray& points, std::size_t axis) {
  return data::visit_scalar(points.type, [&]<class T>(std::type_identity<T>) {
    for (std::int64_t i = 0; i < points.num_tuples * points.num_components; ++i) {
      const auto p = static_cast<double>(data::load_scalar<T>(points.bytes.view.data(), i));
      const auto a = static_cast<Eigen::Index>(axis) + i % points.num_components;
      if (p < box.min()[a] || p > box.max()[a]) return false;
    }
    return true;
  });
}

// Reads what was found or asked for into a dataset.
class Hdf5Reader {
 public:
  Hdf5Reader(const Hdf5File& file, const ReadOptions& options, Hdf5Positions positions,
             const Rows& rows, Dataset& dataset)
      : file_(file),
        options_(options),
        positions_(std::move(positions)),
        rows_(rows),
        dataset_(dataset) {}

  void run() {
    const std::vector<const Hdf5Dataset*> values = choose_values();
    const std::optional<Bounds3> box = gadget_box(file_);
    std::int64_t total = 0;
    for (const Hdf5Dataset* part : positions_.datasets)
      total += num_bytes_read(*part) + (box && is_share() ? file_.num_bytes(*part) : 0);
    for (const Hdf5Dataset* value : values) total += num_bytes_read(*value);
    ReadProgress progress(options_, total);
    read_positions(progress);
    for (const Hdf5Dataset* value : values) {
      DataArray array = file_.open(*value).read(rows_, progress);
      array.name = value->group == positions_.group() ? value->name : value->path;
      dataset_.arrays.push_back(std::move(array));
    }
    if (box) add_periodic_box(*box, progress);
    add_masses();
    add_density();
    tell_simulation();
  }

 private:
  bool is_share() const noexcept { return rows_.count < positions_.count; }

  std::int64_t num_bytes_read(const Hdf5Dataset& dataset) const {
    return file_.num_bytes(dataset) / positions_.count * rows_.count;
  }

  bool is_positions(const Hdf5Dataset& dataset) const {
    return std::find(positions_.datasets.begin(), positions_.datasets.end(), &dataset) !=
           positions_.datasets.end();
  }

  bool has_rows(const Hdf5Dataset& dataset) const {
    return dataset.type && dataset.dims[0] == positions_.count &&
           (dataset.dims.size() == 1 || (dataset.dims[1] >= 1 && dataset.dims[1] <= kMaxColumns));
  }

  std::vector<const Hdf5Dataset*> choose_values() const {
    std::vector<const Hdf5Dataset*> values;
    if (options_.hdf5.values.empty()) {
      for (const Hdf5Dataset& dataset : file_.datasets()) {
        if (dataset.group == positions_.group() && !is_positions(dataset) && has_rows(dataset))
          values.push_back(&dataset);
      }
      return values;
    }
    for (const std::string& asked : options_.hdf5.values) values.push_back(&asked_value(asked));
    return values;
  }

  const Hdf5Dataset& asked_value(const std::string& asked) const {
    const std::string group = positions_.group() == "/" ? "" : positions_.group();
    for (const std::string& path : {fmt::format("{}/{}", group, asked), absolute_path(asked)}) {
      for (const Hdf5Dataset& dataset : file_.datasets()) {
        if (dataset.path != path) continue;
        if (has_rows(dataset)) return dataset;
        throw Error(ErrorCode::kInvalidArgument,
                    fmt::format("{}: values '{}': has shape [{}]{}: expected {} rows of numbers",
                                dataset_.source, asked, fmt::join(dataset.dims, ", "),
                                dataset.type ? "" : " and holds no numbers", positions_.count));
      }
    }
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: values '{}': the file has no such dataset, nor has '{}/'",
                            dataset_.source, asked, group));
  }

  void read_positions(ReadProgress& progress) {
    if (positions_.datasets.size() == 1) {
      const Hdf5Table table = file_.open(*positions_.datasets[0], positions_.is_transposed);
      dataset_.positions = floating_values(table.read(rows_, progress));
    } else {
      std::byte* to = nullptr;
      dataset_.positions = new_array({"", ScalarType::kFloat64, 3, rows_.count, "", false, {}}, to);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const DataArray part = file_.open(*positions_.datasets[axis]).read(rows_, progress);
        data::visit_scalar(part.type, [&]<class T>(std::type_identity<T>) {
          for (std::int64_t i = 0; i < rows_.count; ++i) {
            const auto value = static_cast<double>(data::load_scalar<T>(part.bytes.view.data(), i));
            std::memcpy(to + (static_cast<std::size_t>(i) * 3 + axis) * sizeof(double), &value,
                        sizeof(double));
          }
        });
      }
    }
    dataset_.positions.name = "positions";
  }

  // Gadget's box, unless particles lie outside it: then the simulation had none, or is centred.
  void add_periodic_box(const Bounds3& box, ReadProgress& progress) {
    // Some codes let particles leave by a little until they are sorted again.
    const Vec3 margin = 0.01 * box.max();
    const Bounds3 wide(-margin, box.max() + margin);
    if (are_within(wide, dataset_.positions, 0) && are_others_within(wide, progress)) {
      dataset_.periodic_box = box;
    } else {
      dataset_.notes.push_back(fmt::format(
          "{}: particles lie outside the box of size {}: it is not taken for a periodic one",
          dataset_.source, box.max()[0]));
    }
  }

  // Are the particles of other shares, too? They are looked at piece by piece.
  bool are_others_within(const Bounds3& box, ReadProgress& progress) const {
    if (!is_share()) return true;
    for (std::size_t axis = 0; axis < positions_.datasets.size(); ++axis) {
      const Hdf5Table table = file_.open(*positions_.datasets[axis], positions_.is_transposed);
      const std::int64_t step = table.rows_at_once();
      for (std::int64_t first = 0; first < positions_.count; first += step) {
        const Rows piece{first, std::min(step, positions_.count - first)};
        if (!are_within(box, table.read(piece, progress), axis)) return false;
      }
    }
    return true;
  }

  const DataArray* find(std::initializer_list<std::string_view> names) const {
    for (const DataArray& array : dataset_.arrays)
      if (std::find(names.begin(), names.end(), lower(array.name)) != names.end()) return &array;
    return nullptr;
  }

  // The same mass for all particles of a type: Gadget's table, or Phantom's.
  void add_masses() {
    if (find({"mass", "masses", "particle_mass", "m"}) != nullptr) return;
    const int type = gadget_type(positions_.group());
    const std::vector<double> table = file_.numbers("/Header", "MassTable");
    if (type >= 0 && static_cast<std::size_t>(type) < table.size()) {
      const double mass = table[static_cast<std::size_t>(type)];
      if (mass > 0) add_array("mass", [mass](std::int64_t) { return mass; });
      return;
    }
    const std::vector<double> phantom = file_.numbers("/header", "massoftype");
    const DataArray* const kinds = find({"itype"});
    if (phantom.empty() || !(phantom[0] > 0)) return;
    add_array("mass", [&phantom, kinds](std::int64_t i) {
      if (kinds == nullptr) return phantom[0];
      // Numbered from 1; negative ones are not active.
      const double kind = std::abs(value_at(*kinds, i));
      return kind >= 1 && kind <= static_cast<double>(phantom.size())
                 ? phantom[static_cast<std::size_t>(kind) - 1]
                 : 0.0;
    });
  }

  // Phantom's density, which its files leave to the smoothing length: m (hfact / h)^3.
  void add_density() {
    const std::vector<double> factor = file_.numbers("/header", "hfact");
    const DataArray* const lengths = find({"h"});
    const DataArray* const masses = find({"mass"});
    if (factor.size() != 1 || lengths == nullptr || masses == nullptr ||
        lengths->num_components != 1 || find({"density", "rho"}) != nullptr)
      return;
    const DataArray h = *lengths, m = *masses;  // the vector below may move
    add_array("density", [&h, &m, f = factor[0]](std::int64_t i) {
      const double length = value_at(h, i);
      return length > 0 ? value_at(m, i) * std::pow(f / length, 3)
                        : std::numeric_limits<double>::quiet_NaN();
    });
  }

  // What smoothing lengths mean, and what of cosmology is not in the numbers.
  void tell_simulation() {
    if (gadget_type(positions_.group()) < 0) return;
    const std::string& source = dataset_.source;
    if (const std::string factors = cosmology_text(source); !factors.empty()) {
      dataset_.notes.push_back(
          fmt::format("{}: a cosmological run: numbers are as the file has them, factors {} are "
                      "not applied",
                      source, factors));
    }
    const DataArray* const lengths =
        find({"smoothinglength", "smoothinglengths", "smoothing_length", "hsml"});
    if (lengths == nullptr) return;
    const auto found = smoothing_code(source, positions_.group(), lengths->name);
    if (!found) return;
    dataset_.format = data::format_of_code(dataset_.format, found->code);
    dataset_.notes.push_back(fmt::format(
        "{}: '{}' are taken for those of {}{}: kernels end at {:.7g} of these lengths "
        "(--smoothing-ends says otherwise)",
        source, lengths->name, found->code.name,
        found->is_sure ? "" : ", since the file names no kernel that is known", found->code.reach));
  }

  static double value_at(const DataArray& array, std::int64_t i) {
    return data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
      return static_cast<double>(data::load_scalar<T>(array.bytes.view.data(), i));
    });
  }

  template <typename ValueOf>
  void add_array(const char* name, const ValueOf& value_of) {
    std::byte* to = nullptr;
    DataArray array = new_array({name, ScalarType::kFloat32, 1, rows_.count, "", false, {}}, to);
    for (std::int64_t i = 0; i < rows_.count; ++i) {
      const auto value = static_cast<float>(value_of(i));
      std::memcpy(to + static_cast<std::size_t>(i) * sizeof(float), &value, sizeof(float));
    }
    dataset_.arrays.push_back(std::move(array));
  }

  static constexpr std::int64_t kMaxColumns = 64;

  const Hdf5File& file_;
  const ReadOptions& options_;
  Hdf5Positions positions_;
  Rows rows_;  // that are read
  Dataset& dataset_;
};

Dataset no_particles(const std::string& source) {
  Dataset dataset;
  dataset.source = source;
  dataset.format = "HDF5";
  dataset.kind = DatasetKind::kParticles;
  return dataset;
}

}  // namespace

bool has_hdf5_positions(const ByteSource& source) {
  const Hdf5File file(source.name(), 3);
  const std::vector<Hdf5Positions> candidates = candidates_in(file);
  // Three datasets x, y, z may as well be the axes of a cube.
  const auto is_axes = [&](const Hdf5Positions& positions) {
    const std::vector<std::int64_t> cube(3, positions.count);
    return positions.datasets.size() == 3 &&
           std::any_of(file.datasets().begin(), file.datasets().end(),
                       [&](const Hdf5Dataset& dataset) { return dataset.dims == cube; });
  };
  return !std::all_of(candidates.begin(), candidates.end(), is_axes);
}

Dataset read_hdf5_points(const ByteSource& source, const ReadOptions& options) {
  const Hdf5File file(source.name());
  Dataset dataset = no_particles(source.name());
  Hdf5Positions positions;
  if (options.hdf5.positions.empty()) {
    std::vector<Hdf5Positions> all = candidates_in(file);
    std::vector<PositionsPlace> places;
    places.reserve(all.size());
    for (const Hdf5Positions& one : all) places.push_back({one.path(), one.group()});
    positions = std::move(all[choose_positions(source.name(), places, dataset.notes)]);
  } else {
    positions = asked_positions(file, source.name(), options.hdf5.positions);
  }
  const std::int64_t count = positions.count;
  const Rows rows = rows_of_share(options.share, count);
  Hdf5Reader(file, options, std::move(positions), rows, dataset).run();
  set_share(dataset, options.share, count);
  return dataset;
}

std::vector<Hdf5PointsPlace> hdf5_points_in(const std::string& path) {
  const Hdf5File file(path);
  std::vector<Hdf5PointsPlace> places;
  for (const Hdf5Positions& one : candidates_in(file))
    places.push_back({one.path(), one.group(), one.count});
  return places;
}

Dataset read_hdf5_rows_of_points(const std::string& path, const ReadOptions& options,
                                 const Rows& rows) {
  const Hdf5File file(path);
  Dataset dataset = no_particles(path);
  Hdf5Reader(file, options, asked_positions(file, path, options.hdf5.positions), rows, dataset)
      .run();
  return dataset;
}

#endif

}  // namespace ovoid::io
