// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "array_facts.h"
#include "histogram.h"
#include "info.h"
#include "load.h"
#include "make_field.h"
#include "ovoid/error.h"
#include "ovoid/look.h"
#include "ovoid/render_options.h"
#include "ovoid/renderer.h"
#include "setting_forms.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Json json_of(const DataArray& array) {
  const ArrayFacts facts = facts_of(array);
  Json json;
  json["name"] = array.name;
  json["type"] = name_of(array.type);
  json["components"] = array.num_components;
  json["tuples"] = array.num_tuples;
  json["range"] = facts.lo <= facts.hi ? Json{facts.lo, facts.hi} : Json(nullptr);
  json["missing"] = facts.num_missing;
  json["unit"] = array.unit;
  json["cell_data"] = array.is_cell_data;
  json["value_scale"] = array.value_scale;
  json["value_offset"] = array.value_offset;
  if (array.display.color) json["color"] = *array.display.color;
  if (array.display.range) json["shown_range"] = *array.display.range;
  return json;
}

// Where the lattice's axes point in the patient, a letter for each, nearest direction of six:
// "LPS". Null without a patient space.
Json orientation_json(const LatticeGeometry& lattice, Space space) {
  if (space == Space::kNone) return nullptr;
  const char* const letters[2] = {space == Space::kLps ? "LPS" : "RAS",
                                  space == Space::kLps ? "RAI" : "LPI"};
  std::string orientation;
  for (int a = 0; a < 3; ++a) {
    const Vec3 axis = lattice.world_from_index.linear().col(a);
    Eigen::Index nearest = 0;
    axis.cwiseAbs().maxCoeff(&nearest);
    orientation += letters[axis[nearest] < 0 ? 1 : 0][nearest];
  }
  return orientation;
}

// The Cartesian lattices that it is made of: one, or two that are alike but for their offset.
Json sublattices_json(const LatticeGeometry& lattice) {
  Json json = Json::array();
  for (int s = 0; s < lattice.num_sublattices(); ++s)
    json.push_back({{"dims", lattice.dims_of(s)}, {"offset", json_of(lattice.offset_of(s))}});
  return json;
}

Json lattice_json(const LatticeGeometry& lattice) {
  const Vec3 spacing = lattice.spacing();
  const Mat3 vectors = lattice.world_from_index.linear();
  const Bounds3 bounds = lattice.world_bounds();
  Json axes = Json::array();
  for (int a = 0; a < 3; ++a) axes.push_back(json_of(vectors.col(a) / vectors.col(a).norm()));
  Json json;
  json["lattice"] = name_of(lattice.kind);
  json["dims"] = lattice.dims;
  json["sublattices"] = sublattices_json(lattice);
  json["spacing"] = json_of(spacing);
  json["origin"] = json_of(lattice.world_from_index.translation());
  json["axes"] = axes;
  json["bounds"] = {json_of(bounds.min()), json_of(bounds.max())};
  return json;
}

Json json_of(const ValueRange& range) {
  return range.is_empty() ? Json(nullptr) : Json{range.lo, range.hi};
}

Json json_of(const Bounds3& bounds) { return {json_of(bounds.min()), json_of(bounds.max())}; }

// What there is to say of kernels that have shapes of their own.
void add_set_json(Json& json, const KernelField& field, const KernelModelReport& report) {
  const KernelSource& source = field.source();
  json["color_array"] = report.color_array;
  json["color_range"] = json_of(field.color_range());
  json["reconstruction"] = name_of(field.reconstruction());
  json["shape"] = source.shape() == KernelShape::kBalls ? "balls" : "ellipsoids";
  json["profile"] = name_of(source.profile());
  json["cutoff"] = source.cutoff();
  json["misplaced"] = report.num_misplaced;
  json["merged"] = report.num_merged;
  json["dangling"] = report.num_dangling;
  json["copies"] = report.num_copies;
  json["degenerate"] = report.num_degenerate;
  json["spacings"] = report.spacings;
  json["axis_ratios"] = report.axis_ratios;
  json["constant"] = nullptr;
  if (report.is_normalized)
    json["constant"] = {{"mean", report.constant_mean}, {"deviation", report.constant_deviation}};
}

