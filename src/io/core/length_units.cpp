// SPDX-License-Identifier: Apache-2.0
#include "io/core/length_units.h"

#include <map>
#include <string_view>
#include <utility>

namespace ovoid::io {

std::string plain_unit(std::string unit) {
  // Angstrom, and micro as it is escaped, as the micro sign and Greek mu in UTF-8, and in Latin 1.
  static constexpr std::pair<std::string_view, std::string_view> kSigns[] = {
      {"\\u00B5", "u"}, {"\\u00b5", "u"},        {"\\u03BC", "u"},
      {"\\u03bc", "u"}, {"\xc2\xb5", "u"},       {"\xce\xbc", "u"},
      {"\xb5", "u"},    {"\\u00C5", "angstrom"}, {"\xc3\x85", "angstrom"},
  };
  for (const auto& [sign, plain] : kSigns)
    for (std::size_t at = 0; (at = unit.find(sign, at)) != std::string::npos; at += plain.size())
      unit.replace(at, sign.size(), plain);
  static const std::map<std::string, std::string, std::less<>> kNames{
      {"micron", "um"},        {"microns", "um"},    {"micrometer", "um"}, {"micrometre", "um"},
      {"micrometers", "um"},   {"inches", "inch"},   {"nanometers", "nm"}, {"millimeters", "mm"},
      {"millimetre", "mm"},    {"nanometre", "nm"},  {"centimetre", "cm"}, {"metre", "m"},
      {"nanometer", "nm"},     {"millimeter", "mm"}, {"centimeter", "cm"}, {"meter", "m"},
      {"kilometer", "km"},     {"picometer", "pm"},  {"pixel", ""},        {"pixels", ""},
      {"reference frame", ""},
  };
  const auto found = kNames.find(unit);
  return found == kNames.end() ? unit : found->second;
}

std::optional<double> metres_in(const std::string& unit) {
  static const std::map<std::string, double> kUnits{
      {"m", 1},      {"cm", 1e-2},        {"mm", 1e-3}, {"um", 1e-6},     {"nm", 1e-9},
      {"pm", 1e-12}, {"angstrom", 1e-10}, {"km", 1e3},  {"inch", 0.0254}, {"in", 0.0254}};
  const auto found = kUnits.find(unit);
  if (found == kUnits.end()) return std::nullopt;
  return found->second;
}

}  // namespace ovoid::io
