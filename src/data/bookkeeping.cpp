// SPDX-License-Identifier: Apache-2.0
#include "data/bookkeeping.h"

#include <algorithm>
#include <array>
#include <span>
#include <string_view>

#include "data/varies.h"

namespace ovoid::data {
namespace {

// What numbers and sorts particles, nodes and cells, as programs call it: in small letters, without
// blanks, '_' and '-'.
constexpr std::array kParticleNumbers = std::to_array<std::string_view>({"id",
                                                                         "ids",
                                                                         "particleid",
                                                                         "particleids",
                                                                         "progenitorparticleids",
                                                                         "pid",
                                                                         "index",
                                                                         "indices",
                                                                         "atomid",
                                                                         "tag",
                                                                         "itype",
                                                                         "type",
                                                                         "mol",
                                                                         "fofgroupids",
                                                                         "globalnodeid",
                                                                         "particleindex",
                                                                         "element",
                                                                         "particletype",
                                                                         "nodenumber",
                                                                         "nodeid",
                                                                         "cellnumber",
                                                                         "cellid",
                                                                         "elementnumber",
                                                                         "elementid",
                                                                         "pointid",
                                                                         "rowid"});

// Their places once more, in LAMMPS's words: scaled, unwrapped, both.
constexpr std::array<std::string_view, 9> kParticlePlaces{"xs", "ys",  "zs",  "xu", "yu",
                                                          "zu", "xsu", "ysu", "zsu"};

// The shapes of stored kernels.
constexpr std::array<std::string_view, 3> kKernelShapes{"scale", "rotation", "weight"};

std::string lower(std::string name) {
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return name;
}

bool has_name(std::span<const std::string_view> names, const std::string& name) {
  return std::find(names.begin(), names.end(), lower(name)) != names.end();
}

bool numbers_particles(const std::string& name) {
  std::string word = lower(name);
  std::erase_if(word, [](char c) { return c == ' ' || c == '_' || c == '-'; });
  return has_name(kParticleNumbers, word);
}

}  // namespace

bool is_bookkeeping(const Dataset& dataset, const DataArray& array) {
  return is_bookkeeping(array) ||
         (dataset.kind != DatasetKind::kLattice && numbers_particles(array.name)) ||
         (dataset.kind == DatasetKind::kParticles && has_name(kParticlePlaces, array.name)) ||
         (dataset.kind == DatasetKind::kKernels && has_name(kKernelShapes, array.name));
}

bool is_bookkeeping(const DataArray& array) {
  // Exodus readers and writers, VTK's id filters, and what simulations call the owner of a cell.
  constexpr std::array<std::string_view, 21> kNames{
      "GlobalNodeId",      "PedigreeNodeId", "ObjectId",        "GlobalElementId",
      "PedigreeElementId", "GlobalNodeIds",  "GlobalCellIds",   "GlobalPointIds",
      "PointIds",          "CellIds",        "SourceElementId", "SourceElementSide",
      "ElementBlockIds",   "FileId",         "GlobalIds",       "PedigreeIds",
      "ProcessId",         "BlockId",        "BlockIndex",      "node_ids",
      "element_ids"};
  return array.name.starts_with("vtk") ||
         std::find(kNames.begin(), kNames.end(), array.name) != kNames.end();
}

bool is_part_of_vector(const Dataset& dataset, const DataArray& array) {
  if (array.num_components != 1) return false;
  const auto has_array = [&](const std::string& name) {
    return std::any_of(dataset.arrays.begin(), dataset.arrays.end(),
                       [&](const DataArray& other) { return other.name == name; });
  };
  for (std::size_t i = 0; i < array.name.size(); ++i) {
    for (const std::string_view axes : {"xyz", "XYZ"}) {
      if (axes.find(array.name[i]) == std::string_view::npos) continue;
      const bool has_all = std::all_of(axes.begin(), axes.end(), [&](char axis) {
        std::string name = array.name;
        name[i] = axis;
        return has_array(name);
      });
      if (has_all) return true;
    }
  }
  return false;
}

bool is_density(const DataArray& array) {
  constexpr std::array<std::string_view, 4> kDensities{"density", "densities", "rho",
                                                       "mass_density"};
  return array.num_components == 1 && has_name(kDensities, array.name);
}

bool is_worth_showing(const Dataset& dataset, const std::string& name) {
  if (dataset.arrays.empty()) return true;  // points may have none
  if (!name.empty()) return varies(dataset.array(name));
  const auto begin = dataset.arrays.begin(), end = dataset.arrays.end();
  const bool has_node_array = std::any_of(begin, end, [&](const DataArray& array) {
    return !array.is_cell_data && !is_bookkeeping(dataset, array);
  });
  return std::any_of(begin, end, [&](const DataArray& array) {
    return !is_bookkeeping(dataset, array) && !(has_node_array && array.is_cell_data) &&
           varies(array);
  });
}

}  // namespace ovoid::data
