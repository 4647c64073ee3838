// SPDX-License-Identifier: Apache-2.0
// Meshes of openPMD [openPMD]: groups of iterations hold records, which are datasets of numbers or
// groups of components, and attributes say where their samples lie.
#ifdef OVOID_IO_HDF5
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "data/shown_step.h"
#include "io/core/axis_order.h"
#include "io/core/numbers.h"
#include "io/core/point_arrays.h"
#include "io/core/sample_parts.h"
#include "io/core/samples.h"
#include "io/foreign/hdf5_dialects.h"
#include "io/foreign/hdf5_volumes.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// How a record's samples lie, each list along the axes of its datasets, slowest first.
struct MeshPlace {
  std::string axes;  // letters
  std::vector<double> spacing, offset;

  friend bool operator==(const MeshPlace&, const MeshPlace&) = default;
};

// A record that is one array, or a component of one.
struct Component {
  std::string name;                      // "rho", "E/x"
  std::string record;                    // the path of the object that has the record's attributes
  std::string path;                      // of its own
  const Hdf5Dataset* dataset = nullptr;  // null: constant
  std::vector<std::int64_t> dims;
  MeshPlace place;
  std::vector<double> position;  // within a cell, along the axes
};

std::string without_slashes(std::string_view path) {
  while (path.starts_with('/')) path.remove_prefix(1);
  while (path.ends_with('/')) path.remove_suffix(1);
  return std::string(path);
}

class OpenPmdReader {
 public:
  OpenPmdReader(const Hdf5File& file, const ReadOptions& options) : file_(file), options_(options) {
    dataset_.source = file.source().name();
    dataset_.format = "HDF5 grid (openPMD)";
  }

  std::optional<Dataset> run() {
    meshes_ = without_slashes(file_.text("/", "meshesPath").value_or(""));
    find_iterations();
    if (meshes_.empty() || iterations_.empty()) return std::nullopt;
    bool has_meshes = false;
    for (const auto& [number, path] : iterations_)
      has_meshes = has_meshes || !components_of(path).empty();
    if (!has_meshes) return std::nullopt;
    const auto num_steps = std::ssize(iterations_);
    check_num_steps(dataset_.source, num_steps);
    dataset_.num_steps = num_steps;
    set_times();
    note_particles();
    if (options_.step) check_step(dataset_.source, *options_.step, num_steps);
    const auto read = [&](std::int64_t step) { return read_iteration(step); };
    if (options_.step || num_steps == 1) return read(options_.step.value_or(0));
    return data::shown_step(dataset_.source, num_steps, options_.array, read);
  }

 private:
  static void add_note(Dataset& dataset, const std::string& what) {
    dataset.notes.push_back(fmt::format("{}: {}", dataset.source, what));
  }

  // Groups that basePath stands for, "/data/%T/": their numbers are those of iterations.
  void find_iterations() {
    const std::string base =
        "/" + without_slashes(file_.text("/", "basePath").value_or("/data/%T/"));
    const std::size_t at = base.find("%T");
    if (at == std::string::npos) {
      iterations_[0] = base;
      return;
    }
    const std::string before = base.substr(0, at), behind = base.substr(at + 2);
    for (const std::string& group : file_.groups()) {
      if (group.size() <= before.size() + behind.size() || !group.starts_with(before) ||
          !group.ends_with(behind))
        continue;
      const auto number = exact_number<std::int64_t>(std::string_view(group).substr(
          before.size(), group.size() - before.size() - behind.size()));
      if (number) iterations_[*number] = group;
    }
  }

  void set_times() {
    std::vector<double> times;
    double unit = 1;
    for (const auto& [number, path] : iterations_) {
      const std::vector<double> time = file_.numbers(path, "time");
      const std::vector<double> factor = file_.numbers(path, "timeUnitSI");
      if (time.size() != 1 || !std::isfinite(time[0]) ||
          (!times.empty() && !(times.back() < time[0])))
        return;
      times.push_back(time[0]);
      if (factor.size() == 1) unit = factor[0];
    }
    dataset_.times = std::move(times);
    if (unit == 1)
      dataset_.time_unit = "s";
    else
      add_note(dataset_, fmt::format("times are in units of {:g} s", unit));
  }

