// SPDX-License-Identifier: Apache-2.0
#include "io/meshes/plot3d.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>
#include <utility>

#include "io/core/numbers.h"
#include "io/core/samples.h"
#include "io/meshes/mesh_parts.h"
#include "io/meshes/mesh_steps.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMostPadding = 4096;
constexpr std::int64_t kMaxPlot3dGrids = 10000;
constexpr std::int64_t kMaxPlot3dAxis = 100'000'000;  // more is another byte order's number
constexpr double kGamma = 1.4;                        // ratio of specific heats of a diatomic gas

// Walks a file in one layout; every step says whether the file can have it.
class Plot3dWalker {
 public:
  Plot3dWalker(const ByteSource& source, Plot3dLayout layout, Plot3dContent content)
      : source_(source), layout_(std::move(layout)), content_(content) {}

  std::optional<Plot3dLayout> run() {
    std::int64_t num_grids = 1;
    if (layout_.is_multiple) {
      if (!begin_record(4)) return std::nullopt;
      num_grids = integer();
      if (!end_record(4) || num_grids < 1 || num_grids > kMaxPlot3dGrids) return std::nullopt;
    }
    if (!begin_record(12 * num_grids) || position_ + 12 * num_grids > source_.size())
      return std::nullopt;
    for (std::int64_t g = 0; g < num_grids; ++g) {
      Index3 dims{};
      for (std::int64_t& dim : dims) {
        dim = integer();
        if (dim < 1 || dim > kMaxPlot3dAxis) return std::nullopt;
      }
      layout_.dims.push_back(dims);
    }
    if (!end_record(12 * num_grids)) return std::nullopt;
    for (const Index3& dims : layout_.dims) {
      if (!pass_grid(dims)) return std::nullopt;
    }
    layout_.num_padding = source_.size() - position_;
    if (layout_.num_padding > kMostPadding) return std::nullopt;
    const std::string padding = source_.text(position_, layout_.num_padding);
    if (padding.find_first_not_of('\0') != std::string::npos) return std::nullopt;
    return layout_;
  }

 private:
  bool pass_grid(const Index3& dims) {
    const auto num_nodes = checked_product(dims);
    if (!num_nodes || *num_nodes > source_.size()) return false;
    const std::int64_t size = layout_.is_double ? 8 : 4;
    if (content_ == Plot3dContent::kSolution) {
      // Mach number, angle of attack, Reynolds number, time; then five values per node.
      if (!begin_record(4 * size)) return false;
      layout_.offsets.push_back(position_);
      return skip(4 * size) && end_record(4 * size) && pass_record(5 * size * *num_nodes);
    }
    const std::int64_t num_bytes = (3 * size + (layout_.has_iblank ? 4 : 0)) * *num_nodes;
    if (!begin_record(num_bytes)) return false;
    layout_.offsets.push_back(position_);
    return skip(num_bytes) && end_record(num_bytes);
  }

  bool pass_record(std::int64_t num_bytes) {
    return begin_record(num_bytes) && skip(num_bytes) && end_record(num_bytes);
  }
  bool skip(std::int64_t num_bytes) {
    position_ += num_bytes;
    return position_ <= source_.size();
  }
  bool begin_record(std::int64_t num_bytes) { return mark(num_bytes); }
  bool end_record(std::int64_t num_bytes) { return mark(num_bytes); }
  bool mark(std::int64_t num_bytes) {
    return !layout_.has_marks || (position_ + 4 <= source_.size() && integer() == num_bytes);
  }

  // -1 behind the end.
  std::int64_t integer() {
    const std::string bytes = source_.text(position_, 4);
    if (bytes.size() < 4) return -1;
    position_ += 4;
    return number_at<std::int32_t>(bytes.data(), layout_.is_big_endian);
  }

  const ByteSource& source_;
  Plot3dLayout layout_;
  Plot3dContent content_;
  std::int64_t position_ = 0;
};

std::string dims_list(const std::vector<Index3>& all) {
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(all.size(), 4); ++i)
    text += (i > 0 ? ", " : "") + dims_text(all[i]);
  return all.size() > 4 ? text + fmt::format(" and {} more", all.size() - 4) : text;
}

// Reads numbers of a file whose layout is known.
template <typename T>
class Plot3dNumbers {
 public:
  Plot3dNumbers(const ByteSource& source, bool is_big_endian)
      : source_(source), is_big_endian_(is_big_endian) {}

