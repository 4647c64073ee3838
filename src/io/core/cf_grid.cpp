// SPDX-License-Identifier: Apache-2.0
#include "io/core/cf_grid.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/core/axis_order.h"
#include "io/core/cf_places.h"
#include "io/core/chunked_array.h"
#include "io/core/memory.h"
#include "io/core/samples.h"
#include "io/meshes/mesh_parts.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Variables that describe others: coordinates, their bounds, and what `coordinates` and
// `cell_measures` name.
std::set<std::string, std::less<>> described_by(const CfDescription& file) {
  std::set<std::string, std::less<>> names;
  for (const CfVariable& variable : file.variables)
    for (const char* const list : {"bounds", "climatology", "coordinates", "cell_measures"})
      for (std::string& word : cf_words(variable.attributes, list)) names.insert(std::move(word));
  return names;
}

constexpr std::string_view kLetters = "xyzt";

struct FoundGrid {
  const CfVariable* variable = nullptr;
  std::string axes{};
  CfCoordinates coordinates{};
  std::array<std::int64_t, 4> sizes{1, 1, 1, 1};    // along kLetters
  std::array<const CfVariable*, 4> places_along{};  // the coordinates, in this order

  std::int64_t num_long() const {
    return std::count_if(sizes.begin(), sizes.begin() + 3, [](std::int64_t n) { return n > 1; });
  }
};

class CfGridReader {
 public:
  CfGridReader(const CfFile& file, const ReadOptions& options)
      : file_(file), options_(options), description_(file.description()), finder_(description_) {
    dataset_.source = file.name();
    dataset_.format = file.format();
  }

  bool has_grid() const {
    if (options_.array.empty()) return !all().empty();
    const std::vector<const CfVariable*> found = called(options_.array);
    return found.size() == 1 && found[0]->type && grid_of(*found[0]).num_long() >= 2;
  }

  Dataset run() {
    std::vector<FoundGrid> grids = choose();
    std::vector<ChunkedArray> arrays = open(grids);
    const FoundGrid& first = grids[0];
    std::optional<CfPlaces> places;
    if (!options_.raw.spacing)
      places = cf_places(file_, *first.variable, first.axes, first.coordinates, dataset_.notes);
    tell_nameless(first);
    const bool is_mesh = places && !places->are_even;
    read(grids, arrays, is_mesh);
    CfTimes times = cf_times(file_, first.axes, first.coordinates);
    set_cf_times(std::move(times.times), times.units, dataset_);
    if (options_.raw.spacing)
      dataset_.lattice.world_from_index.linear() = options_.raw.spacing->asDiagonal();
    if (places) place_by_cf(*places, dataset_);
    if (is_mesh) return std::move(dataset_);
    check_geometry(options_.raw.spacing ? "spacing" : dataset_.source + ": spacing",
                   dataset_.lattice.world_from_index);
    return std::move(dataset_);
  }

 private:
  [[noreturn]] void fail(ErrorCode code, const std::string& what) const {
    throw Error(code, fmt::format("{}: {}", file_.name(), what));
  }
  void note(const std::string& what) {
    dataset_.notes.push_back(fmt::format("{}: {}", file_.name(), what));
  }

  FoundGrid grid_of(const CfVariable& variable) const {
    const std::vector<std::int64_t> shape = description_.shape(variable);
    FoundGrid grid{.variable = &variable,
                   .axes = options_.raw.axis_order,
                   .coordinates = finder_.of(variable)};
    if (grid.axes.size() != shape.size())
      grid.axes = cf_axes(description_, variable, grid.coordinates);
    for (std::size_t i = 0; i < grid.sizes.size(); ++i) {
      const auto place = axis_place(grid.axes, kLetters[i]);
      if (!place) continue;
      grid.sizes[i] = shape[*place];
      grid.places_along[i] = grid.coordinates[*place];
    }
    return grid;
  }

  // With its groups, or, where that is enough, without them.
  std::vector<const CfVariable*> called(std::string_view name) const {
    if (name.starts_with('/')) name.remove_prefix(1);
    if (const CfVariable* const found = description_.variable(name)) return {found};
    std::vector<const CfVariable*> found;
    for (const CfVariable& variable : description_.variables)
      if (variable.own_name() == name) found.push_back(&variable);
    return found;
  }

