// SPDX-License-Identifier: Apache-2.0
// ovoid info: what is in a file, and how it would be drawn. The facts are gathered as JSON, from
// which the text for people is printed too, so that both say the same.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>

#include "array_facts.h"
#include "command.h"
#include "console.h"
#include "environment.h"
#include "histogram.h"
#include "histogram_2d.h"
#include "info.h"
#include "load.h"
#include "make_field.h"
#include "ovoid/devices.h"
#include "ovoid/error.h"
#include "ovoid/look.h"
#include "ovoid/renderer.h"
#include "profile.h"
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
  json["default_sampling_distance"] = field.default_sampling_distance();
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

// A number for people: nine digits tell any two float32 values apart.
std::string number_text(const Json& value) {
  return value.is_number_float() ? fmt::format("{:.9g}", value.get<double>()) : value.dump();
}

// "1 2.5 3"
std::string numbers(const Json& values) {
  std::string out;
  for (const Json& value : values) {
    if (!out.empty()) out += ' ';
    out += number_text(value);
  }
  return out;
}

std::string range_text(const Json& range) {
  return range.is_null() ? "no values" : number_text(range[0]) + " to " + number_text(range[1]);
}

void print_row(const char* name, const std::string& value) { print_out("{:<26}{}\n", name, value); }

std::string scale_text(const Json& array) {
  const auto scale = array["value_scale"].get<double>();
  const auto offset = array["value_offset"].get<double>();
  if (scale == 1.0 && offset == 0.0) return "";
  return fmt::format(", stored x {:.9g} + {:.9g}", scale, offset);
}

// How the file says that a channel is shown.
std::string display_text(const Json& array) {
  std::string text;
  if (array.contains("color")) {
    const auto byte = [&](std::size_t i) {
      return static_cast<int>(std::lround(255 * array["color"].at(i).get<double>()));
    };
    text = fmt::format(", shown in #{:02x}{:02x}{:02x}", byte(0), byte(1), byte(2));
  }
  if (array.contains("shown_range")) {
    text +=
        fmt::format("{} from {}", text.empty() ? ", shown" : "", range_text(array["shown_range"]));
  }
  return text;
}

void print_arrays(const Json& arrays) {
  for (const Json& array : arrays) {
    const auto unit = array["unit"].get<std::string>();
    const auto missing = array["missing"].get<std::int64_t>();
    print_row(
        "array",
        fmt::format(
            "'{}': {}{}, {}{}{}{}{}{}", one_line(array["name"].get<std::string>()),
            array["type"].get<std::string>(),
            array["components"] == 1 ? "" : fmt::format(" x {}", array["components"].get<int>()),
            range_text(array["range"]), unit.empty() ? "" : ' ' + one_line(unit),
            missing == 0 ? "" : fmt::format(", {} missing", missing), scale_text(array),
            display_text(array), array["cell_data"].get<bool>() ? ", per cell" : ""));
  }
}

void print_bounds(const char* name, const Json& bounds) {
  if (bounds.is_null()) return;
  print_row(name, fmt::format("({}) to ({})", numbers(bounds[0]), numbers(bounds[1])));
}

void print_lattice(const Json& json) {
  const Json& parts = json["sublattices"];
  const bool is_divided = parts.size() > 1;
  print_row("lattice", json["lattice"].get<std::string>());
  print_row("dims", is_divided ? numbers(json["dims"]) + " (x, y, layers)" : numbers(json["dims"]));
  for (const Json& part : parts) {
    if (is_divided)
      print_row("sublattice", fmt::format("{} at {} of the axis vectors", numbers(part["dims"]),
                                          numbers(part["offset"])));
  }
  print_row(is_divided ? "spacing T" : "spacing", numbers(json["spacing"]));
  print_row("origin", numbers(json["origin"]));
  print_row("axes", fmt::format("({}) ({}) ({})", numbers(json["axes"][0]),
                                numbers(json["axes"][1]), numbers(json["axes"][2])));
  print_row("space", json["space"].get<std::string>());
  if (!json["orientation"].is_null())
    print_row("orientation",
              json["orientation"].get<std::string>() + " (where x, y, z point, nearest)");
  print_bounds("bounds", json["bounds"]);
}

void print_places(const Json& json) {
  print_row("points", fmt::format("{}, {}", number_text(json["points"]),
                                  json["position_type"].get<std::string>()));
  if (json.contains("cells")) {
    const Json& cells = json["cells"];
    std::string types;
    for (const auto& [type, count] : cells["types"].items())
      types += fmt::format("{}{} {}", types.empty() ? ": " : ", ", number_text(count), type);
    print_row("cells", number_text(cells["count"]) + types);
    if (!cells["dims"].is_null()) print_row("nodes along i, j, k", numbers(cells["dims"]));
  }
  print_row("space", json["space"].get<std::string>());
  print_bounds("bounds", json["bounds"]);
  print_bounds("periodic box", json["periodic_box"]);
}