  std::vector<T> read(std::int64_t offset, std::int64_t count) const {
    std::vector<T> values(static_cast<std::size_t>(count));
    const std::span<std::byte> bytes = std::as_writable_bytes(std::span(values));
    source_.read(offset, bytes);
    if (is_big_endian_ != (std::endian::native == std::endian::big)) swap_bytes(bytes, sizeof(T));
    return values;
  }

 private:
  const ByteSource& source_;
  bool is_big_endian_;
};

template <typename T>
constexpr ScalarType kTypeOf = sizeof(T) == 4 ? ScalarType::kFloat32 : ScalarType::kFloat64;

template <typename T>
DataArray node_array(std::string name, std::vector<T> values, int num_components = 1) {
  DataArray array;
  array.name = std::move(name);
  array.type = kTypeOf<T>;
  array.num_components = num_components;
  array.num_tuples = static_cast<std::int64_t>(values.size()) / num_components;
  array.bytes = bytes_owning(std::move(values));
  return array;
}

// Three blocks of numbers, which the file holds one behind the other, as triples.
template <typename T>
std::vector<T> triples(const Plot3dNumbers<T>& numbers, std::int64_t offset, std::int64_t count) {
  std::vector<T> result(static_cast<std::size_t>(count) * 3);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::vector<T> values =
        numbers.read(offset + static_cast<std::int64_t>(axis * sizeof(T)) * count, count);
    for (std::size_t i = 0; i < values.size(); ++i) result[3 * i + axis] = values[i];
  }
  return result;
}

template <typename T>
void read_nodes(const ByteSource& grid, const Plot3dLayout& layout, std::size_t g, MeshPart& part) {
  const std::int64_t count = *checked_product(layout.dims[g]);
  const std::int64_t offset = layout.offsets[g];
  part.positions = node_array(
      "positions", triples(Plot3dNumbers<T>(grid, layout.is_big_endian), offset, count), 3);
  part.cells.dims = layout.dims[g];
  if (!layout.has_iblank) return;
  const std::vector<std::int32_t> iblank =
      Plot3dNumbers<std::int32_t>(grid, layout.is_big_endian)
          .read(offset + 3 * static_cast<std::int64_t>(sizeof(T)) * count, count);
  // Only 0 means that there is no node; other values tell walls and where grids overlap.
  constexpr std::uint8_t kHidden = 2;
  std::vector<std::uint8_t> flags;
  flags.reserve(iblank.size());
  for (const std::int32_t value : iblank) flags.push_back(value == 0 ? kHidden : 0);
  DataArray ghosts;
  ghosts.name = "vtkGhostType";
  ghosts.type = ScalarType::kUInt8;
  ghosts.num_tuples = count;
  ghosts.bytes = bytes_owning(std::move(flags));
  part.arrays.push_back(std::move(ghosts));
}

// The perfect gas's pressure and speed where the density lets them be told, else NaN.
template <typename T>
void add_derived(const std::vector<T>& density, const std::vector<T>& momentum,
                 const std::vector<T>& energy, MeshPart& part) {
  std::vector<T> pressure(density.size()), speed(density.size());
  for (std::size_t i = 0; i < density.size(); ++i) {
    const double rho = density[i];
    double squares = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double m = momentum[3 * i + axis];
      squares += m * m;
    }
    const bool is_gas = rho > 0;
    const double nan = std::numeric_limits<double>::quiet_NaN();
    speed[i] = static_cast<T>(is_gas ? std::sqrt(squares) / rho : nan);
    pressure[i] = static_cast<T>(is_gas ? (kGamma - 1) * (energy[i] - 0.5 * squares / rho) : nan);
  }
  part.arrays.push_back(node_array("Pressure", std::move(pressure)));
  part.arrays.push_back(node_array("VelocityMagnitude", std::move(speed)));
}

template <typename T>
void read_flow(const ByteSource& solution, const Plot3dLayout& layout, std::size_t g,
               MeshPart& part) {
  const std::int64_t count = *checked_product(layout.dims[g]);
  const Plot3dNumbers<T> numbers(solution, layout.is_big_endian);
  const auto size = static_cast<std::int64_t>(sizeof(T));
  part.time = static_cast<double>(numbers.read(layout.offsets[g], 4)[3]);
  const std::int64_t begin = layout.offsets[g] + 4 * size + (layout.has_marks ? 8 : 0);
  const std::vector<T> density = numbers.read(begin, count);
  const std::vector<T> momentum = triples(numbers, begin + size * count, count);
  const std::vector<T> energy = numbers.read(begin + 4 * size * count, count);
  part.arrays.push_back(node_array("Density", density));
  part.arrays.push_back(node_array("Momentum", momentum, 3));
  part.arrays.push_back(node_array("StagnationEnergy", energy));
  add_derived(density, momentum, energy, part);
}

