// SPDX-License-Identifier: Apache-2.0
#include "io/zarr/zarr_cf.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <tuple>
#include <type_traits>
#include <utility>

#include "data/scalar_visit.h"
#include "io/core/json_file.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

constexpr std::int64_t kMostPlaces = 65'536;  // along an axis, that are looked at

CfAttribute attribute_of(const std::string& name, const Json& value) {
  CfAttribute attribute{.name = name};
  if (value.is_string()) attribute.text = value.get<std::string>();
  const auto add = [&](const Json& number) {
    if (!number.is_number()) return;
    attribute.numbers.push_back(number.get<double>());
    if (number.is_number_float()) attribute.type = ScalarType::kFloat64;
  };
  add(value);
  if (value.is_array()) std::for_each(value.begin(), value.end(), add);
  return attribute;
}

CfAttributes attributes_of(const ZarrNode& node) {
  CfAttributes attributes;
  for (const char* const name : kCfAttributes) {
    const auto found = node.attributes.find(name);
    if (found != node.attributes.end()) attributes.push_back(attribute_of(name, *found));
  }
  // xarray says it so.
  const auto fill = node.description.find("fill_value");
  const bool is_missing = node.attributes.contains("_ARRAY_DIMENSIONS") &&
                          fill != node.description.end() && fill->is_number();
  if (!is_missing) return attributes;
  const auto known =
      std::find_if(attributes.begin(), attributes.end(),
                   [](const CfAttribute& attribute) { return attribute.name == "_FillValue"; });
  if (known == attributes.end())
    attributes.push_back(attribute_of("_FillValue", *fill));
  else
    known->numbers.push_back(fill->get<double>());
  return attributes;
}

std::vector<std::int64_t> shape_of(const ZarrNode& node) {
  std::vector<std::int64_t> shape;
  const auto found = node.description.find("shape");
  if (found == node.description.end() || !found->is_array()) return shape;
  for (const Json& size : *found)
    shape.push_back(size.is_number_integer() ? std::max<std::int64_t>(size.get<std::int64_t>(), 0)
                                             : 0);
  return shape;
}

}  // namespace

ZarrCfFile::ZarrCfFile(std::string name, std::shared_ptr<const ZarrStore> store,
                       const std::vector<ZarrNode>& nodes)
    : CfFile(std::move(name)), store_(std::move(store)), nodes_(nodes) {
  std::map<std::tuple<std::string, std::string, std::int64_t>, std::size_t> known;
  for (const ZarrNode& node : nodes) {
    CfVariable variable{.name = node.key};
    variable.attributes = attributes_of(node);
    variable.type = ScalarType::kFloat64;  // of places, which are read as such
    const std::string group = node.key.substr(0, node.key.rfind('/') + 1);
    const std::vector<std::int64_t> shape = shape_of(node);
    std::vector<std::string> names = zarr_axis_names(node);
    if (names.size() != shape.size()) names.assign(shape.size(), "");
    // One axis without a name is called as its array is.
    if (shape.size() == 1 && names[0].empty()) names[0] = variable.own_name();
    for (std::size_t a = 0; a < shape.size(); ++a) {
      std::size_t dimension = description_.dimensions.size();
      if (!names[a].empty())
        dimension = known.emplace(std::tuple(group, names[a], shape[a]), dimension).first->second;
      if (dimension == description_.dimensions.size())
        description_.dimensions.push_back({names[a], shape[a], false});
      variable.dims.push_back(dimension);
    }
    description_.variables.push_back(std::move(variable));
  }
}

std::vector<double> ZarrCfFile::numbers(const CfVariable& variable, std::int64_t most) const {
  try {
    const ChunkedArray array = this->array(variable, false);
    if (array.shape.size() != 1 || array.shape[0] > std::min(most, kMostPlaces) ||
        array.chunk[0] > 16 * kMostPlaces)
      return {};
    std::vector<double> numbers;
    std::vector<std::byte> chunk(static_cast<std::size_t>(num_chunk_bytes(array)));
    for (std::int64_t i = 0; static_cast<std::int64_t>(numbers.size()) < array.shape[0]; ++i) {
      if (!load_chunk(array, std::array{i}, chunk)) return {};
      const std::int64_t left = array.shape[0] - static_cast<std::int64_t>(numbers.size());
      const auto count = static_cast<std::size_t>(std::min(left, array.chunk[0]));
      data::visit_scalar(array.type, [&]<class T>(std::type_identity<T>) {
        for (std::size_t k = 0; k < count; ++k)
          numbers.push_back(static_cast<double>(
              data::load_scalar<T>(chunk.data(), static_cast<std::int64_t>(k))));
      });
    }
    return numbers;
  } catch (const Error&) {
    return {};  // what is no array of numbers says no places
  }
}

ChunkedArray ZarrCfFile::array(const CfVariable& variable, bool /*may_stay*/) const {
  return zarr_array(store_, node_of(variable));
}

}  // namespace ovoid::io
