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
#include "io/points/point_columns.h"
#endif

namespace ovoid::io {

#ifdef OVOID_IO_HDF5
namespace {

// Where positions lie: one dataset, or one per axis.
struct Hdf5Positions {
  std::vector<const Hdf5Dataset*> datasets;
  bool is_transposed = false;  // [3, n]
  std::int64_t count = 0;

  const std::string& group() const { return datasets[0]->group; }
  const std::string& path() const { return datasets[0]->path; }
};

std::optional<Hdf5Positions> positions_in(const Hdf5Dataset& dataset) {
  const auto& dims = dataset.dims;
  if (!dataset.type || dims.size() != 2 || dims[0] < 1 || dims[1] < 1) return std::nullopt;
  if (dims[1] == 3) return Hdf5Positions{{&dataset}, false, dims[0]};
  if (dims[0] == 3) return Hdf5Positions{{&dataset}, true, dims[1]};
  return std::nullopt;
}

// "particle_position_x" as "particle_position_", "x" as "".
std::optional<std::string> base_of_x(std::string_view name) {
  static constexpr std::array<std::string_view, 8> kBases{
      "", "pos", "pos_", "position_", "particle_position_", "coord_", "coordinates_", "points_"};
  std::string base = lower(name);
  if (!base.ends_with('x')) return std::nullopt;
  base.pop_back();
  if (std::find(kBases.begin(), kBases.end(), base) == kBases.end()) return std::nullopt;
  return base;
}

// The positions of which `x` is the first of three datasets.
std::optional<Hdf5Positions> triple_from(const Hdf5File& file, const Hdf5Dataset& x) {
  const auto base = base_of_x(x.name);
  if (!base || x.dims.size() != 1 || !x.type || x.dims[0] < 1) return std::nullopt;
  Hdf5Positions positions{{&x}, false, x.dims[0]};
  for (const char axis : {'y', 'z'}) {
    for (const Hdf5Dataset& other : file.datasets()) {
      if (other.group == x.group && lower(other.name) == *base + axis && other.dims == x.dims &&
          other.type)
        positions.datasets.push_back(&other);
    }
  }
  return positions.datasets.size() == 3 ? std::optional(positions) : std::nullopt;
}

// "/PartType4" is 4; -1 for another group.
int gadget_type(std::string_view group) {
  constexpr std::string_view kName = "PartType";
  const auto at = group.rfind('/') + 1;
  group.remove_prefix(at);
  if (!group.starts_with(kName) || group.size() != kName.size() + 1) return -1;
  const char digit = group.back();
  return digit >= '0' && digit <= '9' ? digit - '0' : -1;
}

std::string absolute(const std::string& path) { return path.starts_with('/') ? path : "/" + path; }

Hdf5Positions asked_positions(const Hdf5File& file, const std::string& source,
                              const std::string& asked) {
  for (const Hdf5Dataset& dataset : file.datasets()) {
    if (dataset.path != absolute(asked)) continue;
    if (const auto found = positions_in(dataset)) return *found;
    if (const auto found = triple_from(file, dataset)) return *found;
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("{}: positions '{}': has shape [{}]{}: expected numbers [N, 3], [3, N], "
                    "or the first of three datasets x, y, z",
                    source, asked, fmt::join(dataset.dims, ", "),
                    dataset.type ? "" : " and holds no numbers"));
  }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: positions '{}': the file has no such dataset", source, asked));
}

[[noreturn]] void fail_candidates(const std::string& source,
                                  const std::vector<Hdf5Positions>& candidates) {
  constexpr std::size_t kListed = 8;
  std::string paths;
  for (std::size_t i = 0; i < std::min(kListed, candidates.size()); ++i)
    paths += fmt::format("{}'{}'", i == 0 ? "" : ", ", candidates[i].path());
  if (candidates.size() > kListed)
    paths += fmt::format(" and {} more", candidates.size() - kListed);
  throw Error(
      ErrorCode::kFileFormat,
      candidates.empty()
          ? fmt::format("{}: no dataset [N, 3] is called Coordinates, positions, xyz or the "
                        "like, and none has three axes (z, y, x): expected the path of positions "
                        "with --positions",
                        source)
          : fmt::format("{}: several datasets may be the positions: {}: choose one with "
                        "--positions",
                        source, paths));
}

std::vector<Hdf5Positions> candidates_in(const Hdf5File& file) {
  std::vector<Hdf5Positions> candidates;
  for (const Hdf5Dataset& dataset : file.datasets()) {
    const auto found = is_position_name(dataset.name) ? positions_in(dataset) : std::nullopt;
    const auto triple = found ? std::nullopt : triple_from(file, dataset);
    if (found) candidates.push_back(*found);
    if (triple) candidates.push_back(*triple);
  }
  return candidates;
}

Hdf5Positions find_hdf5_positions(const Hdf5File& file, const std::string& source,
                                  std::vector<std::string>& notes) {
  const std::vector<Hdf5Positions> candidates = candidates_in(file);
  if (candidates.size() == 1) return candidates[0];
  // Gadget's types: gas, then halo, then stars, then the rest.
  const auto rank = [](const Hdf5Positions& positions) {
    static constexpr std::array<int, 10> kRanks{0, 1, 3, 4, 2, 5, 6, 7, 8, 9};
    const int type = gadget_type(positions.group());
    return type < 0 ? -1 : kRanks[static_cast<std::size_t>(type)];
  };
  const bool is_gadget =
      !candidates.empty() && std::all_of(candidates.begin(), candidates.end(),
                                         [&](const Hdf5Positions& p) { return rank(p) >= 0; });
  if (!is_gadget) fail_candidates(source, candidates);
  const auto chosen = std::min_element(
      candidates.begin(), candidates.end(),
      [&](const Hdf5Positions& a, const Hdf5Positions& b) { return rank(a) < rank(b); });
  notes.push_back(
      fmt::format("{}: of {} kinds of particles '{}' is read; choose with "
                  "--positions",
                  source, candidates.size(), chosen->group()));
  return *chosen;
}

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
             Dataset& dataset)
      : file_(file),
        options_(options),
        positions_(std::move(positions)),
        rows_(rows_of_share(options.share, positions_.count)),
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
    set_share(dataset_, options_.share, positions_.count);
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
    for (const std::string& path : {fmt::format("{}/{}", group, asked), absolute(asked)}) {
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
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = "HDF5";
  dataset.kind = DatasetKind::kParticles;
  Hdf5Positions positions = options.hdf5.positions.empty()
                                ? find_hdf5_positions(file, source.name(), dataset.notes)
                                : asked_positions(file, source.name(), options.hdf5.positions);
  Hdf5Reader(file, options, std::move(positions), dataset).run();
  return dataset;
}

#endif

}  // namespace ovoid::io
