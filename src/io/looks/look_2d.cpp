// SPDX-License-Identifier: Apache-2.0
// Looks by value and gradient, as docs/looks2d.md has them: our own JSON, which look files have
// under "TransferFunction2D", the boxes of ParaView's state files, pictures, and grids of RGBA.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <span>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/text_file.h"
#include "io/core/xml_tags.h"
#include "io/looks/look_readers.h"
#include "io/pictures/pictures.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid {
namespace io {
namespace {

using Axis = TransferFunction2D::Axis;
using Rgba = TransferFunction2D::Rgba;

constexpr const char* kExpected2D =
    "expected JSON with Regions or RGBA (docs/looks2d.md), a look that has a TransferFunction2D, a "
    "ParaView state (.pvsm) with boxes, a PNG picture, or a grid of RGBA";

std::array<double, 2> pair_from(const JsonValue& list) {
  list.array_of(2);
  return {list.element(0).number(), list.element(1).number()};
}

LookRegion region_from(const JsonValue& json) {
  json.object();
  LookRegion region;
  if (json.has("Shape")) {
    const std::string shape = json.member("Shape").string();
    if (shape != "Box" && shape != "Gaussian")
      json.member("Shape").refuse("must be Box or Gaussian");
    if (shape == "Gaussian") region.shape = LookRegion::Shape::kGaussian;
  }
  region.values = pair_from(json.member("Values"));
  region.gradients = pair_from(json.member("Gradients"));
  if (json.has("Color")) {
    const JsonValue color = json.member("Color").array_of(3);
    for (std::size_t c = 0; c < 3; ++c) region.rgb[c] = color.element(c).number();
  }
  for (const auto& [key, into] :
       {std::pair{"Opacity", &region.opacity}, std::pair{"Softness", &region.softness},
        std::pair{"Foot", &region.foot}}) {
    if (json.has(key)) *into = json.member(key).number();
  }
  return region;
}

// A count that an int holds; what is too many is the table's matter.
int count_from(const JsonValue& json) {
  const double count = json.number();
  if (!(count >= 0 && count <= 1e6 && count == std::floor(count)))
    json.refuse("must be a whole number");
  return static_cast<int>(count);
}

TransferFunction2D table_from(const JsonValue& json) {
  const auto [value_lo, value_hi] = pair_from(json.member("Values"));
  const auto [gradient_lo, gradient_hi] = pair_from(json.member("Gradients"));
  const JsonValue size = json.member("Size").array_of(2);
  const JsonValue list = json.member("RGBA").array();
  if (list.size() % 4 != 0) list.refuse("must have four numbers per entry");
  if (list.size() / 4 > TransferFunction2D::kMaxEntries)
    list.refuse(fmt::format("must have at most {} entries", TransferFunction2D::kMaxEntries));
  std::vector<Rgba> entries(list.size() / 4);
  for (std::size_t i = 0; i < list.size(); ++i)
    entries[i / 4][i % 4] = static_cast<float>(list.element(i).number());
  return {{value_lo, value_hi, count_from(size.element(0))},
          {gradient_lo, gradient_hi, count_from(size.element(1))},
          std::move(entries)};
}

// A double that is written with as few digits as the float needs, and reads back the same.
double short_double(float x) { return std::strtod(fmt::format("{}", x).c_str(), nullptr); }

// Throws what the function's construction throws as an error of the file.
template <class Make>
TransferFunction2D of_file(const std::string& path, const Make& make) {
  try {
    return make();
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInvalidArgument) throw;
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", path, error.what()));
  }
}

// <Proxy type="TransferFunction2D"> has a <Property name="Boxes"> of eight <Element value="..."/> a
// box: x, y, width, height, red, green, blue, opacity.
TransferFunction2D read_paraview_state(const std::string& path, const std::string& text) {
  constexpr std::size_t kPerBox = 8;
  constexpr double kAny = 1e300;
  const auto source = open_memory(path, std::as_bytes(std::span(text)));
  XmlTagReader tags(*source);
  bool is_in_function = false;
  bool is_in_boxes = false;
  std::vector<double> numbers;
  while (const auto tag = tags.next()) {
    if (tag->name == "Proxy") is_in_function = tag->attribute("type") == "TransferFunction2D";
    if (tag->name == "/Proxy") {
      if (!numbers.empty()) break;  // the first with boxes
      is_in_function = false;
    }
    if (tag->name == "Property" && !tag->is_empty_element)
      is_in_boxes = is_in_function && tag->attribute("name") == "Boxes";
    if (tag->name == "/Property") is_in_boxes = false;
    if (tag->name != "Element" || !is_in_boxes) continue;
    if (numbers.size() == kPerBox * TransferFunction2D::kMaxRegions)
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: has more than {} boxes", path, TransferFunction2D::kMaxRegions));
    numbers.push_back(number_in(tag->attribute("value"), -kAny, kAny,
                                fmt::format("{}: Boxes[{}]", path, numbers.size())));
  }
  if (numbers.empty() || numbers.size() % kPerBox != 0) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}: has {} numbers in Boxes of a TransferFunction2D, expected eight "
                            "for each box; {}",
                            path, numbers.size(), kExpected2D));
  }
  std::vector<LookRegion> regions;
  for (std::size_t i = 0; i < numbers.size(); i += kPerBox) {
    const double* const n = &numbers[i];
    LookRegion region;
    region.shape = LookRegion::Shape::kGaussian;
    region.values = {n[0], n[0] + n[2]};
    region.gradients = {n[1], n[1] + n[3]};
    region.rgb = {n[4], n[5], n[6]};
    region.opacity = n[7];
    regions.push_back(region);
  }
  return of_file(path, [&] { return TransferFunction2D(std::move(regions)); });
}

