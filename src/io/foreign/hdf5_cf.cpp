// SPDX-License-Identifier: Apache-2.0
// netCDF-4 is HDF5 whose arrays have dimension scales. HDF5's own library tells these, rather than
// netCDF's: that one refuses a whole file for a link that leads nowhere, follows links to other
// files when it opens one, garbles arrays half of whose axes have scales, passes over booleans, and
// does not tell where in the file samples lie, so that none could stay there.
#ifdef OVOID_IO_HDF5
#include "io/foreign/hdf5_cf.h"

#include <fmt/format.h>
#include <hdf5.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/core/axis_order.h"
#include "io/core/cf_grid.h"
#include "io/core/cf_places.h"
#include "io/core/samples.h"
#include "io/core/samples_in_file.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/foreign/hdf5_chunks.h"
#include "io/foreign/hdf5_file.h"
#include "io/foreign/hdf5_storage.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// What netCDF's library puts before the name of a variable that is called like a dimension that it
// does not lie along.
constexpr std::string_view kNoCoordinate = "_nc4_non_coord_";

using Address = std::pair<unsigned long, haddr_t>;

std::optional<Address> address_of(hid_t object) {
  H5O_info_t info{};
  if (H5Oget_info(object, &info) < 0) return std::nullopt;
  return Address(info.fileno, info.addr);
}

// The first scale of an axis.
struct FoundScale {
  std::optional<Address> address;
  std::string name;
};

herr_t take_scale(hid_t /*dataset*/, unsigned /*axis*/, hid_t scale, void* to) {
  auto& found = *static_cast<FoundScale*>(to);
  std::array<char, 1024> name{};
  H5Iget_name(scale, name.data(), name.size() - 1);
  found.address = address_of(scale);
  found.name = name.data();
  return 1;  // no more
}

// Is it there for its length alone?
bool is_dimension_alone(hid_t scale) {
  return hdf5_text(scale, "NAME")
      .value_or("")
      .starts_with("This is a netCDF dimension but not a netCDF variable");
}

class Hdf5CfFile final : public CfFile {
 public:
  explicit Hdf5CfFile(const Hdf5File& file) : CfFile(file.source().name()), file_(file) {
    for (const Hdf5Dataset* const dataset : as_created()) add(*dataset);
  }

  bool has_scales() const noexcept { return !dimensions_.empty(); }
  CfDescription& mutable_description() noexcept { return description_; }

  const CfDescription& description() const override { return description_; }
  const char* format() const override { return has_scales() ? "netCDF" : "HDF5 grid"; }
  // Of a file that is none of netCDF's numbers that were not written are HDF5's own.
  CfFill fill() const override { return has_scales() ? CfFill::kOfNetcdf : CfFill::kNone; }
  std::vector<double> numbers(const CfVariable& variable, std::int64_t most) const override;
  ChunkedArray array(const CfVariable& variable, bool may_stay) const override;

  Hdf5Handle open(const CfVariable& variable) const {
    return {H5Dopen2(file_.id(), stored_of(variable).path.c_str(), H5P_DEFAULT), H5Dclose};
  }

 private:
  std::vector<const Hdf5Dataset*> as_created() const;
  void add(const Hdf5Dataset& dataset);
  std::size_t dimension_of(hid_t dataset, std::size_t axis, std::int64_t size, bool is_unlimited);
  std::size_t named_dimension(const Address& address, std::string_view path, std::int64_t size);
  const Hdf5Dataset& stored_of(const CfVariable& variable) const {
    return *stored_[static_cast<std::size_t>(&variable - description_.variables.data())];
  }
  Hdf5Extent extent_of(const CfVariable& variable) const {
    const Hdf5Dataset& stored = stored_of(variable);
    return {fmt::format("{}: '{}'", name(), stored.path), *stored.type, stored.dims, true};
  }
  std::shared_ptr<const StoredSamples> place_of_rows(hid_t dataset, const Hdf5Extent& extent,
                                                     std::int64_t first, std::int64_t count) const;

  const Hdf5File& file_;
  CfDescription description_;
  std::vector<const Hdf5Dataset*> stored_;  // of the variables
  std::map<Address, std::size_t> dimensions_;
  ReadOptions quiet_{};  // who puts chunks together tells how far that is
  mutable Hdf5Reading reading_{{}, ReadProgress(quiet_, 0)};
};

