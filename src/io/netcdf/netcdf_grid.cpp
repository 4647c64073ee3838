// SPDX-License-Identifier: Apache-2.0
#include "io/netcdf/netcdf_grid.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "io/core/axis_order.h"
#include "io/core/cf_conventions.h"
#include "io/core/chunked_array.h"
#include "io/core/memory.h"
#include "io/core/samples.h"
#include "io/meshes/mesh_files.h"
#include "io/meshes/mesh_parts.h"
#include "io/netcdf/netcdf_axes.h"
#include "io/netcdf/netcdf_header.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Variables that describe others: coordinates, their bounds, and what `coordinates` and
// `cell_measures` name.
std::set<std::string> described_by(const NetcdfHeader& header) {
  std::set<std::string> names;
  for (const NetcdfVariable& variable : header.variables) {
    for (const char* const list : {"bounds", "climatology", "coordinates", "cell_measures"}) {
      const std::string text = variable.text(list);
      for (std::size_t at = 0; (at = text.find_first_not_of(" \t", at)) != std::string::npos;) {
        const std::size_t end = std::min(text.find_first_of(" \t", at), text.size());
        names.insert(text.substr(at, end - at));
        at = end;
      }
    }
  }
  return names;
}

struct FoundGrid {
  const NetcdfVariable* variable;
  std::string axes;
  std::array<std::int64_t, 4> sizes;  // x, y, z, time

  std::int64_t num_long() const {
    return std::count_if(sizes.begin(), sizes.begin() + 3, [](std::int64_t n) { return n > 1; });
  }
};

class NetcdfGridReader {
 public:
  NetcdfGridReader(const ByteSource& source, const ReadOptions& options)
      : source_(source), options_(options), header_(read_netcdf_header(source)) {
    dataset_.source = source.name();
    dataset_.format = "netCDF";
  }

  Dataset run() {
    const std::vector<FoundGrid> grids = choose();
    const NetcdfVariable& first = *grids[0].variable;
    std::optional<NetcdfPlaces> places;
    if (!options_.raw.spacing)
      places = netcdf_places(source_, header_, first, grids[0].axes, dataset_.notes);
    const bool is_mesh = places && !places->are_even;
    read(grids, is_mesh);
    std::string units;
    set_cf_times(netcdf_times(source_, header_, first, grids[0].axes, units), units, dataset_);
    if (options_.raw.spacing)
      dataset_.lattice.world_from_index.linear() = options_.raw.spacing->asDiagonal();
    if (is_mesh) return std::move(*this).as_mesh(*places);
    if (places) place_by_coordinates(places->along, dataset_);
    check_geometry(options_.raw.spacing ? "spacing" : dataset_.source + ": spacing",
                   dataset_.lattice.world_from_index);
    return std::move(dataset_);
  }

 private:
  [[noreturn]] void fail(ErrorCode code, const std::string& what) const {
    throw Error(code, fmt::format("{}: {}", source_.name(), what));
  }

  FoundGrid grid_of(const NetcdfVariable& variable) const {
    const std::vector<std::int64_t> shape = header_.shape(variable);
    FoundGrid grid{&variable, options_.raw.axis_order, {1, 1, 1, 1}};
    if (grid.axes.size() != shape.size()) grid.axes = netcdf_axes(header_, variable);
    constexpr std::string_view kLetters = "xyzt";
    for (std::size_t i = 0; i < grid.sizes.size(); ++i)
      if (const auto place = axis_place(grid.axes, kLetters[i])) grid.sizes[i] = shape[*place];
    return grid;
  }

