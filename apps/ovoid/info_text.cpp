// SPDX-License-Identifier: Apache-2.0
#include "info_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <string_view>

#include "color_words.h"
#include "console.h"
#include "ovoid/dataset.h"
#include "profile.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

std::string number_text(const Json& value) {
  return value.is_number_float() ? fmt::format("{:.9g}", value.get<double>()) : value.dump();
}

namespace {

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
    text = ", shown in " + hex_text(array["color"].get<Rgb>());
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

}  // namespace

void print_info(const Json& json) {
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

}  // namespace ovoid::cli