  std::vector<FoundGrid> choose() {
    if (!options_.array.empty()) {
      const std::vector<const CfVariable*> named = called(options_.array);
      if (named.size() > 1)
        fail(ErrorCode::kInvalidArgument,
             fmt::format("array '{}': {} groups have one: say which, as in '{}'", options_.array,
                         named.size(), named[0]->name));
      if (!named.empty() && !named[0]->unread.empty())
        fail(ErrorCode::kUnsupported,
             fmt::format("array '{}': holds {}", options_.array, named[0]->unread));
      if (named.empty() || !named[0]->type)
        fail(ErrorCode::kInvalidArgument,
             fmt::format("array '{}': no such variable of numbers: expected one of {}",
                         options_.array, list_of(all())));
      return {grid_of(*named[0])};
    }
    std::vector<FoundGrid> grids = all();
    if (grids.empty())
      fail(ErrorCode::kUnsupported,
           fmt::format("is netCDF and holds no grid: expected a variable of numbers of two axes or "
                       "more, of {} in all (of an unstructured mesh, what ncdump shows may be "
                       "written as VTU)",
                       description_.variables.size()));
    const bool has_volume = std::any_of(grids.begin(), grids.end(),
                                        [](const FoundGrid& grid) { return grid.num_long() == 3; });
    if (has_volume) std::erase_if(grids, [](const FoundGrid& grid) { return grid.num_long() < 3; });
    for (const FoundGrid& grid : grids) {
      if (grid.sizes != grids[0].sizes)
        fail(ErrorCode::kInvalidArgument,
             fmt::format("holds grids of several sizes: choose one with --array: {}",
                         list_of(grids)));
    }
    std::erase_if(grids, [&, first = grids[0].places_along](const FoundGrid& grid) {
      if (grid.places_along == first) return false;
      note(fmt::format("'{}' lies at other places: it is left out; --array reads it",
                       grid.variable->name));
      return true;
    });
    tell_unread();
    return grids;
  }

  std::vector<FoundGrid> all() const {
    const auto described = described_by(description_);
    std::vector<FoundGrid> grids;
    for (const CfVariable& variable : description_.variables) {
      if (!variable.type || described.contains(variable.name) ||
          described.contains(variable.own_name()))
        continue;
      const std::string& asked = options_.raw.axis_order;
      if (!asked.empty() && asked.size() != variable.dims.size()) continue;
      const bool is_empty = std::any_of(
          variable.dims.begin(), variable.dims.end(),
          [&](std::size_t dimension) { return description_.dimensions[dimension].size < 1; });
      if (is_empty) continue;
      FoundGrid grid = grid_of(variable);
      if (grid.num_long() >= 2) grids.push_back(std::move(grid));
    }
    return grids;
  }

  // That lengths alone say what the axes are.
  void tell_nameless(const FoundGrid& grid) {
    std::vector<std::string> names;
    for (std::size_t a = 0; a < grid.coordinates.size(); ++a)
      if (grid.coordinates[a] != nullptr &&
          description_.dimensions[grid.variable->dims[a]].name.empty())
        names.push_back(fmt::format("'{}'", grid.coordinates[a]->name));
    if (!names.empty())
      note(
          fmt::format("the axes of '{}' have no names: they are taken for those of {}, which are "
                      "as long; --axis-order says another order",
                      grid.variable->name, fmt::join(names, ", ")));
  }

  void tell_unread() {
    for (const CfVariable& variable : description_.variables)
      if (!variable.unread.empty() && variable.dims.size() > 1)
        note(fmt::format("'{}' is left out: it holds {}", variable.name, variable.unread));
  }

  std::string list_of(const std::vector<FoundGrid>& grids) const {
    constexpr std::size_t kListed = 20;
    std::string list;
    for (std::size_t i = 0; i < std::min(kListed, grids.size()); ++i)
      list += fmt::format("{}'{}' ({})", i == 0 ? "" : ", ", grids[i].variable->name,
                          fmt::join(description_.shape(*grids[i].variable), ", "));
    if (grids.size() > kListed) list += fmt::format(" and {} more", grids.size() - kListed);
    return list;
  }

