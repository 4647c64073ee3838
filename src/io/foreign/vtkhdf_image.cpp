// SPDX-License-Identifier: Apache-2.0
// VTKHDF's images: arrays of axes z, y and x, with time before them and components behind.
#ifdef OVOID_IO_HDF5
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "io/core/samples.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/foreign/vtkhdf_arrays.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Components of each sample of an array of axes `dims`; nothing if the axes are not z, y and x of
// `sizes`, with or without those of one sample.
std::optional<int> components_of(std::span<const std::int64_t> dims, const Index3& sizes) {
  std::vector<std::int64_t> expected, found;
  for (std::size_t axis = 3; axis-- > 0;)
    if (sizes[axis] != 1) expected.push_back(sizes[axis]);
  for (const std::int64_t dim : dims)
    if (dim != 1) found.push_back(dim);
  if (found == expected) return 1;
  constexpr std::int64_t kMostComponents = 4096;
  if (found.size() != expected.size() + 1 || found.back() > kMostComponents) return std::nullopt;
  const auto components = static_cast<int>(found.back());
  found.pop_back();
  return found == expected ? std::optional(components) : std::nullopt;
}

LatticeGeometry image_lattice_of(const VtkHdfGroup& group) {
  const Hdf5Objects& objects = group.objects();
  const std::vector<double> extent = objects.numbers(group.id(), group.place(), "WholeExtent", 6);
  const std::vector<double> origin = objects.numbers(group.id(), group.place(), "Origin", 3);
  const std::vector<double> spacing = objects.numbers(group.id(), group.place(), "Spacing", 3);
  std::vector<double> direction{1, 0, 0, 0, 1, 0, 0, 0, 1};
  if (has_hdf5_attribute(group.id(), "Direction"))
    direction = objects.numbers(group.id(), group.place(), "Direction", 9);
  LatticeGeometry lattice;
  Mat3 axes;
  Vec3 first;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    const double size = extent[2 * axis + 1] - extent[2 * axis] + 1;
    lattice.dims[axis] = objects.whole_number(size, group.place(), "WholeExtent", kMaxAxisSize);
    first[a] = extent[2 * axis];
    for (std::size_t row = 0; row < 3; ++row)
      axes(static_cast<Eigen::Index>(row), a) = direction[3 * row + axis] * spacing[axis];
  }
  lattice.world_from_index.linear() = axes;
  lattice.world_from_index.translation() = Vec3(origin[0], origin[1], origin[2]) + axes * first;
  check_geometry(
      fmt::format("{}: '{}': Spacing, Direction or Origin", objects.name(), group.place()),
      lattice.world_from_index);
  return lattice;
}

}  // namespace

LatticePart read_vtkhdf_image(const VtkHdfGroup& group, const VtkHdfSteps& steps,
                              const VtkHdfRead& read) {
  LatticePart part;
  part.lattice = image_lattice_of(group);
  for (const bool is_cell_data : {false, true}) {
    const char* const name = is_cell_data ? "CellData" : "PointData";
    Index3 sizes = part.lattice.dims;
    for (std::int64_t& size : sizes)
      if (is_cell_data) size = std::max<std::int64_t>(1, size - 1);
    const std::string offsets = fmt::format("{}Offsets", name);
    std::vector<DataArray> arrays = read_vtkhdf_arrays(
        group, name, is_cell_data, read,
        [&](const std::string& array_name, const VtkHdfArray& array) {
          const std::span<const std::int64_t> dims = array.dims();
          // Time goes before the axes of space where there is any.
          auto components =
              steps.is_static() ? std::nullopt : components_of(dims.subspan(1), sizes);
          DataArray samples;
          if (components) {
            const auto own = steps.offset_of_array(offsets.c_str(), array_name, read.step);
            samples = array.rows(own.value_or(read.step), 1, *read.progress);
          } else {
            components = components_of(dims, sizes);
            if (!components)
              group.objects().fail(fmt::format("'{}' has axes of {}: expected {} along z, y and x",
                                               array.place(), fmt::join(dims, ", "),
                                               dims_text(Index3{sizes[2], sizes[1], sizes[0]})));
            samples = array.rows(0, array.num_rows(), *read.progress);
          }
          samples.num_components = *components;
          samples.num_tuples = num_samples(sizes);
          return samples;
        });
    for (DataArray& array : arrays) part.arrays.push_back(std::move(array));
  }
  return part;
}

}  // namespace ovoid::io
#endif