  void note_particles() {
    const std::string particles = without_slashes(file_.text("/", "particlesPath").value_or(""));
    if (particles.empty()) return;
    const std::string species = iterations_.begin()->second + "/" + particles + "/";
    for (const Hdf5Dataset& dataset : file_.datasets()) {
      if (!dataset.path.starts_with(species) || !dataset.path.ends_with("/position/x")) continue;
      add_note(dataset_, fmt::format("meshes are read; --positions {} takes particles instead",
                                     dataset.path));
      return;
    }
  }

  // --- one iteration
  // ------------------------------------------------------------------------------

  // All arrays that its meshes have, whatever is drawn of them.
  std::vector<Component> components_of(const std::string& iteration) const {
    const std::string root = iteration + "/" + meshes_ + "/";
    std::vector<Component> components;
    const auto add = [&](const std::string& path, const Hdf5Dataset* dataset) {
      Component component;
      component.name = path.substr(root.size());
      const std::size_t slash = component.name.find('/');
      if (slash != component.name.rfind('/')) return;  // deeper than components are
      component.record = root + component.name.substr(0, slash);
      component.path = path;
      component.dataset = dataset;
      components.push_back(std::move(component));
    };
    for (const Hdf5Dataset& dataset : file_.datasets())
      if (dataset.path.starts_with(root)) add(dataset.path, &dataset);
    for (const std::string& group : file_.groups()) {
      if (group.starts_with(root) && !file_.numbers(group, "shape").empty() &&
          !file_.numbers(group, "value").empty())
        add(group, nullptr);
    }
    std::sort(components.begin(), components.end(),
              [](const Component& a, const Component& b) { return a.name < b.name; });
    return components;
  }

  // Turns the lists of a record written by Fortran, which counts axes the other way round.
  template <typename T>
  std::vector<T> along_axes(std::vector<T> list, bool is_fortran) const {
    if (is_fortran) std::reverse(list.begin(), list.end());
    return list;
  }

  // Fills in sizes and places. What keeps it from being drawn; empty if nothing does.
  std::string describe(Component& component, Dataset& dataset) const {
    const std::string& record = component.record;
    const bool is_fortran = file_.text(record, "dataOrder").value_or("C") == "F";
    if (component.dataset != nullptr) {
      component.dims = component.dataset->dims;
    } else {
      for (const double size : along_axes(file_.numbers(component.path, "shape"), is_fortran))
        component.dims.push_back(size >= 1 && size <= static_cast<double>(kMaxAxisSize)
                                     ? static_cast<std::int64_t>(size)
                                     : 0);
    }
    if (component.dataset != nullptr && !component.dataset->type)
      return "holds " + component.dataset->type_text;
    const std::string geometry = file_.text(record, "geometry").value_or("cartesian").substr(0, 40);
    if (geometry == "thetaMode")
      return "is given by modes around an axis (geometry thetaMode), which are not drawn";
    const std::size_t rank = component.dims.size();
    if (rank < 2 || rank > 3 || std::count(component.dims.begin(), component.dims.end(), 0) > 0)
      return fmt::format("has {} axes", rank);
    if (std::count_if(component.dims.begin(), component.dims.end(),
                      [](std::int64_t size) { return size > 1; }) < 2)
      return "is one row of samples";
    std::vector<std::string> labels = file_.texts(record, "axisLabels");
    labels.resize(std::min<std::size_t>(labels.size(), Hdf5Extent::kMaxRank));
    for (std::string& label : labels) label = label.substr(0, 20);
    labels = along_axes(std::move(labels), is_fortran);
    set_axes(component, labels, dataset);
    if (geometry != "cartesian")
      add_note(dataset,
               fmt::format("'{}' is in {} coordinates ({}): they are drawn as if they were "
                           "x, y, z",
                           component.name, geometry, fmt::join(labels, ", ")));
    const auto numbers = [&](const std::string& object, const char* name, double otherwise) {
      std::vector<double> list = along_axes(file_.numbers(object, name), is_fortran);
      const bool are_good =
          list.size() == rank &&
          std::all_of(list.begin(), list.end(), [](double n) { return std::isfinite(n); });
      return are_good ? list : std::vector<double>(rank, otherwise);
    };
    component.place.spacing = numbers(record, "gridSpacing", 1);
    component.place.offset = numbers(record, "gridGlobalOffset", 0);
    component.position = numbers(component.path, "position", 0);
    for (double& spacing : component.place.spacing)
      if (spacing == 0) spacing = 1;
    return {};
  }