// Values under which these shares of the drawn values lie.
constexpr std::array kShares = {0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99};
constexpr std::size_t kBins = 64;

void add_distribution(Json& json, const Field& field, const std::stop_token& stop) {
  const Histogram seen = histogram_of(field, stop);
  json["quantiles"] = Json::array();
  json["histogram"] = nullptr;
  if (seen.values.empty()) return;
  for (const double share : kShares) json["quantiles"].push_back({share, seen.quantile(share)});
  const auto lo = static_cast<double>(seen.values.front());
  const auto hi = static_cast<double>(seen.values.back());
  std::vector<std::int64_t> counts(kBins);
  for (const float value : seen.values) {
    const double place = hi > lo ? (static_cast<double>(value) - lo) / (hi - lo) * kBins : 0;
    ++counts[static_cast<std::size_t>(std::min(place, kBins - 1.0))];
  }
  json["histogram"] = {{"lo", lo}, {"hi", hi}, {"counts", counts}};
}

Json json_of(const Materials& materials) {
  return {{"values", materials.values},
          {"boundaries", materials.boundaries},
          {"noise", materials.noise},
          {"noisiness", materials.noisiness}};
}

Json field_json(const Modelled& modelled, const std::stop_token& stop) {
  const Field& field = modelled.field;
  const KernelField* const set = field.kernels();
  Json json;
  json["array"] = modelled.array;
  json["num_kernels"] = field.num_kernels();
  json["missing"] = set != nullptr ? modelled.kernels.num_missing : modelled.lattice.num_missing;
  json["range"] = json_of(field.value_range());
  add_distribution(json, field, stop);
  if (set != nullptr) {
    add_set_json(json, *set, modelled.kernels);
  } else {
    json["kernel"] = text_of(field.lattice()->kernel());
    json["prefiltered"] = modelled.lattice.is_prefiltered;
    json["materials"] = json_of(materials_of(field));
  }
  json["default_sampling_distance"] = sheet_distance(field, {}, {});  // as `ovoid render` takes it
  json["default_unit_distance"] = default_unit_distance(field);
  json["memory_bytes"] = field.resident_bytes();
  return json;
}

// Of the positions that are finite; empty if none is.
Bounds3 bounds_of(const DataArray& positions) {
  Bounds3 bounds;
  const auto extend = [&]<class T>(T) {
    const std::byte* at = positions.bytes.view.data();
    for (std::int64_t i = 0; i < positions.num_tuples; ++i, at += 3 * sizeof(T)) {
      std::array<T, 3> stored;
      std::memcpy(stored.data(), at, sizeof(stored));
      const Vec3 place(stored[0], stored[1], stored[2]);
      if (place.allFinite()) bounds.extend(place);
    }
  };
  if (positions.num_components != 3) return bounds;
  if (positions.type == ScalarType::kFloat32) extend(float{});
  if (positions.type == ScalarType::kFloat64) extend(double{});
  return bounds;
}

const char* name_of_cell(CellType type) {
  switch (type) {
    case CellType::kVertex:
      return "vertex";
    case CellType::kLine:
      return "line";
    case CellType::kTriangle:
      return "triangle";
    case CellType::kQuad:
      return "quad";
    case CellType::kTetrahedron:
      return "tetrahedron";
    case CellType::kHexahedron:
      return "hexahedron";
    case CellType::kVoxel:
      return "voxel";
    case CellType::kWedge:
      return "wedge";
    case CellType::kPyramid:
      return "pyramid";
    case CellType::kQuadraticTetrahedron:
      return "quadratic tetrahedron";
    case CellType::kQuadraticHexahedron:
      return "quadratic hexahedron";
    case CellType::kQuadraticWedge:
      return "quadratic wedge";
    case CellType::kQuadraticPyramid:
      return "quadratic pyramid";
    case CellType::kTriQuadraticHexahedron:
      return "triquadratic hexahedron";
    case CellType::kPolyLine:
      return "line of several";
    case CellType::kOther:
      break;
  }
  return "other";
}