void print_set(const Json& field) {
  if (field["color_array"] != field["array"]) {
    print_row("colour array",
              fmt::format("'{}', {}", one_line(field["color_array"].get<std::string>()),
                          range_text(field["color_range"])));
  }
  print_row("reconstruction", field["reconstruction"].get<std::string>());
  print_row("shape",
            fmt::format("{}, {}, cut at {} sigmas", field["shape"].get<std::string>(),
                        field["profile"].get<std::string>(), number_text(field["cutoff"])));
  for (const auto& [member, name] : {std::pair{"missing", "without a value"},
                                     {"misplaced", "without a place"},
                                     {"merged", "merged"},
                                     {"dangling", "of no cell"},
                                     {"copies", "periodic copies"},
                                     {"degenerate", "made thicker"}}) {
    if (field[member] != 0) print_row(name, number_text(field[member]));
  }
  const auto quantiles = [](const Json& values) {
    std::string out;
    for (const Json& value : values)
      out += fmt::format("{}{:.4g}", out.empty() ? "" : ", ", value.get<double>());
    return out + " (0, 5, 50, 95, 100 %)";
  };
  print_row("spacing of kernels", quantiles(field["spacings"]));
  print_row("longest / shortest axis", quantiles(field["axis_ratios"]));
  if (!field["constant"].is_null()) {
    print_row("sum of weights",
              fmt::format("{:.4f} +- {:.4f}", field["constant"]["mean"].get<double>(),
                          field["constant"]["deviation"].get<double>()));
  }
}

// A letter for each bin, the blacker the more values, by their logarithm.
std::string letters_of(const Json& counts) {
  constexpr std::string_view kLetters = " .:-=+*#%@";
  double greatest = 1;
  for (const Json& count : counts) greatest = std::max(greatest, count.get<double>());
  std::string letters;
  for (const Json& count : counts) {
    const double height = std::log1p(count.get<double>()) / std::log1p(greatest);
    letters += kLetters[static_cast<std::size_t>(std::ceil(height * (kLetters.size() - 1)))];
  }
  return letters;
}

void print_distribution(const Json& field) {
  if (field["histogram"].is_null()) return;
  std::string values;
  std::string shares;
  for (const Json& pair : field["quantiles"]) {
    const char* const comma = values.empty() ? "" : ", ";
    values += fmt::format("{}{:.4g}", comma, pair[1].get<double>());
    shares += fmt::format("{}{:g}", comma, 100 * pair[0].get<double>());
  }
  print_row("values", fmt::format("{} ({} %)", values, shares));
  const Json& histogram = field["histogram"];
  print_row("histogram", fmt::format("[{}]", letters_of(histogram["counts"])));
}

void print_materials(const Json& materials) {
  const auto listed = [](const Json& values) {
    std::string out;
    for (const Json& value : values)
      out += fmt::format("{}{:.4g}", out.empty() ? "" : ", ", value.get<double>());
    return out;
  };
  if (!materials["values"].empty()) print_row("materials at", listed(materials["values"]));
  if (!materials["boundaries"].empty()) print_row("boundaries at", listed(materials["boundaries"]));
  if (materials["noise"] != 0.0)
    print_row("noise",
              fmt::format("rises {:.4g} from sample to sample, noisiness {:.2g}",
                          materials["noise"].get<double>(), materials["noisiness"].get<double>()));
}

void print_text(const Json& json) {
  print_row("kind", json["kind"].get<std::string>());
  print_row("source", one_line(json["source"].get<std::string>()));
  print_row("format", json["format"].get<std::string>());
  json.contains("points") ? print_places(json) : print_lattice(json);
  for (const Json& block : json["blocks"]) {
    const auto name = block["name"].get<std::string>();
    print_row(
        name == json["block"].get<std::string>() ? "block (read)" : "block",
        fmt::format("'{}': {}", one_line(name), one_line(block["description"].get<std::string>())));
  }
  if (json["steps"] != 1)
    print_row("time steps", fmt::format("{}, step {} is read", json["steps"].get<std::int64_t>(),
                                        json["step"].get<std::int64_t>()));
  if (json["series"] == name_of(SeriesKind::kStaggered))
    print_row("series", "staggered (D4*): odd steps lie half of each axis vector further");
  if (!json["times"].empty()) {
    const auto unit = json["time_unit"].get<std::string>();
    print_row("times", numbers(json["times"]) + (unit.empty() ? "" : ' ' + one_line(unit)));
  }
  print_arrays(json["arrays"]);
  const Json& field = json["field"];
  if (field.is_null()) return;
  print_row("drawn array", fmt::format("'{}', {}", one_line(field["array"].get<std::string>()),
                                       range_text(field["range"])));
  print_distribution(field);
  if (field.contains("materials")) print_materials(field["materials"]);
  print_row("kernels", number_text(field["num_kernels"]));
  if (field.contains("kernel"))
    print_row("kernel", field["kernel"].get<std::string>() +
                            (field["prefiltered"].get<bool>() ? ", prefiltered" : ""));
  if (field.contains("shape")) print_set(field);
  print_row("default sampling distance", number_text(field["default_sampling_distance"]));
  print_row("default unit distance", number_text(field["default_unit_distance"]));
  print_row("memory of the field", readable_bytes(field["memory_bytes"].get<double>()));
}