  // By the labels x, y and z, in whatever order; else as other arrays are taken.
  static void set_axes(Component& component, const std::vector<std::string>& labels,
                       Dataset& dataset) {
    const std::size_t rank = component.dims.size();
    std::string letters;
    for (const std::string& label : labels)
      if (label == "x" || label == "y" || label == "z") letters += label;
    const std::set<char> different(letters.begin(), letters.end());
    if (letters.size() == rank && labels.size() == rank && different.size() == rank) {
      component.place.axes = letters;
      return;
    }
    component.place.axes = rank == 3 ? "zyx" : "yx";
    add_note(dataset, fmt::format("the axes of '{}' are called ({}): they are taken for {}",
                                  component.name, fmt::join(labels, ", "), component.place.axes));
  }

  // Those that are drawn, all at the same places.
  std::vector<Component> choose(const std::string& iteration, Dataset& dataset) const {
    std::vector<Component> chosen;
    std::string reasons;
    for (Component& component : components_of(iteration)) {
      if (!options_.array.empty() && !is_asked(component)) continue;
      const std::string wrong = describe(component, dataset);
      if (wrong.empty()) {
        chosen.push_back(std::move(component));
        continue;
      }
      add_note(dataset, fmt::format("'{}' is left out: it {}", component.name, wrong));
      constexpr std::size_t kMostLetters = 400;
      if (reasons.size() > kMostLetters) continue;
      reasons += fmt::format("{}'{}' {}", reasons.empty() ? "" : ", ", component.name, wrong);
    }
    const auto is_flat = [](const Component& component) { return component.dims.size() < 3; };
    if (!std::all_of(chosen.begin(), chosen.end(), is_flat)) std::erase_if(chosen, is_flat);
    const auto is_constant = [](const Component& c) { return c.dataset == nullptr; };
    if (!chosen.empty() && !std::all_of(chosen.begin(), chosen.end(), is_constant)) return chosen;
    if (reasons.empty() && !chosen.empty()) reasons = "all that is there is constant";
    throw Error(
        options_.array.empty() ? ErrorCode::kUnsupported : ErrorCode::kInvalidArgument,
        fmt::format("{}: openPMD: nothing in '{}/{}' is drawn{}: {}", dataset_.source, iteration,
                    meshes_, options_.array.empty() ? "" : ", asked for '" + options_.array + "'",
                    reasons.empty() ? "it has " + names_in(iteration) : reasons));
  }

  std::string names_in(const std::string& iteration) const {
    std::string names;
    for (const Component& component : components_of(iteration)) {
      constexpr std::size_t kMost = 400;
      if (names.size() > kMost) return names + " and more";
      names += fmt::format("{}'{}'", names.empty() ? "" : ", ", component.name);
    }
    return names.empty() ? "none" : names;
  }

  // By its name, its path, or that of its record.
  bool is_asked(const Component& component) const {
    const std::string& asked = options_.array;
    return component.name == asked || component.path == asked || component.path == "/" + asked ||
           component.path.ends_with("/" + asked);
  }

