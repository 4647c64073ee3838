// SPDX-License-Identifier: Apache-2.0
// FLASH's checkpoint and plot files [FLASH]: blocks of an octree, of which those without children
// (node type 1) hold the solution, with a dataset for each variable.
#ifdef OVOID_IO_HDF5
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "io/core/text_scanner.h"
#include "io/foreign/hdf5_blocks.h"
#include "io/foreign/hdf5_dialects.h"
#include "io/foreign/hdf5_storage.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr const char* kBoundingBoxes = "/bounding box";
constexpr const char* kNodeTypes = "/node type";

std::string without_spaces(std::string text) {
  text.resize(text.find_last_not_of(std::string_view(" \0", 2)) + 1);
  return text;
}

// A list of names and values, such as "real scalars": a compound of a text of a fixed length and
// one more member, which is read as `value_type`, of `value_size` bytes.
std::map<std::string, std::vector<std::byte>> scalars(const Hdf5File& file, const char* path,
                                                      hid_t value_type, std::size_t value_size) {
  constexpr hssize_t kMost = 10000;
  constexpr std::size_t kLongest = 1024;
  const Hdf5Handle dataset(H5Dopen2(file.id(), path, H5P_DEFAULT), H5Dclose);
  if (!dataset.is_open()) return {};
  const Hdf5Handle type(H5Dget_type(dataset.get()), H5Tclose);
  const Hdf5Handle space(H5Dget_space(dataset.get()), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space.get());
  if (count < 1 || count > kMost || H5Tget_class(type.get()) != H5T_COMPOUND ||
      H5Tget_nmembers(type.get()) != 2)
    return {};
  const Hdf5Handle text(H5Tget_member_type(type.get(), 0), H5Tclose);
  const std::size_t length = H5Tget_size(text.get());
  if (H5Tget_class(text.get()) != H5T_STRING || H5Tis_variable_str(text.get()) != 0 || length < 1 ||
      length > kLongest)
    return {};
  char* const names[2] = {H5Tget_member_name(type.get(), 0), H5Tget_member_name(type.get(), 1)};
  const Hdf5Handle memory(H5Tcreate(H5T_COMPOUND, length + value_size), H5Tclose);
  const bool is_made = names[0] != nullptr && names[1] != nullptr &&
                       H5Tinsert(memory.get(), names[0], 0, text.get()) >= 0 &&
                       H5Tinsert(memory.get(), names[1], length, value_type) >= 0;
  for (char* const name : names) H5free_memory(name);
  std::vector<std::byte> bytes(static_cast<std::size_t>(count) * (length + value_size));
  if (!is_made ||
      H5Dread(dataset.get(), memory.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) < 0)
    return {};
  std::map<std::string, std::vector<std::byte>> found;
  for (std::size_t at = 0; at < bytes.size(); at += length + value_size) {
    std::string name(reinterpret_cast<const char*>(&bytes[at]), length);
    name.resize(std::min(name.size(), name.find('\0')));
    found[lower(without_spaces(name))] = {
        bytes.begin() + static_cast<std::ptrdiff_t>(at + length),
        bytes.begin() + static_cast<std::ptrdiff_t>(at + length + value_size)};
  }
  return found;
}

class FlashReader {
 public:
  FlashReader(const Hdf5File& file, const ReadOptions& options, const Hdf5Dataset& boxes,
              const Hdf5Dataset& node_types)
      : file_(file), options_(options), boxes_(boxes), node_types_(node_types) {
    dataset_.source = file.source().name();
    dataset_.format = "FLASH";
  }

  Dataset run() {
    const std::vector<Hdf5BlockArray> variables = find_variables();
    add_blocks(variables);
    tell_geometry();
    tell_time();
    if (file_.find("/tracer particles") != nullptr)
      note("the tracer particles are left out: --positions takes a dataset [N, 3]");
    return boxes_of_blocks(file_, blocks_, variables, options_, std::move(dataset_));
  }

 private:
  void note(const std::string& what) {
    dataset_.notes.push_back(fmt::format("{}: {}", dataset_.source, what));
  }

