// SPDX-License-Identifier: Apache-2.0
// Exodus files that name what they do not hold. VTK takes memory for it, finds nothing, and says
// nothing. Fails if what the memory held before is taken for numbers.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/netcdf/test_netcdf.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace exodus_test {

std::string names(const std::vector<std::string>& all) {
  constexpr std::size_t kLength = 33;
  std::string bytes;
  for (std::string name : all) {
    name.resize(kLength, '\0');
    bytes += name;
  }
  return bytes;
}

// A tetrahedron with the variables "temp" and "pres" of its nodes and "heat" of itself, at a time.
TestNc tetrahedron() {
  TestNc nc;
  nc.dims = {{"len_string", 33},     {"four", 4},        {"time_step", 0},   {"num_dim", 3},
             {"num_nodes", 4},       {"num_elem", 1},    {"num_el_blk", 1},  {"num_el_in_blk1", 1},
             {"num_nod_per_el1", 4}, {"num_nod_var", 2}, {"num_elem_var", 1}};
  nc.num_records = 1;
  nc.attributes = {{"api_version", kNcFloat, big_endian<float>({5.14F})},
                   {"version", kNcFloat, big_endian<float>({5.14F})},
                   {"floating_point_word_size", kNcInt, big_endian<std::int32_t>({8})},
                   {"file_size", kNcInt, big_endian<std::int32_t>({1})},
                   nc_text("title", "t")};
  const auto doubles = [](const std::vector<double>& values) { return big_endian(values); };
  const auto whole = [](const std::vector<std::int32_t>& values) { return big_endian(values); };
  nc.variables = {
      {"time_whole", {2}, kNcDouble, doubles({1.5})},
      {"eb_status", {6}, kNcInt, whole({1})},
      {"eb_prop1", {6}, kNcInt, whole({7}), {nc_text("name", "ID")}},
      {"coordx", {4}, kNcDouble, doubles({0, 1, 0, 0})},
      {"coordy", {4}, kNcDouble, doubles({0, 0, 1, 0})},
      {"coordz", {4}, kNcDouble, doubles({0, 0, 0, 1})},
      {"connect1", {7, 8}, kNcInt, whole({1, 2, 3, 4}), {nc_text("elem_type", "TETRA4")}},
      {"name_nod_var", {9, 0}, kNcChar, names({"temp", "pres"})},
      {"name_elem_var", {10, 0}, kNcChar, names({"heat"})},
      {"vals_nod_var1", {2, 4}, kNcDouble, doubles({1, 2, 3, 4})},
      {"vals_nod_var2", {2, 4}, kNcDouble, doubles({5, 6, 7, 8})},
      {"vals_elem_var1eb1", {2, 7}, kNcDouble, doubles({9})},
      {"elem_var_tab", {6, 10}, kNcInt, whole({1})}};
  return nc;
}

class Exodus : public testing::Test {
 protected:
  void SetUp() override {
    if (error_of([&] { read(tetrahedron()); }).find("no VTK") != std::string::npos)
      GTEST_SKIP() << "this build has no VTK";
#ifdef OVOID_SANITIZED
    GTEST_SKIP() << "sanitizers have memory of their own";
#endif
  }

  Dataset read(const TestNc& nc, const ReadOptions& options = {}) const {
    return read_dataset({folder.write("a.e", nc.bytes())}, options);
  }
  // The variable goes by a name under which nobody looks for it.
  static TestNc without(const std::string& variable) {
    TestNc nc = tetrahedron();
    for (TestNcVariable& one : nc.variables)
      if (one.name == variable) one.name.back() = 'X';
    return nc;
  }

  TestFolder folder;
};

std::vector<std::string> names_of(const Dataset& dataset) {
  std::vector<std::string> all;
  for (const DataArray& array : dataset.arrays) all.push_back(array.name);
  std::sort(all.begin(), all.end());
  return all;
}

TEST_F(Exodus, HasItsNumbers) {
  const Dataset mesh = read(tetrahedron());
  EXPECT_EQ(names_of(mesh), (std::vector<std::string>{"heat", "pres", "temp"}));
  EXPECT_EQ(values_of<double>(mesh.array("temp")), (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(values_of<double>(mesh.array("heat")), (std::vector<double>{9}));
}

TEST_F(Exodus, VariablesThatAreNotThereAreLeftOut) {
  const Dataset mesh = read(without("vals_nod_var1"));
  EXPECT_EQ(names_of(mesh), (std::vector<std::string>{"heat", "pres"}));
  ASSERT_EQ(mesh.notes.size(), 1U);
  EXPECT_EQ(mesh.notes[0], folder.file("a.e") +
                               ": array 'temp' is left out: the file names it, and does not hold "
                               "all its numbers");
  // Of cells VTK says so itself.
  EXPECT_NE(error_of([&] { read(without("vals_elem_var1eb1")); }).find("heat"), std::string::npos);
}

TEST_F(Exodus, WithoutWhatWasAskedForItIsRefused) {
  ReadOptions options;
  options.array = "temp";
  EXPECT_EQ(error_of([&] { read(without("vals_nod_var1"), options); }),
            "file-format: " + folder.file("a.e") +
                ": the numbers of array 'temp' are not all in the file: is it damaged?");
  TestNc nothing = tetrahedron();
  for (TestNcVariable& one : nothing.variables) {
    if (one.name.starts_with("vals_nod")) one.name.back() = 'X';
    if (one.name == "elem_var_tab") one.bytes = big_endian<std::int32_t>({0});  // no block has it
  }
  EXPECT_EQ(error_of([&] { read(nothing); }),
            "file-format: " + folder.file("a.e") +
                ": the numbers of its arrays are not all in the file: is it damaged?");
}

// Places and cells of nowhere are no mesh.
TEST_F(Exodus, WithoutPlacesOrCellsItIsRefused) {
  for (const char* const variable : {"coordx", "coordz", "connect1"})
    EXPECT_NE(error_of([&] { read(without(variable)); }), "") << variable;
}

}  // namespace exodus_test
}  // namespace ovoid::io