  void check_alike(const std::vector<Component>& components) const {
    for (const Component& component : components) {
      if (component.dims == components[0].dims && component.place == components[0].place) continue;
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("{}: holds several grids: '{}' [{}] lies elsewhere than '{}' [{}]: "
                              "choose one with --array",
                              dataset_.source, component.name, fmt::join(component.dims, ", "),
                              components[0].name, fmt::join(components[0].dims, ", ")));
    }
  }

  Dataset read_iteration(std::int64_t step) const {
    Dataset dataset = dataset_;
    const std::string& iteration = std::next(iterations_.begin(), step)->second;
    const std::vector<Component> components = choose(iteration, dataset);
    check_alike(components);
    std::vector<Hdf5Volume> volumes;
    for (const Component& component : components) {
      if (component.dataset == nullptr) continue;
      volumes.push_back({component.dataset, name_of(component), component.place.axes});
    }
    ReadOptions own = options_;
    own.step.reset();
    read_hdf5_volumes(file_, volumes, own, dataset);
    for (const Component& component : components)
      if (component.dataset == nullptr) add_constant(component, dataset);
    place(components, dataset);
    note_units(components, dataset);
    dataset.num_steps = dataset_.num_steps;
    dataset.step = step;
    shorten_notes(dataset.notes);
    return dataset;
  }

  std::string name_of(const Component& component) const {
    return options_.array.empty() ? component.name : options_.array;
  }

  void add_constant(const Component& component, Dataset& dataset) const {
    const auto value = static_cast<float>(file_.numbers(component.path, "value")[0]);
    const std::int64_t count = num_samples(dataset.lattice.dims);
    std::byte* to = nullptr;
    DataArray array =
        new_array({name_of(component), ScalarType::kFloat32, 1, count, "", false, {}}, to);
    for (std::int64_t i = 0; i < count; ++i)
      std::memcpy(to + i * static_cast<std::int64_t>(sizeof(float)), &value, sizeof(float));
    dataset.arrays.push_back(std::move(array));
  }

  // A sample lies at offset + (index + position) x spacing, along every axis.
  void place(const std::vector<Component>& components, Dataset& dataset) const {
    const Component& first = components[0];
    Vec3 spacing(0, 0, 0), origin(0, 0, 0);
    constexpr std::string_view kLetters = "xyz";
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = axis_place(first.place.axes, kLetters[i]);
      if (!axis) continue;
      const auto a = static_cast<Eigen::Index>(i);
      spacing[a] = first.place.spacing[*axis];
      origin[a] = first.place.offset[*axis] + first.position[*axis] * spacing[a];
    }
    const double most = spacing.cwiseAbs().maxCoeff();
    const double least = (spacing.array() == 0).select(most, spacing.cwiseAbs()).minCoeff();
    dataset.lattice.world_from_index.linear() =
        (spacing.array() == 0).select(least, spacing).matrix().asDiagonal();
    dataset.lattice.world_from_index.translation() = origin;
    check_geometry(dataset.source + ": gridSpacing", dataset.lattice.world_from_index);
    for (const Component& component : components) {
      if (component.position == first.position) continue;
      add_note(
          dataset,
          fmt::format("samples of '{}' lie elsewhere in their cells (position ({})) than those "
                      "of '{}' ({}), where all are drawn: --array takes one alone",
                      component.name, fmt::join(component.position, ", "), first.name,
                      fmt::join(first.position, ", ")));
      return;
    }
  }

  // Numbers stay those of the file.
  void note_units(const std::vector<Component>& components, Dataset& dataset) const {
    const std::vector<double> grid = file_.numbers(components[0].record, "gridUnitSI");
    if (std::any_of(grid.begin(), grid.end(), [](double unit) { return unit != 1; }))
      add_note(dataset, fmt::format("lengths are in units of {} m", fmt::join(grid, ", ")));
    for (const Component& component : components) {
      const std::vector<double> unit = file_.numbers(component.path, "unitSI");
      if (unit.size() == 1 && unit[0] != 1)
        add_note(dataset, fmt::format("values of '{}' are in units of {:g}, of SI", component.name,
                                      unit[0]));
    }
  }

  const Hdf5File& file_;
  const ReadOptions& options_;
  std::string meshes_;                              // "meshes"
  std::map<std::int64_t, std::string> iterations_;  // their groups, by number
  Dataset dataset_;
};

}  // namespace

std::optional<Dataset> read_openpmd(const Hdf5File& file, const ReadOptions& options) {
  if (!file.text("/", "openPMD")) return std::nullopt;
  return OpenPmdReader(file, options).run();
}

}  // namespace ovoid::io
#endif