  // All of one shape, that which most have: values on faces have one more along an axis.
  std::vector<Hdf5BlockArray> find_variables() {
    std::map<std::vector<std::int64_t>, std::vector<const Hdf5Dataset*>> by_shape;
    const std::vector<const Hdf5Dataset*>* most = nullptr;
    for (const Hdf5Dataset& dataset : file_.datasets()) {
      if (dataset.group != "/" || !dataset.type || dataset.dims.size() != 4 ||
          dataset.dims[0] != boxes_.dims[0] ||
          *std::min_element(dataset.dims.begin(), dataset.dims.end()) < 1)
        continue;
      by_shape[dataset.dims].push_back(&dataset);
    }
    for (const auto& [shape, datasets] : by_shape)
      if (most == nullptr || datasets.size() > most->size()) most = &datasets;
    if (most == nullptr) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: is a FLASH file without a variable of {} blocks",
                              dataset_.source, boxes_.dims[0]));
    }
    std::vector<Hdf5BlockArray> variables;
    for (const Hdf5Dataset* dataset : *most)
      variables.push_back({dataset, without_spaces(dataset->name)});
    for (const auto& [shape, datasets] : by_shape) {
      if (&datasets == most) continue;
      note(fmt::format("'{}' [{}] is left out: other variables are [{}]", datasets[0]->path,
                       fmt::join(shape, ", "), fmt::join((*most)[0]->dims, ", ")));
    }
    return variables;
  }

  void add_blocks(const std::vector<Hdf5BlockArray>& variables) {
    const std::vector<double> types = file_.values(node_types_), boxes = file_.values(boxes_);
    const auto num_axes = static_cast<std::size_t>(boxes_.dims[1]);
    const std::vector<std::int64_t>& shape = variables[0].dataset->dims;
    file_.check(*variables[0].dataset);  // places take memory by its sizes
    const std::int64_t counts[3] = {shape[3], shape[2], shape[1]};
    bool is_flat = false;
    for (std::int64_t row = 0; row < boxes_.dims[0]; ++row) {
      if (types[static_cast<std::size_t>(row)] != 1) continue;
      Hdf5Block block{row, {}};
      double least = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t at = (static_cast<std::size_t>(row) * num_axes + axis) * 2;
        double lo = 0, hi = 0;
        if (axis < num_axes) {
          lo = boxes[at];
          hi = boxes[at + 1];
        }
        // Without an axis in the simulation cells are as thick as they are wide.
        if (counts[axis] == 1 && !(lo < hi)) {
          is_flat = true;
          lo = 0;
          hi = least;
        }
        const double step = (hi - lo) / static_cast<double>(counts[axis]);
        if (axis == 0 || step < least) least = step;
        for (std::int64_t i = 0; i <= counts[axis]; ++i)
          block.faces[axis].push_back(i == counts[axis] ? hi : lo + static_cast<double>(i) * step);
      }
      blocks_.push_back(std::move(block));
    }
    if (is_flat) note("has fewer than three dimensions: drawn as a layer of cells");
    note(fmt::format("{} of {} blocks of {}x{}x{} cells have no children and are read",
                     blocks_.size(), boxes_.dims[0], counts[0], counts[1], counts[2]));
  }

  // Only the words of the simulation's own list say that places are no x, y, z.
  void tell_geometry() {
    const Hdf5Handle text(H5Tcopy(H5T_C_S1), H5Tclose);
    constexpr std::size_t kLength = 80;
    H5Tset_size(text.get(), kLength);
    const auto words = scalars(file_, "/string runtime parameters", text.get(), kLength);
    const auto geometry = words.find("geometry");
    if (geometry == words.end()) return;
    std::string word(reinterpret_cast<const char*>(geometry->second.data()), kLength);
    word.resize(std::min(word.size(), word.find('\0')));
    word = without_spaces(word);
    if (!word.empty() && lower(word) != "cartesian")
      note(fmt::format("its geometry is {}: its coordinates are drawn as if they were x, y, z",
                       word));
  }

  void tell_time() {
    const auto reals = scalars(file_, "/real scalars", H5T_NATIVE_DOUBLE, sizeof(double));
    const auto found = reals.find("time");
    double time = 0;
    if (found == reals.end()) return;
    std::memcpy(&time, found->second.data(), sizeof(double));
    if (std::isfinite(time)) dataset_.times = {time};
  }

  const Hdf5File& file_;
  const ReadOptions& options_;
  const Hdf5Dataset& boxes_;
  const Hdf5Dataset& node_types_;
  std::vector<Hdf5Block> blocks_;
  Dataset dataset_;
};

}  // namespace

std::optional<Dataset> read_flash(const Hdf5File& file, const ReadOptions& options) {
  const Hdf5Dataset* const boxes = file.find(kBoundingBoxes);
  const Hdf5Dataset* const types = file.find(kNodeTypes);
  if (boxes == nullptr || types == nullptr || !boxes->type || !types->type) return std::nullopt;
  const auto& dims = boxes->dims;
  if (dims.size() != 3 || dims[0] < 1 || dims[1] < 1 || dims[1] > 3 || dims[2] != 2 ||
      types->dims != std::vector{dims[0]}) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: looks like FLASH's, but '{}' is [{}] and '{}' [{}]: expected "
                            "[blocks, axes, 2] and [blocks]",
                            file.source().name(), kBoundingBoxes, fmt::join(dims, ", "), kNodeTypes,
                            fmt::join(types->dims, ", ")));
  }
  return FlashReader(file, options, *boxes, *types).run();
}

}  // namespace ovoid::io
#endif