  std::vector<FoundGrid> choose() const {
    if (!options_.array.empty()) {
      const NetcdfVariable* const named = header_.variable(options_.array);
      if (named == nullptr || !named->type)
        fail(ErrorCode::kInvalidArgument,
             fmt::format("array '{}': no such variable of numbers: expected one of {}",
                         options_.array, list_of(all())));
      return {grid_of(*named)};
    }
    std::vector<FoundGrid> grids = all();
    if (grids.empty())
      fail(ErrorCode::kUnsupported,
           fmt::format("is netCDF and holds no grid: expected a variable of numbers of two axes or "
                       "more, of {} in all (of an unstructured mesh, what ncdump shows may be "
                       "written as VTU)",
                       header_.variables.size()));
    const bool has_volume = std::any_of(grids.begin(), grids.end(),
                                        [](const FoundGrid& grid) { return grid.num_long() == 3; });
    if (has_volume) std::erase_if(grids, [](const FoundGrid& grid) { return grid.num_long() < 3; });
    for (const FoundGrid& grid : grids) {
      if (grid.sizes != grids[0].sizes)
        fail(ErrorCode::kInvalidArgument,
             fmt::format("holds grids of several sizes: choose one with --array: {}",
                         list_of(grids)));
    }
    return grids;
  }

  std::vector<FoundGrid> all() const {
    const std::set<std::string> described = described_by(header_);
    std::vector<FoundGrid> grids;
    for (const NetcdfVariable& variable : header_.variables) {
      if (!variable.type || described.contains(variable.name)) continue;
      const std::string& asked = options_.raw.axis_order;
      if (!asked.empty() && asked.size() != variable.dims.size()) continue;
      FoundGrid grid = grid_of(variable);
      if (grid.num_long() >= 2) grids.push_back(std::move(grid));
    }
    return grids;
  }

  std::string list_of(const std::vector<FoundGrid>& grids) const {
    constexpr std::size_t kListed = 20;
    std::string list;
    for (std::size_t i = 0; i < std::min(kListed, grids.size()); ++i)
      list += fmt::format("{}'{}' ({})", i == 0 ? "" : ", ", grids[i].variable->name,
                          fmt::join(header_.shape(*grids[i].variable), ", "));
    if (grids.size() > kListed) list += fmt::format(" and {} more", grids.size() - kListed);
    return list;
  }

  // Chunks are planes of the two axes that vary fastest; records are none of them.
  ChunkedArray chunked(const FoundGrid& grid, const std::shared_ptr<const ByteSource>& own) const {
    const NetcdfVariable& variable = *grid.variable;
    ChunkedArray array;
    array.where = fmt::format("{}: '{}'", source_.name(), variable.name);
    array.name = variable.name;
    array.axes = grid.axes;
    array.shape = header_.shape(variable);
    array.type = *variable.type;
    if (variable.text("_Unsigned") == "true" && size_of(array.type) == 1)
      array.type = ScalarType::kUInt8;
    if (!options_.raw.axis_order.empty())
      check_axis_order(array.where, options_.raw.axis_order, array.shape);
    array.is_big_endian = true;
    const std::size_t rank = array.shape.size();
    array.chunk.assign(rank, 1);
    for (std::size_t a = rank; a-- > 0 && a + 2 >= rank;)
      if (a > 0 || !variable.has_records) array.chunk[a] = array.shape[a];
    check_chunked(array);
    array.read = [&source = source_, own, begin = variable.begin,
                  stride = variable.has_records ? header_.record_stride : 0, shape = array.shape,
                  chunk = array.chunk](std::span<const std::int64_t> number,
                                       std::span<std::byte> out) {
      std::int64_t plane = 0;  // its number
      for (std::size_t a = stride > 0 ? 1 : 0; a < shape.size(); ++a)
        if (chunk[a] == 1) plane = plane * shape[a] + number[a];
      const auto size = static_cast<std::int64_t>(out.size());
      const std::int64_t record = stride > 0 ? number[0] * stride : 0;
      (own ? *own : source).read(begin + record + plane * size, out);
      return true;
    };
    return array;
  }