// The lowest row of the picture is that of the least gradient.
TransferFunction2D read_picture(const std::string& path, const Ranges2D& ranges) {
  const Rgba8Picture picture = read_png(path);
  const auto width = static_cast<std::size_t>(picture.width);
  const auto height = static_cast<std::size_t>(picture.height);
  std::vector<Rgba> entries(width * height);
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      const std::uint8_t* const pixel = &picture.rgba[4 * ((height - 1 - y) * width + x)];
      for (std::size_t c = 0; c < 4; ++c)
        entries[y * width + x][c] = static_cast<float>(pixel[c]) / 255;
    }
  }
  return of_file(path, [&] {
    return TransferFunction2D({ranges.values[0], ranges.values[1], picture.width},
                              {ranges.gradients[0], ranges.gradients[1], picture.height},
                              std::move(entries));
  });
}

// As vtkVolumeProperty::SetTransferFunction2D() takes one: x is the value, y the gradient. Whole
// numbers are shares of their type's greatest.
TransferFunction2D read_grid(const std::string& path) {
  const Dataset dataset = read_dataset({path});
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}, {}", path, why, kExpected2D));
  };
  if (dataset.kind != DatasetKind::kLattice) refuse("is no grid");
  const LatticeGeometry& grid = dataset.lattice;
  if (grid.dims[2] != 1 || grid.num_sublattices() != 1)
    refuse(fmt::format("has {} x {} x {} samples", grid.dims[0], grid.dims[1], grid.dims[2]));
  const Mat3 axes = grid.world_from_index.linear();
  const Vec3 first = grid.world_from_index.translation();
  if (axes(1, 0) != 0 || axes(0, 1) != 0) refuse("has axes that are not those of x and y");
  const DataArray* colors = nullptr;
  for (const DataArray& array : dataset.arrays) {
    if (array.num_components == 4) colors = &array;
  }
  if (colors == nullptr) refuse("has no array of four components");
  const std::int64_t most = TransferFunction2D::kMaxEntries;
  if (colors->num_tuples > most || colors->num_tuples != grid.dims[0] * grid.dims[1])
    refuse(fmt::format("has {} entries, more than {}, or others than points", colors->num_tuples,
                       most));
  std::vector<Rgba> entries(static_cast<std::size_t>(colors->num_tuples));
  data::visit_scalar(colors->type, [&]<class T>(std::type_identity<T>) {
    const double scale =
        std::is_integral_v<T> ? 1.0 / static_cast<double>(std::numeric_limits<T>::max()) : 1.0;
    const std::byte* const bytes = colors->bytes.view.data();
    for (std::size_t i = 0; i < 4 * entries.size(); ++i) {
      const auto number =
          static_cast<double>(data::load_scalar<T>(bytes, static_cast<std::int64_t>(i)));
      entries[i / 4][i % 4] =
          static_cast<float>((number * colors->value_scale + colors->value_offset) * scale);
    }
  });
  const auto axis = [&](int a) {
    const std::int64_t count = grid.dims[static_cast<std::size_t>(a)];
    return Axis{first[a], first[a] + axes(a, a) * static_cast<double>(count - 1),
                static_cast<int>(count)};
  };
  return of_file(path, [&] { return TransferFunction2D(axis(0), axis(1), std::move(entries)); });
}