Json json_of(const DeviceInfo& device) {
  return {{"index", device.index},
          {"name", device.name},
          {"kind", name_of(device.kind)},
          {"memory_bytes", device.memory_bytes},
          {"driver", device.driver},
          {"vulkan", device.api_version},
          {"lack", device.lack.empty() ? Json(nullptr) : Json(device.lack)}};
}

Json devices_json() {
  const DeviceList list = list_devices(setup_of_environment().vulkan);
  Json vulkan;
  vulkan["backend"] = "vulkan";
  vulkan["devices"] = Json::array();
  for (const DeviceInfo& device : list.devices) vulkan["devices"].push_back(json_of(device));
  vulkan["problem"] = list.problem.empty() ? Json(nullptr) : Json(list.problem);
  Json cpu;
  cpu["backend"] = "cpu";
  cpu["simd_targets"] = simd_targets();
  Json reference;
  reference["backend"] = "reference";
  return Json::array({vulkan, cpu, reference});
}

std::string device_text(const Json& device) {
  std::string text = fmt::format(
      "device {}: {}, {}, {}, {}, Vulkan {}", number_text(device["index"]),
      one_line(device["name"].get<std::string>()), device["kind"].get<std::string>(),
      readable_bytes(device["memory_bytes"].get<double>()),
      one_line(device["driver"].get<std::string>()), device["vulkan"].get<std::string>());
  if (device["lack"].is_null()) return text;
  return fmt::format("{}; not usable: it {}", text, device["lack"].get<std::string>());
}

void print_devices(const Json& devices) {
  for (const Json& device : devices) {
    const auto name = device["backend"].get<std::string>();
    const auto print_line = [&](const std::string& text) { print_out("{:<12}{}\n", name, text); };
    if (name == "vulkan") {
      for (const Json& one : device["devices"]) print_line(device_text(one));
      if (!device["problem"].is_null())
        print_line("none: " + one_line(device["problem"].get<std::string>()));
    } else if (name == "cpu") {
      print_line(
          fmt::format("SIMD targets, best first: {}",
                      fmt::join(device["simd_targets"].get<std::vector<std::string>>(), ", ")));
    } else {
      print_line("double precision, slow: the definition");
    }
  }
}

void print_json(const Json& json) {
  // Names in files may hold any bytes; JSON is UTF-8.
  print_out("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

struct InfoFlags {
  bool is_json = false;
  bool lists_devices = false;
  std::string histogram_2d;  // a file; empty: none
};

const Table<InfoFlags>& info_settings() {
  static const Table<InfoFlags> all = {
      {"--json", Toggle(), &InfoFlags::is_json, "as JSON"},
      {"--devices", Toggle(), &InfoFlags::lists_devices,
       "list what can draw on this machine; needs no INPUT"},
      {"--histogram2d", word("OUT.png|OUT.json", Content::kFile), &InfoFlags::histogram_2d,
       "write how often values and gradients go together, as a picture (gradients upwards, the "
       "brighter the more, by the logarithm) or as counts: for choosing the regions of --tf2d"},
  };
  return all;
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
  for (const DataArray& array : dataset.arrays) json["arrays"].push_back(json_of(array));
  json["field"] = try_field(dataset, model, flags, session);
  return json;
}

void run_info(const Words& words, Session& session) {
  DataFlags data;
  ModelFlags model;
  InfoFlags info;
  Flags flags("info", "INPUT... [FLAG...]", "Tells what is in a file, and how it would be drawn.");
  flags.section("");
  flags.add(info_settings(), &info);
  add_input_flags(flags, &data);
  add_array_flags(flags, &model);
  add_kernel_flags(flags, &model);
  flags.add(relevant_settings(), &model);
  if (!flags.parse(words)) return;

  if (info.lists_devices) {
    const Json devices = devices_json();
    return info.is_json ? print_json(devices) : print_devices(devices);
  }
  require_inputs(flags, data);
  take_from_model(&data, &model);
  data.may_stay_in_file = true;
  const Dataset dataset = load(data, session);
  const Json json = info_json(dataset, model, flags, session);
  if (!info.histogram_2d.empty()) {
    const Field field = make_field(dataset, model, 0, session).field;
    const Histogram2D histogram = histogram_2d_of(field, session.stop());
    write_histogram_2d(histogram, info.histogram_2d);
    session.note(fmt::format("{}: values {:g} to {:g}, gradients 0 to {:g}", info.histogram_2d,
                             histogram.value_lo, histogram.value_hi, histogram.gradient_hi));
  }
  return info.is_json ? print_json(json) : print_text(json);
}

}  // namespace ovoid::cli
