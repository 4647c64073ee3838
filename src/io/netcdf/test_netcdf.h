// SPDX-License-Identifier: Apache-2.0
// Classic netCDF files for tests, byte by byte as the format's specification has them.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "io/core/numbers.h"

namespace ovoid::io {

// Numbers of the format's types.
inline constexpr int kNcByte = 1, kNcChar = 2, kNcShort = 3, kNcInt = 4, kNcFloat = 5,
                     kNcDouble = 6, kNcUshort = 8;

template <typename T>
std::string big_endian(const std::vector<T>& values) {
  std::string bytes;
  for (T value : values) {
    if (std::endian::native == std::endian::little) value = swapped(value);
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  return bytes;
}

struct TestNcAttribute {
  std::string name;
  int type = kNcChar;
  std::string bytes;  // big endian
};

struct TestNcVariable {
  std::string name;
  std::vector<int> dims;
  int type = kNcFloat;
  std::string bytes;  // of all records, big endian
  std::vector<TestNcAttribute> attributes{};
};

struct TestNc {
  int version = 1;
  std::vector<std::pair<std::string, std::int64_t>> dims;  // 0: of the records
  std::int64_t num_records = 0;
  std::vector<TestNcVariable> variables;
  std::vector<TestNcAttribute> attributes{};
  bool is_being_written = false;  // leaves open how many records there are

  std::string bytes() const {
    const std::string start = header(std::vector<std::int64_t>(variables.size(), 0));
    auto end = static_cast<std::int64_t>(start.size());
    std::vector<std::int64_t> begins(variables.size());
    std::string whole, records;
    for (std::size_t i = 0; i < variables.size(); ++i) {
      if (has_records(variables[i])) continue;
      begins[i] = end + static_cast<std::int64_t>(whole.size());
      whole += padded(variables[i].bytes);
    }
    end += static_cast<std::int64_t>(whole.size());
    std::size_t num_of_records = 0;
    for (const TestNcVariable& variable : variables) num_of_records += has_records(variable);
    for (std::int64_t r = 0; r < num_records; ++r) {
      for (std::size_t i = 0; i < variables.size(); ++i) {
        if (!has_records(variables[i])) continue;
        if (r == 0) begins[i] = end + static_cast<std::int64_t>(records.size());
        const std::size_t size = variables[i].bytes.size() / static_cast<std::size_t>(num_records);
        const std::string one = variables[i].bytes.substr(static_cast<std::size_t>(r) * size, size);
        records += num_of_records == 1 ? one : padded(one);
      }
    }
    return header(begins) + whole + records;
  }

 private:
  static std::string padded(std::string bytes) {
    bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
    return bytes;
  }
  static std::string word(std::int64_t value) {
    return big_endian<std::int32_t>({static_cast<std::int32_t>(value)});
  }
  std::string count(std::int64_t value) const {
    return version == 5 ? big_endian<std::int64_t>({value}) : word(value);
  }
  std::string text(const std::string& name) const {
    return count(static_cast<std::int64_t>(name.size())) + padded(name);
  }
  std::string list(int tag, std::size_t size) const {
    return word(size == 0 ? 0 : tag) + count(static_cast<std::int64_t>(size));
  }
  bool has_records(const TestNcVariable& variable) const {
    return !variable.dims.empty() && dims[static_cast<std::size_t>(variable.dims[0])].second == 0;
  }
  std::string listed(const std::vector<TestNcAttribute>& all) const {
    static constexpr int kSizes[] = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
    std::string bytes = list(12, all.size());
    for (const TestNcAttribute& one : all)
      bytes += text(one.name) + word(one.type) +
               count(static_cast<std::int64_t>(one.bytes.size()) / kSizes[one.type]) +
               padded(one.bytes);
    return bytes;
  }
  std::string header(const std::vector<std::int64_t>& begins) const {
    std::string bytes = std::string("CDF") + static_cast<char>(version);
    bytes += count(is_being_written ? -1 : num_records);
    bytes += list(10, dims.size());
    for (const auto& [name, size] : dims) bytes += text(name) + count(size);
    bytes += listed(attributes);
    bytes += list(11, variables.size());
    for (std::size_t i = 0; i < variables.size(); ++i) {
      const TestNcVariable& one = variables[i];
      bytes += text(one.name) + count(static_cast<std::int64_t>(one.dims.size()));
      for (const int dim : one.dims) bytes += count(dim);
      bytes += listed(one.attributes) + word(one.type) + count(0);
      bytes += version == 1 ? word(begins[i]) : big_endian<std::int64_t>({begins[i]});
    }
    return bytes;
  }
};

inline TestNcAttribute nc_text(const std::string& name, const std::string& text) {
  return {name, kNcChar, text};
}

// A climate model's: `temp` of shorts on (time, level, lat, lon) of 2, 3, 2, 4, whose numbers count
// from 0 on in this order, and the variables called like its dimensions.
inline TestNc test_climate(int version = 1) {
  std::vector<std::int16_t> counted(48);
  for (std::size_t i = 0; i < counted.size(); ++i) counted[i] = static_cast<std::int16_t>(i);
  TestNc nc;
  nc.version = version;
  nc.dims = {{"when", 0}, {"plev", 3}, {"rows", 2}, {"cols", 4}};
  nc.num_records = 2;
  nc.variables = {
      {"when",
       {0},
       kNcDouble,
       big_endian<double>({10, 10.5}),
       {nc_text("units", "days since 2000-01-01")}},
      {"plev", {1}, kNcFloat, big_endian<float>({1000, 500, 100}), {nc_text("units", "hPa")}},
      {"rows", {2}, kNcFloat, big_endian<float>({45, 40}), {nc_text("units", "degrees_north")}},
      {"cols",
       {3},
       kNcDouble,
       big_endian<double>({0, 2.5, 5, 7.5}),
       {nc_text("standard_name", "longitude"), nc_text("units", "degrees")}},
      {"temp",
       {0, 1, 2, 3},
       kNcShort,
       big_endian(counted),
       {nc_text("units", "K"),
        {"scale_factor", kNcDouble, big_endian<double>({0.5})},
        {"add_offset", kNcFloat, big_endian<float>({200})},
        {"_FillValue", kNcShort, big_endian<std::int16_t>({31})}}}};
  return nc;
}

// A simulation's: `rho` of floats on (z, y, x) of 2, 2, 3 at these places along x.
inline TestNc test_simulation(const std::vector<float>& x) {
  TestNc nc;
  nc.dims = {{"z", 2}, {"y", 2}, {"x", 3}};
  nc.variables = {
      {"rho", {0, 1, 2}, kNcFloat, big_endian<float>({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11})},
      {"x", {2}, kNcFloat, big_endian(x), {nc_text("units", "m")}},
      {"y", {1}, kNcFloat, big_endian<float>({1, 3}), {nc_text("units", "m")}},
      {"z",
       {0},
       kNcFloat,
       big_endian<float>({0, 50}),
       {nc_text("units", "cm"), nc_text("positive", "down")}}};
  return nc;
}

}  // namespace ovoid::io
