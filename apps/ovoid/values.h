// SPDX-License-Identifier: Apache-2.0
// From the text of a flag to its value. Every function takes the whole text and throws BadValue,
// which says what was expected; the flag that was given completes the sentence (flags.h).
#pragma once

#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ovoid/lattice.h"
#include "ovoid/math.h"
#include "ovoid/transfer_function.h"

namespace ovoid::cli {

// "expected ...": the second half of an error about a flag.
class BadValue : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// An interval of the real numbers; an open end excludes the bound itself.
struct Interval {
  double lo = -std::numeric_limits<double>::infinity();
  double hi = std::numeric_limits<double>::infinity();
  bool lo_open = false;
  bool hi_open = false;
};

double parse_number(const std::string& text, const Interval& interval = {});  // finite
std::int64_t parse_integer(const std::string& text, std::int64_t lo, std::int64_t hi);
std::uint64_t parse_seed(const std::string& text);

std::vector<double> parse_numbers(const std::string& text, std::size_t count);  // "a,b,c", finite
Rgb parse_rgb(const std::string& text);    // "r,g,b", each in [0, 1], "#rrggbb", or a name
Vec3 parse_vec3(const std::string& text);  // "x,y,z"
std::pair<double, double> parse_range(const std::string& text);  // "LO,HI" with LO < HI
// "K/N": part K of N, from 1.
struct PartChoice {
  int number = 1, count = 1;
};
PartChoice parse_part(const std::string& text);

std::pair<int, int> parse_size(const std::string& text,
                               int greatest);           // "WIDTHxHEIGHT", each 1 to greatest
Index3 parse_dims(const std::string& text);             // "XxYxZ", each >= 1
std::size_t parse_bytes(const std::string& text);       // "4G", "512M", "65536K", bytes; >= 1
ScalarType parse_scalar_type(const std::string& text);  // as find_scalar_type() knows them

// The value whose name is `text`, from a table of names: {{"mid", Slab::kMid}, ...}.
template <typename T>
using Names = std::vector<std::pair<const char*, T>>;

// "mid|mean", for a flag's form in the help.
template <typename T>
std::string joined(const Names<T>& names, const char* separator = "|") {
  std::string all;
  for (const auto& [name, value] : names) all += (all.empty() ? "" : separator) + std::string(name);
  return all;
}

template <typename T>
T parse_name(const std::string& text, const Names<T>& names) {
  for (const auto& [name, value] : names) {
    if (text == name) return value;
  }
  throw BadValue("expected one of " + joined(names, ", "));
}

// The name that stands for `value` in the table.
template <typename T>
const char* name_in(const Names<T>& names, T value) {
  for (const auto& [name, named] : names) {
    if (named == value) return name;
  }
  return "";
}

// Whether the value of a flag that takes a file is its content instead: JSON begins with { or [.
bool is_json(const std::string& text);

std::vector<std::string> split(const std::string& text, char separator);  // keeps empty parts

}  // namespace ovoid::cli
