// SPDX-License-Identifier: Apache-2.0
// Lattice files that are damaged, or say what cannot be: refused by name.
#ifdef OVOID_IO_HDF5
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "fuzz/targets.h"
#include "io/core/test_folder.h"
#include "io/foreign/hdf5_attributes.h"
#include "io/foreign/hdf5_handle.h"
#include "io/hdf5/stored_boxes.h"
#include "io/hdf5/test_lattice_files.h"
#include "io/reader/reader_session.h"
#include "ovoid/series.h"
#include "support/where.h"

#ifdef OVOID_SANITIZED_ADDRESS
// The library loses what it took for a file that it then could not open; of all tests here.
extern "C" const char* __lsan_default_suppressions() {  // NOLINT(bugprone-reserved-identifier)
  return "leak:libhdf5";
}
#endif

namespace ovoid::io {
namespace hdf5_lattice_damage_test {

using testing::HasSubstr;

// Changes a good file through the library.
class Changed {
 public:
  explicit Changed(const std::string& path)
      : file_(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose) {}

  hid_t id() const { return file_.get(); }
  Changed& numbers(const std::string& object, const char* name, const std::vector<double>& values) {
    const hsize_t count = values.size();
    const Hdf5Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    return put(object, name, H5T_NATIVE_DOUBLE, space.get(), values.data());
  }
  Changed& text(const std::string& object, const char* name, const std::string& value) {
    const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
    H5Tset_size(type.get(), value.size());
    H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
    H5Tset_cset(type.get(), H5T_CSET_UTF8);
    return put(object, name, type.get(), space.get(), value.data());
  }
  // The first number of a dataset of one axis or two.
  Changed& first_number(const std::string& dataset, int value) {
    const Hdf5Handle list(H5Dopen2(id(), dataset.c_str(), H5P_DEFAULT), H5Dclose);
    const Hdf5Handle space(H5Dget_space(list.get()), H5Sclose);
    const hsize_t at[] = {0, 0};
    H5Sselect_elements(space.get(), H5S_SELECT_SET, 1, at);
    const Hdf5Handle one(H5Screate(H5S_SCALAR), H5Sclose);
    H5Dwrite(list.get(), H5T_NATIVE_INT, one.get(), space.get(), H5P_DEFAULT, &value);
    return *this;
  }
  Changed& remove(const std::string& object, const char* name) {
    without(object, name);
    return *this;
  }

 private:
  Changed& put(const std::string& object, const char* name, hid_t type, hid_t space,
               const void* values) {
    const Hdf5Handle place = without(object, name);
    const Hdf5Handle made(H5Acreate2(place.get(), name, type, space, H5P_DEFAULT, H5P_DEFAULT),
                          H5Aclose);
    H5Awrite(made.get(), type, values);
    return *this;
  }
  Hdf5Handle without(const std::string& object, const char* name) {
    Hdf5Handle place(H5Oopen(id(), object.c_str(), H5P_DEFAULT), H5Oclose);
    if (has_hdf5_attribute(place.get(), name)) H5Adelete(place.get(), name);
    return place;
  }

  Hdf5Handle file_;
};

class BadLatticeFile : public testing::Test {
 protected:
  BadLatticeFile() : path_(folder_.file("a.h5")) {
    LatticeFileWriter writer(path_, series_header(SeriesKind::kStaggered, {1, 2}));
    writer.write_step(step_of(0));
    writer.write_step(step_of(1));
    writer.finish();
    good_ = folder_.read("a.h5");
  }

  // What reading says of the file after a change.
  std::string after(const std::function<void(Changed&)>& change) {
    folder_.write("a.h5", good_);
    {
      Changed changed(path_);
      change(changed);
    }
    return lattice_error(path_);
  }