// Those of a group in the order in which they were made, which classic files have, where the file
// keeps it.
std::vector<const Hdf5Dataset*> Hdf5CfFile::as_created() const {
  struct Made {
    std::size_t group;  // its number
    std::int64_t order;
    const Hdf5Dataset* dataset;
  };
  std::vector<Made> made;
  std::map<std::string, std::size_t> groups;
  for (const Hdf5Dataset& dataset : file_.datasets()) {
    H5L_info_t info{};
    const bool is_known =
        H5Lget_info(file_.id(), dataset.path.c_str(), &info, H5P_DEFAULT) >= 0 && info.corder_valid;
    const std::size_t group = groups.emplace(dataset.group, groups.size()).first->second;
    made.push_back({group, is_known ? info.corder : -1, &dataset});
  }
  std::stable_sort(made.begin(), made.end(), [](const Made& a, const Made& b) {
    return std::pair(a.group, a.order) < std::pair(b.group, b.order);
  });
  std::vector<const Hdf5Dataset*> sorted;
  sorted.reserve(made.size());
  for (const Made& one : made) sorted.push_back(one.dataset);
  return sorted;
}

void Hdf5CfFile::add(const Hdf5Dataset& dataset) {
  const Hdf5Handle stored(H5Dopen2(file_.id(), dataset.path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!stored.is_open()) return;
  const Hdf5Handle space(H5Dget_space(stored.get()), H5Sclose);
  std::array<hsize_t, H5S_MAX_RANK> sizes{}, most{};
  const int rank = H5Sget_simple_extent_dims(space.get(), sizes.data(), most.data());
  if (rank < 0 || rank > static_cast<int>(Hdf5Extent::kMaxRank)) return;
  CfVariable variable{.name = dataset.path.substr(1)};
  if (dataset.type) variable.type = dataset.type->type;
  const std::size_t own = variable.name.size() - variable.own_name().size();
  if (variable.own_name().starts_with(kNoCoordinate))
    variable.name.erase(own, kNoCoordinate.size());
  const bool is_scale = rank == 1 && H5DSis_scale(stored.get()) > 0;
  const auto address = is_scale ? address_of(stored.get()) : std::nullopt;
  for (int axis = 0; axis < rank; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const bool is_unlimited = most[a] == H5S_UNLIMITED;
    if (address) {
      variable.dims.push_back(named_dimension(*address, dataset.path, dataset.dims[a]));
      description_.dimensions[variable.dims[a]].is_unlimited = is_unlimited;
    } else {
      variable.dims.push_back(dimension_of(stored.get(), a, dataset.dims[a], is_unlimited));
    }
  }
  if (is_scale && is_dimension_alone(stored.get())) return;
  if (!variable.type && dataset.type_text != "text" && dataset.type_text != "references")
    variable.unread = dataset.type_text;
  variable.attributes = hdf5_cf_attributes(stored.get());
  description_.variables.push_back(std::move(variable));
  stored_.push_back(&dataset);
}

// That of the axis' first scale, or one of its own, without a name.
std::size_t Hdf5CfFile::dimension_of(hid_t dataset, std::size_t axis, std::int64_t size,
                                     bool is_unlimited) {
  FoundScale found;
  const auto number = static_cast<unsigned>(axis);
  if (H5DSget_num_scales(dataset, number) > 0)
    H5DSiterate_scales(dataset, number, nullptr, take_scale, &found);
  if (found.address) return named_dimension(*found.address, found.name, size);
  description_.dimensions.push_back({"", size, is_unlimited});
  return description_.dimensions.size() - 1;
}

// Files grow along it: it is as long as the longest that lies along it.
std::size_t Hdf5CfFile::named_dimension(const Address& address, std::string_view path,
                                        std::int64_t size) {
  const auto [place, is_new] = dimensions_.emplace(address, description_.dimensions.size());
  if (is_new) {
    std::string_view name = path.substr(path.rfind('/') + 1);
    if (name.starts_with(kNoCoordinate)) name.remove_prefix(kNoCoordinate.size());
    description_.dimensions.push_back({name.empty() ? "?" : std::string(name), size, false});
  }
  CfDimension& dimension = description_.dimensions[place->second];
  dimension.size = std::max(dimension.size, size);
  return place->second;
}

std::vector<double> Hdf5CfFile::numbers(const CfVariable& variable, std::int64_t most) const {
  const std::vector<std::int64_t>& dims = stored_of(variable).dims;
  if (!variable.type || variable.dims.size() > 1 || dims[0] < 1 || dims[0] > most) return {};
  try {
    return file_.values(stored_of(variable));
  } catch (const Error&) {
    return {};  // what is not there says no places
  }
}

// Samples along each axis that are read at once: the file's chunks, each of which is then unpacked
// once, or single ones, and along the axes that vary fastest as many as make some megabytes.
std::vector<std::int64_t> boxes_of(hid_t dataset, const Hdf5Extent& extent,
                                   std::span<const std::int64_t> shape) {
  const std::vector<std::int64_t> units = hdf5_chunk_sizes(dataset, extent);
  std::vector<std::int64_t> box;
  std::int64_t num_bytes = extent.item_size();
  for (std::size_t a = 0; a < shape.size(); ++a) {
    box.push_back(std::clamp<std::int64_t>(units[a], 1, shape[a]));
    num_bytes *= box.back();
  }
  for (std::size_t a = shape.size(); a-- > 0 && num_bytes < ReadProgress::kChunk;) {
    const std::int64_t unit = box[a];
    const std::int64_t wanted = std::max<std::int64_t>(ReadProgress::kChunk / num_bytes, 1);
    box[a] = wanted >= (shape[a] - 1) / unit + 1 ? shape[a] : wanted * unit;
    num_bytes = num_bytes / unit * box[a];
    if (box[a] < shape[a]) break;
  }
  return box;
}

ChunkedArray Hdf5CfFile::array(const CfVariable& variable, bool /*may_stay*/) const {
  const Hdf5Extent extent = extent_of(variable);
  const auto dataset = std::make_shared<const Hdf5Handle>(open(variable));
  if (!dataset->is_open())
    throw Error(ErrorCode::kFileFormat, fmt::format("{} is broken", extent.where));
  if (*std::min_element(extent.dims.begin(), extent.dims.end()) < 1)
    throw Error(ErrorCode::kUnsupported, fmt::format("{}: was never written", extent.where));
  checked_num_bytes(extent.where, extent.dims, extent.type.type);
  check_hdf5_storage(dataset->get(), extent, file_.source());
  ChunkedArray array;
  array.shape = description_.shape(variable);
  array.chunk = boxes_of(dataset->get(), extent, array.shape);
  read_chunks_of_hdf5(dataset, extent, reading_, array);
  if (array.shape == extent.dims)
    array.stored_rows = [this, dataset, extent](std::int64_t first, std::int64_t count) {
      return place_of_rows(dataset->get(), extent, first, count);
    };
  return array;
}

// Of a chunked dataset rows that are chunks of their own.
std::shared_ptr<const StoredSamples> Hdf5CfFile::place_of_rows(hid_t dataset,
                                                               const Hdf5Extent& extent,
                                                               std::int64_t first,
                                                               std::int64_t count) const {
  auto place = place_of_hdf5_storage(file_.id(), dataset, extent);
  if (!place) return nullptr;
  const std::int64_t row = extent.num_bytes() / extent.dims[0];
  place->num_bytes = count * row;
  if (!place->chunked) {
    place->offset += first * row;
  } else if (count < extent.dims[0]) {
    ChunkedStorage rows = *place->chunked;
    if (rows.chunk[0] != 1) return nullptr;
    const std::int64_t in_row = std::ssize(rows.chunks) / extent.dims[0];
    rows.chunks.erase(rows.chunks.begin() + (first + count) * in_row, rows.chunks.end());
    rows.chunks.erase(rows.chunks.begin(), rows.chunks.begin() + first * in_row);
    rows.dims[0] = count;
    place->chunked = std::make_shared<const ChunkedStorage>(std::move(rows));
  }
  return samples_told(*place);
}

// Says the file in a way of its own where samples lie, or which axis is which?
bool says_places(hid_t dataset) {
  static constexpr std::array kNames{"element_size_um", "resolution", "spacing",
                                     "voxel_size",      "axistags",   "DIMENSION_LABELS"};
  return std::any_of(kNames.begin(), kNames.end(),
                     [&](const char* name) { return has_hdf5_attribute(dataset, name); });
}

// Without scales variables are looked at along which something lies; false if there are none, or if
// they say more than CF's conventions do.
bool leave_those_with_axes(Hdf5CfFile& file) {
  CfDescription& description = file.mutable_description();
  const CfCoordinateFinder finder(description);
  bool is_any = false;
  for (CfVariable& variable : description.variables) {
    if (variable.dims.size() < 2 || !variable.type) continue;
    const CfCoordinates coordinates = finder.of(variable);
    const bool has_axes = std::any_of(coordinates.begin(), coordinates.end(),
                                      [](const CfVariable* one) { return one != nullptr; });
    if (has_axes && says_places(file.open(variable).get())) return false;
    is_any = is_any || has_axes;
    if (has_axes) continue;
    variable.type.reset();
    variable.unread = "numbers beside which no axes lie";
  }
  return is_any;
}

}  // namespace

std::optional<Dataset> read_hdf5_cf(const Hdf5File& file, const ReadOptions& options,
                                    Hdf5Axes axes) {
  Hdf5CfFile variables(file);
  if (!variables.has_scales() && (axes == Hdf5Axes::kScales || !leave_those_with_axes(variables)))
    return std::nullopt;
  // What is not there among dimension scales is told so.
  ReadOptions any = options;
  if (variables.has_scales()) any.array.clear();
  if (!has_cf_grid(variables, any)) return std::nullopt;
  return read_cf_grid(variables, options);
}

}  // namespace ovoid::io
#endif