  // The arrays of the grids; of those that were not asked for the ones that cannot be read are left
  // out, as long as there are others.
  std::vector<ChunkedArray> open(std::vector<FoundGrid>& grids) {
    std::vector<ChunkedArray> arrays;
    std::vector<FoundGrid> opened;
    for (FoundGrid& grid : grids) {
      try {
        arrays.push_back(chunked(grid));
        opened.push_back(std::move(grid));
      } catch (const Error& error) {
        const bool is_last = &grid == &grids.back() && arrays.empty();
        if (error.code() != ErrorCode::kUnsupported || is_last) throw;
        dataset_.notes.push_back(fmt::format("{}: left out", error.what()));
      }
    }
    grids = std::move(opened);
    return arrays;
  }

  ChunkedArray chunked(const FoundGrid& grid) const {
    const CfVariable& variable = *grid.variable;
    ChunkedArray array = file_.array(variable, options_.may_stay_in_file);
    array.where = fmt::format("{}: '{}'", file_.name(), variable.name);
    array.name = options_.array.empty() ? variable.name : options_.array;
    array.axes = grid.axes;
    array.type = cf_type(variable.attributes, array.type);
    if (!options_.raw.axis_order.empty())
      check_axis_order(array.where, options_.raw.axis_order, array.shape);
    check_chunked(array);
    return array;
  }

  void read(const std::vector<FoundGrid>& grids, const std::vector<ChunkedArray>& arrays,
            bool is_mesh) {
    ReadOptions options = options_;
    options.array.clear();  // it was the variable's name, and would be a channel's
    options.may_stay_in_file = options.may_stay_in_file && !is_mesh;
    read_chunked(arrays, options, dataset_);
    std::size_t next = 0;
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      const CfNumbers numbers =
          cf_numbers(grids[i].variable->attributes, arrays[i].type, file_.fill());
      for (std::int64_t c = 0; c < arrays[i].num_channels(); ++c)
        apply_cf_numbers(arrays[i].where, numbers, dataset_.arrays[next++], dataset_.notes);
    }
  }

  const CfFile& file_;
  const ReadOptions& options_;
  const CfDescription& description_;
  CfCoordinateFinder finder_;
  Dataset dataset_;
};

// Nodes where the samples are, hexahedra between them.
void make_mesh(const CfPlaces& places, Dataset& dataset) {
  const Index3 dims = dataset.lattice.dims;
  const std::int64_t num_nodes = num_samples(dims);
  const ScalarType type = places.is_float64 ? ScalarType::kFloat64 : ScalarType::kFloat32;
  const std::string what = dataset.source + ": nodes";
  MeshPart part;
  part.cells.dims = dims;
  require_memory(what, checked_num_bytes(what, dims, type, 3));
  part.positions = {"positions", type, 3, num_nodes, "", false, {}};
  const auto fill = [&]<typename T>(T) {
    std::vector<T> values;
    values.reserve(static_cast<std::size_t>(3 * num_nodes));
    for (const double z : places.along[2])
      for (const double y : places.along[1])
        for (const double x : places.along[0])
          for (const double place : {x, y, z}) values.push_back(static_cast<T>(place));
    part.positions.bytes = bytes_owning(std::move(values));
  };
  places.is_float64 ? fill(double{}) : fill(float{});
  part.arrays = std::move(dataset.arrays);
  check_mesh(dataset.source, part);
  dataset.kind = DatasetKind::kMesh;
  dataset.lattice = {};
  dataset.positions = std::move(part.positions);
  dataset.cells = std::move(part.cells);
  dataset.arrays = std::move(part.arrays);
  dataset.notes.push_back(fmt::format(
      "{}: coordinates are uneven: read as a mesh; --spacing A,B,C reads a regular grid",
      dataset.source));
}

}  // namespace

void place_by_cf(const CfPlaces& places, Dataset& dataset) {
  if (places.are_even)
    place_by_coordinates(places.along, dataset);
  else
    make_mesh(places, dataset);
}

bool has_cf_grid(const CfFile& file, const ReadOptions& options) {
  return CfGridReader(file, options).has_grid();
}

Dataset read_cf_grid(const CfFile& file, const ReadOptions& options) {
  return CfGridReader(file, options).run();
}

}  // namespace ovoid::io