  TestFolder folder_;
  std::string path_;
  std::string good_;
};

TEST_F(BadLatticeFile, MissingAttributesAreNamed) {
  EXPECT_EQ(after([](Changed&) {}), "");
  for (const char* name :
       {"version", "lattice", "dims", "world_from_index", "space", "num_steps", "num_arrays"}) {
    EXPECT_EQ(after([&](Changed& c) { c.remove("/", name); }),
              fmt::format("file-format: F: root: attribute '{}' is missing", name));
  }
  for (const char* name : {"name", "components", "value_scale", "value_offset", "encoding"}) {
    EXPECT_EQ(after([&](Changed& c) { c.remove("/array1", name); }),
              fmt::format("file-format: F: array1: attribute '{}' is missing", name));
  }
  EXPECT_EQ(after([](Changed& c) { c.remove("/array0", "unit").remove("/times", "unit"); }), "");
  // An array of three axes is read all the same, as one of another program's.
  EXPECT_EQ(after([](Changed& c) { c.remove("/", "format"); }), "");
}

TEST_F(BadLatticeFile, AttributesOutOfRange) {
  const auto number = [this](const char* object, const char* name, std::vector<double> values) {
    return after([&](Changed& c) { c.numbers(object, name, values); });
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(number("/", "version", {2}),
            "unsupported: F: is version 2 of a lattice file: expected 1: a later Ovoid wrote it");
  EXPECT_THAT(number("/", "version", {0.5}), HasSubstr("'version': 0.5: expected a whole number"));
  EXPECT_THAT(number("/", "dims", {4, 3}), HasSubstr("'dims': expected 3 numbers"));
  EXPECT_THAT(number("/", "dims", {4, 3, 2, 1}), HasSubstr("'dims': expected 3 numbers"));
  EXPECT_THAT(number("/", "dims", {4, 3, 0}), HasSubstr("'dims': 0: expected a whole number"));
  EXPECT_THAT(number("/", "dims", {4, nan, 1}), HasSubstr("'dims': nan: must be finite"));
  EXPECT_THAT(number("/", "dims", {2e9, 2e9, 2e9}), HasSubstr("is larger than any file"));
  EXPECT_EQ(number("/", "dims", {4, 3, 3}),
            "file-format: F: 'array0/step0' has shape [2, 3, 4]: expected [3, 3, 4]");
  EXPECT_THAT(number("/", "world_from_index", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, nan}),
              HasSubstr("must be finite"));
  EXPECT_THAT(number("/", "world_from_index", {1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}),
              HasSubstr("'world_from_index': "));
  EXPECT_THAT(number("/", "num_steps", {2e6}), HasSubstr("2000000 time steps"));
  EXPECT_THAT(number("/", "num_steps", {3}), HasSubstr("'times' has shape [2]: expected [3]"));
  EXPECT_THAT(number("/", "num_arrays", {0}), HasSubstr("'num_arrays': 0"));
  EXPECT_THAT(number("/", "num_arrays", {3}), HasSubstr("group 'array2' is missing"));
  EXPECT_THAT(number("/", "lattice", {3}), HasSubstr("'lattice': expected text"));
  EXPECT_THAT(number("/array1", "components", {3}),
              HasSubstr("'array1/step0' has shape [2, 3, 4, 2]: expected [2, 3, 4, 3]"));
  EXPECT_THAT(number("/array1", "components", {1e9}), HasSubstr("'components': 1000000000"));
  EXPECT_THAT(number("/array0", "value_scale", {0}), HasSubstr("'value_scale': must not be 0"));
  EXPECT_THAT(number("/array0", "value_offset", {nan}), HasSubstr("'value_offset': nan"));
  const auto text = [this](const char* object, const char* name, const char* value) {
    return after([&](Changed& c) { c.text(object, name, value); });
  };
  EXPECT_THAT(text("/", "lattice", "hexagonal"), HasSubstr("'hexagonal': expected cartesian"));
  EXPECT_THAT(text("/", "space", "lps"), HasSubstr("'lps': expected none, LPS or RAS"));
  EXPECT_THAT(text("/array0", "encoding", "zip"),
              HasSubstr("'zip': expected dense, runs, levels or boxes"));
}

TEST_F(BadLatticeFile, TimesThatAreNone) {
  const auto times = [this](std::vector<double> values) {
    return after([&](Changed& c) {
      const Hdf5Handle dataset(H5Dopen2(c.id(), "/times", H5P_DEFAULT), H5Dclose);
      H5Dwrite(dataset.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    });
  };
  EXPECT_EQ(times({1, 3}), "");
  EXPECT_EQ(times({1, std::numeric_limits<double>::quiet_NaN()}),
            "file-format: F: times[1] = nan: must be finite");
  EXPECT_THAT(times({2, 1}), HasSubstr("times: must rise in equal distances"));
}

// The steps are then counted.
TEST_F(BadLatticeFile, TimesMayBeMissing) {
  EXPECT_EQ(after([](Changed& c) { H5Ldelete(c.id(), "/times", H5P_DEFAULT); }), "");
  EXPECT_TRUE(read_dataset({path_}).times.empty());
  EXPECT_EQ(Series(open_steps({path_})).times(), (std::vector<double>{0, 1}));
}

TEST_F(BadLatticeFile, StepsThatAreNotThere) {
  EXPECT_EQ(after([](Changed& c) {
              H5Lcreate_hard(c.id(), "/array0/step0", c.id(), "/array0/step32", H5P_DEFAULT,
                             H5P_DEFAULT);
            }),
            "file-format: F: group 'array0' has 3 members: expected 2, one for each of num_steps");
  EXPECT_EQ(after([](Changed& c) { H5Ldelete(c.id(), "/array1/step0", H5P_DEFAULT); }),
            "file-format: F: dataset 'array1/step0' is missing");
  EXPECT_EQ(after([](Changed& c) {
              H5Ldelete(c.id(), "/array0/step0", H5P_DEFAULT);
              H5Lcreate_external("b.h5", "/array0/step0", c.id(), "/array0/step0", H5P_DEFAULT,
                                 H5P_DEFAULT);
            }),
            "file-format: F: dataset 'array0/step0' is missing");
  // Claims more than the file can hold, and was never written.
  const auto claim = [](hsize_t nx, bool is_chunked) {
    return [=](Changed& c) {
      H5Ldelete(c.id(), "/array0/step0", H5P_DEFAULT);
      const hsize_t dims[] = {2, 3, nx};
      const Hdf5Handle plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
      if (is_chunked) H5Pset_chunk(plist.get(), 3, dims);
      const Hdf5Handle space(H5Screate_simple(3, dims, nullptr), H5Sclose);
      const Hdf5Handle dataset(H5Dcreate2(c.id(), "/array0/step0", H5T_STD_U16LE, space.get(),
                                          H5P_DEFAULT, plist.get(), H5P_DEFAULT),
                               H5Dclose);
    };
  };
  EXPECT_THAT(after(claim(100'000'000, true)), HasSubstr("more than a file of"));
  EXPECT_THAT(after(claim(4, true)), HasSubstr("1 of its 1 chunks were never written"));
  EXPECT_THAT(after(claim(4, false)), HasSubstr("was never written"));
}

TEST_F(BadLatticeFile, RunsThatDoNotFit) {
  Dataset dataset = lattice_dataset({4, 3, 2});
  write_runs(dataset, path_);
  good_ = folder_.read("a.h5");
  EXPECT_EQ(after([](Changed&) {}), "");
  const auto number = [this](const char* name, double value) {
    return after([&](Changed& c) { c.numbers("/array0/step0", name, {value}); });
  };
  EXPECT_THAT(number("num_runs", 1), HasSubstr("'array0/step0/starts' has shape ["));
  EXPECT_THAT(number("num_runs", -1), HasSubstr("'num_runs': -1: expected a whole number from 0"));
  EXPECT_THAT(number("num_relevant", 0), HasSubstr("'array0/step0': 0 values: the runs have "));
  EXPECT_THAT(number("background", 0), HasSubstr("'array0/step0/values' are float32: expected "
                                                 "float64, as the background"));
  for (const char* name : {"num_runs", "num_relevant", "background"})
    EXPECT_THAT(after([&](Changed& c) { c.remove("/array0/step0", name); }), HasSubstr(name));
  for (const char* name : {"row_runs", "starts", "lengths", "values"}) {
    EXPECT_EQ(after([&](Changed& c) {
                H5Ldelete(c.id(), fmt::format("/array0/step0/{}", name).c_str(), H5P_DEFAULT);
              }),
              fmt::format("file-format: F: dataset 'array0/step0/{}' is missing", name));
  }
  const auto first = [this](const char* name, std::uint16_t value) {
    return after([&](Changed& c) { c.first_number(fmt::format("/array0/step0/{}", name), value); });
  };
  EXPECT_THAT(first("starts", 5), HasSubstr("'array0/step0': run 0 has "));
  EXPECT_THAT(first("lengths", 0), HasSubstr("'array0/step0': run 0 has 0 samples"));
  EXPECT_THAT(first("row_runs", 60000), HasSubstr("'array0/step0': row 0 has 60000 runs"));
  // A few bytes that stand for a great many samples.
  EXPECT_THAT(after([](Changed& c) {
                c.numbers("/", "dims", {2e9, 3, 2});
              }),
              HasSubstr("expected at most 65536 for a byte"));
}

TEST_F(BadLatticeFile, LevelsThatDoNotFit) {
  const Dataset dataset = lattice_dataset({4, 3, 2});
  LatticeFileHeader header = lattice_file_header(dataset);
  header.content = LatticeContent::kLevels;
  {
    LatticeFileWriter writer(path_, header);
    const LatticeLevels levels{
        {4, 3, 2},   1, 0, 9, false, 0.5, {{{1, 5, 22}, {7, -2, 900}}, {{0, 1}, {3, 4}}},
        {2, 3, 4, 1}};
    writer.write_levels({&levels, 1});
    writer.finish();
  }
  good_ = folder_.read("a.h5");
  EXPECT_EQ(after([](Changed&) {}), "");
  const auto number = [this](const char* name, const std::vector<double>& values) {
    return after([&](Changed& c) { c.numbers("/array0/step0", name, values); });
  };
  EXPECT_THAT(number("num_levels", {17}), HasSubstr("'num_levels': 17: expected a whole number"));
  EXPECT_THAT(number("num_levels", {1}), HasSubstr("'num_kernels': expected 1 number"));
  EXPECT_THAT(number("num_kernels", {3, 5}), HasSubstr("'num_kernels': 5: expected a whole number "
                                                       "from 0 to 4"));
  EXPECT_THAT(number("num_kernels", {2, 2}), HasSubstr("'array0/step0/gaps0' has shape [3]"));
  EXPECT_THAT(number("num_holes", {13}), HasSubstr("'num_holes': 13: expected a whole number"));
  EXPECT_THAT(number("num_holes", {1}), HasSubstr("'array0/step0/holes' has shape [4]"));
  EXPECT_THAT(number("step", {0}), HasSubstr("'array0/step0': "));
  EXPECT_THAT(number("least", {0}), HasSubstr("'least': expected a number, float32 or of 1 or 2"));
  EXPECT_THAT(number("greatest", {-1}), HasSubstr("least, greatest = 0, -1: must rise"));
  EXPECT_THAT(number("offset", {std::numeric_limits<double>::infinity()}),
              HasSubstr("'offset': inf: must be finite"));
  for (const char* name : {"num_levels", "num_kernels", "offset", "least", "greatest", "step"})
    EXPECT_THAT(after([&](Changed& c) { c.remove("/array0/step0", name); }), HasSubstr(name));
  for (const char* name : {"gaps0", "weights1", "holes"}) {
    EXPECT_EQ(after([&](Changed& c) {
                H5Ldelete(c.id(), fmt::format("/array0/step0/{}", name).c_str(), H5P_DEFAULT);
              }),
              fmt::format("file-format: F: dataset 'array0/step0/{}' is missing", name));
  }
  const auto gap = [&](const char* name, int value) {
    return after([&](Changed& c) { c.first_number(fmt::format("/array0/step0/{}", name), value); });
  };
  EXPECT_THAT(gap("gaps0", 3), HasSubstr("'array0/step0/gaps0': go beyond the level's 24 nodes"));
  EXPECT_THAT(gap("holes", 25), HasSubstr("'array0/step0/holes'[0] = 25: expected 0 to 24"));
  EXPECT_THAT(gap("holes", 24), HasSubstr("holes[1] = 3: must be > 0, and within 24 samples"));
  EXPECT_THAT(gap("gaps0", 99), HasSubstr("'array0/step0/gaps0'[0] = 99: expected 0 to 23"));
  EXPECT_THAT(after([](Changed& c) { c.text("/", "lattice", "body-centred"); }),
              HasSubstr("levels of a lattice that is not cartesian"));
  EXPECT_THAT(after([](Changed& c) {
                c.numbers("/", "dims", {2e9, 3, 2});
              }),
              HasSubstr("expected at most 65536 for a byte"));
}

TEST_F(BadLatticeFile, BoxesThatDoNotFit) {
  LatticeFileHeader header = lattice_file_header(lattice_dataset({4, 3, 2}));
  header.content = LatticeContent::kBoxes;
  {
    LatticeFileWriter writer(path_, header);
    LatticeBoxes boxes;
    boxes.dims = {4, 3, 2};
    boxes.greatest = 9;
    boxes.boxes = {{.gap = 1, .size = {2, 2, 2}, .first = 7, .rise = {1, -2, 900}},
                   {.gap = 3, .size = {3, 1, 1}, .first = 3, .rise = {0, 0, 0}}};
    writer.write_boxes({&boxes, 1});
    writer.finish();
  }
  good_ = folder_.read("a.h5");
  EXPECT_EQ(after([](Changed&) {}), "");
  const auto number = [this](const char* name, double value) {
    return after([&](Changed& c) { c.numbers("/array0/step0", name, {value}); });
  };
  EXPECT_THAT(number("num_boxes", 25), HasSubstr("'num_boxes': 25: expected a whole number"));
  EXPECT_THAT(number("num_boxes", 1), HasSubstr("'array0/step0/gaps' has shape [2]"));
  EXPECT_THAT(number("step", 0), HasSubstr("'array0/step0': step = 0"));
  EXPECT_THAT(number("least", 0), HasSubstr("'least': expected a number, float32 or of 1 or 2"));
  EXPECT_THAT(number("greatest", -1), HasSubstr("least, greatest = 0, -1: must rise"));
  for (const char* name : {"num_boxes", "background", "least", "greatest", "step"})
    EXPECT_THAT(after([&](Changed& c) { c.remove("/array0/step0", name); }), HasSubstr(name));
  for (const BoxNumber& number_of_box : kBoxNumbers) {
    const char* const name = number_of_box.name;
    EXPECT_EQ(after([&](Changed& c) {
                H5Ldelete(c.id(), fmt::format("/array0/step0/{}", name).c_str(), H5P_DEFAULT);
              }),
              fmt::format("file-format: F: dataset 'array0/step0/{}' is missing", name));
  }
  const auto first = [&](const char* name, int value) {
    return after([&](Changed& c) { c.first_number(fmt::format("/array0/step0/{}", name), value); });
  };
  EXPECT_THAT(first("gaps", 3), HasSubstr("boxes[0]: its size along x is 2: expected 1 to 1"));
  EXPECT_THAT(first("gaps", 99), HasSubstr("'array0/step0/gaps'[0] = 99: expected 0 to 24"));
  EXPECT_THAT(first("sizes_y", 0), HasSubstr("'array0/step0/sizes_y'[0] = 0: expected 1 to"));
  EXPECT_THAT(after([](Changed& c) { c.text("/", "lattice", "body-centred"); }),
              HasSubstr("boxes of a lattice that is not cartesian"));
}

TEST_F(BadLatticeFile, CutShort) {
  for (std::size_t size = good_.size() - 1; size > 8; size -= std::min<std::size_t>(size, 97)) {
    folder_.write("a.h5", good_.substr(0, size));
    EXPECT_NE(lattice_error(path_), "") << size;
  }
  folder_.write("a.h5", good_.substr(0, good_.size() - 1));
  EXPECT_EQ(lattice_error(path_),
            "file-format: F: the HDF5 library cannot open it: is the file truncated?");
}

// As in Hdf5Points.DamagedFiles: something consistent, or an Error. What describes things has
// checksums, so that what is left to read is damaged in its samples, or where nothing is.
TEST_F(BadLatticeFile, Damaged) {
  OVOID_NOT_UNDER_TSAN();
  ReadOptions options;
  options.session = std::make_shared<ReaderSession>(std::vector{path_});
  std::mt19937_64 random(20240229);
  int num_read = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string bytes = good_;
    for (std::size_t k = 1 + random() % 4; k > 0; --k)
      bytes[random() % bytes.size()] = static_cast<char>(random());
    if (i % 10 == 0) bytes.resize(random() % bytes.size());
    folder_.write("a.h5", bytes);
    fuzz::expect_dataset_or_error([&] {
      Dataset dataset = read_dataset({path_}, options);
      num_read += dataset.kind == DatasetKind::kLattice ? 1 : 0;
      return dataset;
    });
  }
  EXPECT_GT(num_read, 200);
}

}  // namespace hdf5_lattice_damage_test
}  // namespace ovoid::io
#endif