bool is_grid(std::string_view head) {
  return head.starts_with("NRRD") || head.starts_with("# vtk DataFile") ||
         head.find("<VTKFile") != std::string_view::npos;
}

}  // namespace

TransferFunction2D function_2d_from(const JsonValue& json) {
  json.object();
  try {
    if (json.has("RGBA")) return table_from(json);
    std::vector<LookRegion> regions;
    const JsonValue list = json.member("Regions").array();
    for (std::size_t i = 0; i < list.size(); ++i) regions.push_back(region_from(list.element(i)));
    return TransferFunction2D(std::move(regions));
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInvalidArgument) throw;
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", json.place(), error.what()));
  }
}

nlohmann::ordered_json json_of(const TransferFunction2D& function) {
  nlohmann::ordered_json json;
  for (const LookRegion& region : function.regions()) {
    nlohmann::ordered_json one;
    one["Shape"] = region.shape == LookRegion::Shape::kBox ? "Box" : "Gaussian";
    one["Values"] = region.values;
    one["Gradients"] = region.gradients;
    one["Color"] = region.rgb;
    one["Opacity"] = region.opacity;
    one["Softness"] = region.softness;
    one["Foot"] = region.foot;
    json["Regions"].push_back(std::move(one));
  }
  if (!function.regions().empty()) return json;
  json["Values"] = {function.values().first, function.values().last};
  json["Gradients"] = {function.gradients().first, function.gradients().last};
  json["Size"] = {function.values().count, function.gradients().count};
  nlohmann::ordered_json& list = json["RGBA"] = nlohmann::ordered_json::array();
  for (const Rgba& entry : function.entries()) {
    for (const float component : entry) list.push_back(short_double(component));
  }
  return json;
}

}  // namespace io

TransferFunction2D transfer_function_2d_from_text(const std::string& text,
                                                  const std::string& source_name) {
  io::require_size(text.size(), io::kMaxJsonBytes, source_name);
  const io::Json json = io::parse_json(text, source_name);
  const io::JsonValue root(json, source_name + ": ");
  if (json.is_object() && !json.contains("TransferFunction2D")) return io::function_2d_from(root);
  const io::JsonValue look = json.is_array() && !json.empty() ? root.element(0).object() : root;
  if (!look.json().is_object() || !look.has("TransferFunction2D"))
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: {}", source_name, io::kExpected2D));
  return io::function_2d_from(look.member("TransferFunction2D"));
}

TransferFunction2D read_transfer_function_2d(const std::string& path,
                                             const std::optional<Ranges2D>& ranges) {
  const std::string text = io::read_text(path, io::kMaxJsonBytes);
  const bool is_picture = text.starts_with("\x89PNG");
  if (is_picture != ranges.has_value()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: {}", path,
                            is_picture ? "a picture needs the ranges of values and gradients"
                                       : "says its ranges itself; ranges are for pictures"));
  }
  constexpr std::size_t kHead = 512;
  if (is_picture) return io::read_picture(path, *ranges);
  if (io::is_grid(std::string_view(text).substr(0, kHead))) return io::read_grid(path);
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '<') return io::read_paraview_state(path, text);
  return transfer_function_2d_from_text(text, path);
}

}  // namespace ovoid