Json cells_json(const Cells& cells) {
  Json json;
  json["count"] = cells.count();
  json["dims"] = cells.is_structured() ? Json(cells.dims) : Json(nullptr);
  json["types"] = Json::object();
  if (cells.is_structured()) {
    json["types"][name_of_cell(CellType::kHexahedron)] = cells.count();
    return json;
  }
  std::array<std::int64_t, static_cast<std::size_t>(CellType::kOther) + 1> counts{};
  for (const CellType type : cells.types) ++counts[static_cast<std::size_t>(type)];
  for (std::size_t t = 0; t < counts.size(); ++t) {
    if (counts[t] > 0) json["types"][name_of_cell(static_cast<CellType>(t))] = counts[t];
  }
  return json;
}

Json places_json(const Dataset& dataset) {
  Json json;
  json["points"] = dataset.num_positions();
  json["position_type"] = name_of(dataset.positions.type);
  if (dataset.kind == DatasetKind::kMesh) json["cells"] = cells_json(dataset.cells);
  const Bounds3 bounds = bounds_of(dataset.positions);
  json["bounds"] = bounds.isEmpty() ? Json(nullptr) : json_of(bounds);
  json["periodic_box"] = dataset.periodic_box ? json_of(*dataset.periodic_box) : Json(nullptr);
  return json;
}

// Null, with a note, where nothing can be drawn.
Json try_field(const Dataset& dataset, const ModelFlags& model, const Flags& flags,
               Session& session) {
  if (dataset.kind == DatasetKind::kLattice) {
    const DataArray& array = dataset.array(model.array);
    if (facts_of(array).num_missing == array.num_tuples * array.num_components) {
      session.note(fmt::format("array '{}': none of its {} samples is finite, nothing can be drawn",
                               array.name, array.num_tuples));
      return nullptr;
    }
    return field_json(make_field(dataset, model, 0, session), session.stop());
  }
  try {
    return field_json(make_field(dataset, model, 0, session), session.stop());
  } catch (const Error& error) {
    // What a flag asks for must work; without one, the file is still worth telling about.
    if (error.code() != ErrorCode::kInvalidArgument || is_model_flag_given(flags)) throw;
    session.note(fmt::format("{}: nothing can be drawn", error.what()));
    return nullptr;
  }
}

}  // namespace

Json info_json(const Dataset& dataset, const ModelFlags& model, const Flags& flags,
               Session& session) {
  check_kind_flags(flags, dataset);
  Json json;
  json["kind"] = name_of(dataset.kind);
  json["source"] = dataset.source;
  json["format"] = dataset.format;
  json["space"] = name_of(dataset.space);
  if (dataset.kind == DatasetKind::kLattice) {
    json["orientation"] = orientation_json(dataset.lattice, dataset.space);
    json.update(lattice_json(dataset.lattice));
  } else {
    json.update(places_json(dataset));
  }
  json["blocks"] = Json::array();
  for (const DatasetBlock& block : dataset.blocks)
    json["blocks"].push_back({{"name", block.name}, {"description", block.description}});
  json["block"] = dataset.block;
  json["steps"] = dataset.num_steps;
  json["step"] = dataset.step;
  json["series"] = name_of(dataset.series);
  json["times"] = dataset.times;
  json["time_unit"] = dataset.time_unit;
  json["arrays"] = Json::array();
  if (!has_no_values(dataset))
    for (const DataArray& array : dataset.arrays) json["arrays"].push_back(json_of(array));
  json["field"] = try_field(dataset, model, flags, session);
  return json;
}

}  // namespace ovoid::cli