Plot3dLayout solution_layout(const ByteSource& source, const std::string& grid_path,
                             const std::vector<Index3>& grid_dims) {
  const auto layout = find_plot3d(source, Plot3dContent::kSolution);
  if (!layout) {
    const char* const what =
        find_plot3d(source, Plot3dContent::kGrid) ? "is a PLOT3D grid" : "is no PLOT3D solution";
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: {}: expected the solution (q file) for the grid {} of {} nodes",
                            source.name(), what, grid_path, dims_list(grid_dims)));
  }
  if (layout->dims != grid_dims) {
    throw Error(
        ErrorCode::kFileFormat,
        fmt::format("{}: is a PLOT3D solution of {} nodes: the grid {} has {}", source.name(),
                    dims_list(layout->dims), grid_path, dims_list(grid_dims)));
  }
  return *layout;
}

}  // namespace

std::optional<Plot3dLayout> find_plot3d(const ByteSource& source, Plot3dContent content) {
  std::optional<Plot3dLayout> padded;  // zeros may be IBLANK, too
  for (unsigned i = 0; i < 32; ++i) {
    Plot3dLayout layout;
    layout.has_marks = (i & 16U) == 0;  // the stricter first
    layout.is_big_endian = (i & 8U) != 0;
    layout.is_multiple = (i & 4U) != 0;
    layout.is_double = (i & 2U) != 0;
    layout.has_iblank = (i & 1U) != 0;
    if (layout.has_iblank && content == Plot3dContent::kSolution) continue;
    auto found = Plot3dWalker(source, layout, content).run();
    if (found && found->num_padding == 0) return found;
    if (found && !padded) padded = std::move(found);
  }
  return padded;
}

Dataset read_plot3d(const std::string& grid_path, const std::vector<std::string>& solution_paths,
                    const ReadOptions& options) {
  const auto grid = open_file(grid_path);
  const auto layout = find_plot3d(*grid, Plot3dContent::kGrid);
  if (!layout) throw Error(ErrorCode::kFileFormat, fmt::format("{}: is no PLOT3D grid", grid_path));
  for (const std::string& path : solution_paths)
    solution_layout(*open_file(path), grid_path, layout->dims);
  const auto num_steps = static_cast<std::int64_t>(solution_paths.size());
  Dataset result = read_mesh_step(grid_path, num_steps, {}, options, [&](std::int64_t step) {
    const auto solution = open_file(solution_paths[static_cast<std::size_t>(step)]);
    const Plot3dLayout flow = solution_layout(*solution, grid_path, layout->dims);
    Dataset dataset;
    dataset.source = grid_path;
    dataset.format = "PLOT3D";
    if (flow.num_padding > 0) {
      dataset.notes.push_back(
          fmt::format("{}: {} bytes of zeros behind the last number are "
                      "passed over",
                      solution->name(), flow.num_padding));
    }
    std::vector<MeshPart> parts(layout->dims.size());
    for (std::size_t g = 0; g < parts.size(); ++g) {
      parts[g].block = std::to_string(g + 1);
      if (options.stop.stop_requested())
        throw Error(ErrorCode::kCancelled, "reading: stopped by the caller");
      layout->is_double ? read_nodes<double>(*grid, *layout, g, parts[g])
                        : read_nodes<float>(*grid, *layout, g, parts[g]);
      flow.is_double ? read_flow<double>(*solution, flow, g, parts[g])
                     : read_flow<float>(*solution, flow, g, parts[g]);
      if (num_steps > 1) parts[g].time.reset();
    }
    return mesh_of_parts(std::move(dataset), std::move(parts), options);
  });
  return result;
}

void refuse_lone_plot3d(const ByteSource& source) {
  const char* const what = find_plot3d(source, Plot3dContent::kGrid)
                               ? "grid, which has no arrays: give its solution (q file) behind it"
                           : find_plot3d(source, Plot3dContent::kSolution)
                               ? "solution, which has no points: give its grid before it"
                               : nullptr;
  if (what != nullptr)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: is a PLOT3D {}", source.name(), what));
}

}  // namespace ovoid::io