  static CfNumbers cf_numbers_of(const NetcdfVariable& variable, ScalarType type) {
    CfNumbers numbers;
    const auto first = [&](const char* name) -> std::optional<double> {
      const NetcdfAttribute* const found = variable.attribute(name);
      return found == nullptr || found->numbers.empty() ? std::nullopt
                                                        : std::optional(found->numbers[0]);
    };
    for (const char* const name : {"_FillValue", "missing_value"})
      if (const auto number = first(name)) numbers.missing.push_back(*number);
    // What the netCDF library fills with where nothing was written and no attribute says it.
    constexpr double kUnwritten = 9.9692099683868690e+36;
    if (is_floating(type) && !first("_FillValue")) numbers.missing.push_back(kUnwritten);
    if (type == ScalarType::kUInt8)
      for (double& number : numbers.missing) number += number < 0 ? 256 : 0;
    numbers.scale_factor = first("scale_factor");
    numbers.add_offset = first("add_offset");
    numbers.units = variable.text("units");
    return numbers;
  }

  void read(const std::vector<FoundGrid>& grids, bool is_mesh) {
    ReadOptions options = options_;
    options.array.clear();  // it was the variable's name, and would be a channel's
    options.may_stay_in_file = options.may_stay_in_file && !is_mesh;
    // Samples that stay in the file keep it open.
    const std::shared_ptr<const ByteSource> own =
        options.may_stay_in_file ? open_file(source_.name()) : nullptr;
    std::vector<ChunkedArray> arrays;
    arrays.reserve(grids.size());
    for (const FoundGrid& grid : grids) arrays.push_back(chunked(grid, own));
    read_chunked(arrays, options, dataset_);
    std::size_t next = 0;
    for (std::size_t i = 0; i < arrays.size(); ++i) {
      const CfNumbers numbers = cf_numbers_of(*grids[i].variable, arrays[i].type);
      for (std::int64_t c = 0; c < arrays[i].num_channels(); ++c)
        apply_cf_numbers(arrays[i].where, numbers, dataset_.arrays[next++], dataset_.notes);
    }
  }

  // Nodes where the samples are, hexahedra between them.
  Dataset as_mesh(const NetcdfPlaces& places) && {
    const Index3 dims = dataset_.lattice.dims;
    const std::int64_t num_nodes = num_samples(dims);
    const ScalarType type = places.is_float64 ? ScalarType::kFloat64 : ScalarType::kFloat32;
    MeshPart part;
    part.cells.dims = dims;
    require_memory(source_.name() + ": nodes",
                   checked_num_bytes(source_.name() + ": nodes", dims, type, 3));
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
    part.arrays = std::move(dataset_.arrays);
    check_mesh(source_.name(), part);
    dataset_.kind = DatasetKind::kMesh;
    dataset_.lattice = {};
    dataset_.positions = std::move(part.positions);
    dataset_.cells = std::move(part.cells);
    dataset_.arrays = std::move(part.arrays);
    dataset_.notes.push_back(fmt::format(
        "{}: coordinates are uneven: read as a mesh; --spacing A,B,C reads a regular grid",
        source_.name()));
    return std::move(dataset_);
  }

  const ByteSource& source_;
  const ReadOptions& options_;
  NetcdfHeader header_;
  Dataset dataset_;
};

}  // namespace

bool is_netcdf_grid(const ByteSource& source, std::string_view start) {
  return begins_like_netcdf(start) && !is_exodus(source, start);
}

Dataset read_netcdf_grid(const ByteSource& source, const ReadOptions& options) {
  return NetcdfGridReader(source, options).run();
}

std::optional<double> time_of_netcdf(const ByteSource& source) {
  const NetcdfHeader header = read_netcdf_header(source);
  for (const NetcdfVariable& variable : header.variables) {
    std::string units;
    const std::vector<double> times =
        netcdf_times(source, header, variable, netcdf_axes(header, variable), units);
    if (times.size() == 1) return times[0];
  }
  return std::nullopt;
}

}  // namespace ovoid::io
