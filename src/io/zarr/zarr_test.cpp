// SPDX-License-Identifier: Apache-2.0
// Stores are written here, chunk by chunk, from samples whose values say where they are.
#include "io/zarr/zarr.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "io/core/short_floats.h"
#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/zarr/test_zarr.h"
#include "ovoid/io.h"
#include "support/where.h"

namespace ovoid::io {
namespace zarr_test {

namespace fs = std::filesystem;
using Sizes = std::vector<std::int64_t>;
using Pack = std::function<std::string(const std::string&)>;

std::string sizes_text(const Sizes& sizes) {
  std::string text;
  for (const std::int64_t size : sizes) text += (text.empty() ? "" : ", ") + std::to_string(size);
  return "[" + text + "]";
}

// 1000 of the first axis, 100 of the next ...: of the last it is the index.
std::uint16_t value_at(const Sizes& index) {
  int value = 0;
  for (const std::int64_t i : index) value = 10 * value + static_cast<int>(i);
  return static_cast<std::uint16_t>(value);
}

bool next_index(Sizes& index, const Sizes& ends) {
  for (std::size_t a = index.size(); a-- > 0;) {
    if (++index[a] < ends[a]) return true;
    index[a] = 0;
  }
  return false;
}

struct StoreOptions {
  Sizes shape{3, 4, 5}, chunk{2, 3, 2};
  bool is_big_endian = false, is_first_fastest = false;
  std::string separator = ".", compressor = "null", prefix;
  Pack pack = [](const std::string& bytes) { return bytes; };
};

// An array of uint16 whose samples are value_at().
ZarrFiles store_of(const StoreOptions& options) {
  TestZarray description;
  description.shape = sizes_text(options.shape);
  description.chunks = sizes_text(options.chunk);
  description.dtype = options.is_big_endian ? ">u2" : "<u2";
  description.order = options.is_first_fastest ? "F" : "C";
  description.separator = options.separator;
  description.compressor = options.compressor;
  ZarrFiles files{{options.prefix + ".zarray", zarray(description)}};
  const std::size_t rank = options.shape.size();
  Sizes number(rank, 0), counts;
  for (std::size_t a = 0; a < rank; ++a)
    counts.push_back((options.shape[a] + options.chunk[a] - 1) / options.chunk[a]);
  do {
    std::string name, bytes;
    for (const std::int64_t n : number)
      name += (name.empty() ? "" : options.separator) + std::to_string(n);
    Sizes walked(rank, 0), ends = options.chunk;
    if (options.is_first_fastest) std::reverse(ends.begin(), ends.end());
    do {
      Sizes index = walked;
      if (options.is_first_fastest) std::reverse(index.begin(), index.end());
      for (std::size_t a = 0; a < rank; ++a) index[a] += number[a] * options.chunk[a];
      const std::uint16_t value = value_at(index);
      const char low = static_cast<char>(value & 255), high = static_cast<char>(value >> 8);
      bytes += options.is_big_endian ? std::string{high, low} : std::string{low, high};
    } while (next_index(walked, ends));
    files[options.prefix + name] = options.pack(bytes);
  } while (next_index(number, counts));
  return files;
}

std::string write_store(const TestFolder& folder, const std::string& name, const ZarrFiles& files) {
  const fs::path root(folder.file(name));
  fs::create_directories(root);
  for (const auto& [key, value] : files) {
    fs::create_directories((root / key).parent_path());
    std::ofstream(root / key, std::ios::binary) << value;
  }
  return root.string();
}

std::string error_of_reading(const std::string& path, const ReadOptions& options = {}) {
  return error_of([&] { read_dataset({path}, options); });
}

// The samples of (z, y, x) in their order.
std::vector<std::uint16_t> expected_values(const Sizes& shape) {
  std::vector<std::uint16_t> values;
  Sizes index(shape.size(), 0);
  do values.push_back(value_at(index));
  while (next_index(index, shape));
  return values;
}

void expect_samples(const ZarrFiles& files, const char* what) {
  SCOPED_TRACE(what);
  const TestFolder folder;
  const Dataset dataset = read_dataset({write_store(folder, "a.zarr", files)});
  EXPECT_EQ(dataset.lattice.dims, (Index3{5, 4, 3}));
  ASSERT_EQ(dataset.arrays.size(), 1U);
  EXPECT_EQ(dataset.arrays[0].type, ScalarType::kUInt16);
  EXPECT_EQ(values_of<std::uint16_t>(dataset.arrays[0]), expected_values({3, 4, 5}));
}

// Fails where a chunk's samples go elsewhere, or are unpacked wrongly.
TEST(Zarr, ChunksOfEveryKindGiveTheSameSamples) {
  expect_samples(store_of({}), "plain");
  expect_samples(store_of({.is_big_endian = true, .is_first_fastest = true, .separator = "/"}),
                 "big endian, Fortran order, folders");
  expect_samples(store_of({.chunk = {5, 5, 5}}), "one chunk, larger than the array");
  expect_samples(store_of({.chunk = {1, 1, 1}}), "a chunk for each sample");
  for (const char* const compressor : {"lz4", "lz4hc", "zstd", "zlib", "blosclz"}) {
    for (const int shuffle : {BLOSC_NOSHUFFLE, BLOSC_SHUFFLE, BLOSC_BITSHUFFLE}) {
      expect_samples(store_of({.compressor = R"({"id": "blosc"})",
                               .pack =
                                   [&](const std::string& bytes) {
                                     return with_blosc(bytes, compressor, shuffle, 2);
                                   }}),
                     compressor);
    }
  }
  expect_samples(store_of({.compressor = R"({"id": "zstd", "level": 1})", .pack = with_zstd}),
                 "zstd");
  expect_samples(store_of({.compressor = R"({"id": "lz4"})", .pack = with_lz4}), "lz4");
  expect_samples(store_of({.compressor = R"({"id": "bz2"})", .pack = with_bzip2}), "bz2");
  for (const auto& way : {std::pair("zlib", 15), {"gzip", 15 + 16}}) {
    expect_samples(
        store_of({.compressor = std::string(R"({"id": ")") + way.first + R"("})",
                  .pack = [&](const std::string& b) { return deflated(b, way.second); }}),
        way.first);
  }
}

// A chunk of halves 1 to 8, and chunks that are not there and hold 0.5.
TEST(Zarr, HalvesBecomeFloat32) {
  std::string little, big;
  for (int i = 1; i <= 8; ++i) {
    const std::uint16_t bits = bits_of(static_cast<float>(i), ShortFloat::kHalf);
    little += {static_cast<char>(bits & 255U), static_cast<char>(bits >> 8U)};
    big += {static_cast<char>(bits >> 8U), static_cast<char>(bits & 255U)};
  }
  const std::string third =
      R"({"zarr_format": 3, "node_type": "array", "shape": [2, 2, 3], "data_type": "float16",)"
      R"("chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [2, 2, 2]}},)"
      R"("chunk_key_encoding": {"name": "default"}, "fill_value": 0.5,)"
      R"("codecs": [{"name": "bytes", "configuration": {"endian": "big"}}]})";
  const TestZarray second{.shape = "[2, 2, 3]", .dtype = "<f2", .fill = "0.5"};
  for (const ZarrFiles& files : {ZarrFiles{{".zarray", zarray(second)}, {"0.0.0", little}},
                                 ZarrFiles{{"zarr.json", third}, {"c/0/0/0", big}}}) {
    const TestFolder folder;
    const Dataset dataset = read_dataset({write_store(folder, "a.zarr", files)});
    EXPECT_EQ(values_of<float>(dataset.array()),
              (std::vector<float>{1, 2, 0.5, 3, 4, 0.5, 5, 6, 0.5, 7, 8, 0.5}));
  }
}

TEST(Zarr, IsReadByItsFolderItsDescriptionAndFromZip) {
  const TestFolder folder;
  const ZarrFiles files = store_of({});
  const std::string path = write_store(folder, "a.zarr", files);
  ZarrFiles inner;
  for (const auto& [key, value] : files) inner["b.zarr/" + key] = value;
  for (const std::string& input :
       {path, path + "/", path + "/.zarray", folder.write("a.zip", zip_of(files)),
        folder.write("b.zip", zip_of(inner))}) {
    SCOPED_TRACE(input);
    EXPECT_EQ(values_of<std::uint16_t>(read_dataset({input}).array()), expected_values({3, 4, 5}));
  }
  EXPECT_EQ(files_read_for(path), (std::vector<std::string>{path, path + "/.zarray"}));
  // Several folders are steps.
  const std::string other = write_store(folder, "c.zarr", files);
  const Dataset second = read_dataset({path, other}, {.step = 1});
  EXPECT_EQ(second.num_steps, 2);
  EXPECT_EQ(second.source, other);
}

TEST(Zarr, ChunksThatAreNotThereHoldTheFillValue) {
  const TestFolder folder;
  const auto value_of = [&](const char* dtype, const char* fill) {
    const ZarrFiles files{
        {".zarray",
         zarray({.shape = "[1, 1, 2]", .chunks = "[1, 1, 1]", .dtype = dtype, .fill = fill})}};
    return read_dataset({write_store(folder, "a.zarr", files)}).array();
  };
  EXPECT_EQ(values_of<std::int16_t>(value_of("<i2", "-7")), (std::vector<std::int16_t>{-7, -7}));
  EXPECT_EQ(values_of<std::uint64_t>(value_of("<u8", "18446744073709551615"))[1],
            std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(values_of<float>(value_of("<f4", "null"))[0], 0);
  EXPECT_EQ(values_of<double>(value_of("<f8", "\"-Infinity\""))[0],
            -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(values_of<float>(value_of("<f4", "\"NaN\""))[0]));
  const ZarrFiles wrong{{".zarray", zarray({.fill = "256"})}};
  EXPECT_NE(error_of_reading(write_store(folder, "b.zarr", wrong)).find("expected a uint8"),
            std::string::npos);
}

// --- OME-Zarr -----------------------------------------------------------------------------------

// Two steps, three channels, (2, 3, 4) samples; a coarse level of (1, 2, 2).
ZarrFiles ome_store(const std::string& axes_with_units) {
  ZarrFiles files{{".zgroup", kZgroup}};
  files.merge(store_of(
      {.shape = {2, 3, 2, 3, 4}, .chunk = {1, 2, 2, 2, 3}, .separator = "/", .prefix = "0/"}));
  files.merge(store_of({.shape = {2, 3, 1, 2, 2}, .chunk = {1, 1, 1, 2, 2}, .prefix = "s/1/"}));
  files[".zattrs"] = R"({"multiscales": [{"version": "0.4", )" + axes_with_units + R"(
       "coordinateTransformations": [{"type": "scale", "scale": [0.5, 1, 1, 1, 1]}],
       "datasets": [
        {"path": "0", "coordinateTransformations": [
          {"type": "scale", "scale": [1, 1, 2000, 0.5, 0.25]},
          {"type": "translation", "translation": [3, 0, 1000, 5, 6]}]},
        {"path": "s/1", "coordinateTransformations": [{"type": "scale", "scale": [1, 1, 4000, 1, 1]}]}]}],
       "omero": {"channels": [
         {"label": "DAPI", "color": "0080FF", "window": {"start": 10, "end": 900.5}},
         {"label": "x", "color": "green", "window": {"start": 7, "end": 7}},
         {"label": "x", "color": "#ff0000", "window": {"start": 0, "end": 65535}}]}})";
  return files;
}

constexpr const char* kOmeAxes =
    R"("axes": [{"name": "t", "type": "time", "unit": "second"}, {"name": "c", "type": "channel"},
        {"name": "z", "type": "space", "unit": "nanometer"},
        {"name": "y", "type": "space", "unit": "micrometer"},
        {"name": "x", "type": "space", "unit": "micrometer"}],)";

TEST(Zarr, ImagesHavePlacesTimesAndChannels) {
  const TestFolder folder;
  const std::string path = write_store(folder, "a.zarr", ome_store(kOmeAxes));
  Dataset dataset = read_dataset({path}, {.step = 1});
  EXPECT_EQ(dataset.format, "OME-Zarr");
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  // In micrometres, the unit of x.
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(0.25, 0.5, 2));
  EXPECT_EQ(dataset.lattice.world_from_index.translation(), Vec3(6, 5, 1));
  EXPECT_EQ(dataset.times, (std::vector<double>{1.5, 2}));
  EXPECT_EQ(dataset.time_unit, "s");
  ASSERT_EQ(dataset.arrays.size(), 3U);
  EXPECT_EQ(dataset.arrays[0].name, "DAPI");
  EXPECT_EQ(dataset.arrays[2].name, "x (channel 3)");
  const ChannelDisplay& display = dataset.arrays[0].display;
  EXPECT_EQ(display.color, (std::array{0.0, 128 / 255.0, 1.0}));
  EXPECT_EQ(display.range, (std::array{10.0, 900.5}));
  EXPECT_FALSE(dataset.arrays[1].display.color);
  EXPECT_FALSE(dataset.arrays[1].display.range);
  EXPECT_EQ(dataset.arrays[2].display.color, (std::array{1.0, 0.0, 0.0}));
  EXPECT_FALSE(dataset.arrays[2].display.range);  // all that there are: nobody has chosen it
  std::vector<std::uint16_t> expected;
  for (const std::uint16_t value : expected_values({2, 3, 4}))
    expected.push_back(static_cast<std::uint16_t>(12000 + value));
  EXPECT_EQ(values_of<std::uint16_t>(dataset.arrays[2]), expected);

  dataset = read_dataset({path}, {.array = "x (channel 3)", .step = 1});
  ASSERT_EQ(dataset.arrays.size(), 1U);
  EXPECT_EQ(values_of<std::uint16_t>(dataset.arrays[0]), expected);
  EXPECT_NE(error_of_reading(path, {.array = "y"}).find("'DAPI' 'x (channel 2)'"),
            std::string::npos);
}

TEST(Zarr, ResolutionsAreChosenByBlockOrByTheirFolder) {
  const TestFolder folder;
  const std::string path = write_store(folder, "a.zarr", ome_store(kOmeAxes));
  const Dataset fine = read_dataset({path});
  ASSERT_EQ(fine.blocks.size(), 2U);
  EXPECT_EQ(fine.block, "0");
  EXPECT_EQ(fine.blocks[1].name, "s/1");
  EXPECT_EQ(fine.blocks[1].description, "(2, 3, 1, 2, 2) uint16");
  for (const Dataset& coarse :
       {read_dataset({path}, {.block = "s/1"}), read_dataset({path + "/s/1"})}) {
    EXPECT_EQ(coarse.lattice.dims, (Index3{2, 2, 1}));
    EXPECT_EQ(coarse.lattice.world_from_index.linear().diagonal(), Vec3(1, 1, 4));
    EXPECT_EQ(coarse.num_steps, 2);
    EXPECT_EQ(coarse.arrays.size(), 3U);
  }
  EXPECT_NE(error_of_reading(path, {.block = "2"}).find("expected one of '0' 's/1'"),
            std::string::npos);
}

TEST(Zarr, ImagesWithoutAxesAreThoseOfTheFirstVersions) {
  const TestFolder folder;
  const std::string path = write_store(folder, "a.zarr", ome_store(""));
  const Dataset dataset = read_dataset({path});
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_EQ(dataset.arrays.size(), 3U);
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(0.25, 0.5, 2000));
}

// A plate, or the series of a microscope.
TEST(Zarr, ImagesInGroupsAreBlocks) {
  const TestFolder folder;
  ZarrFiles files{{".zgroup", kZgroup}, {"A/.zgroup", kZgroup}};
  for (const char* const name : {"A/1/", "A/2/"})
    for (const auto& [key, value] : ome_store(kOmeAxes)) files[name + key] = value;
  const std::string path = write_store(folder, "a.zarr", files);
  const Dataset dataset = read_dataset({path}, {.block = "A/2"});
  ASSERT_EQ(dataset.blocks.size(), 2U);
  EXPECT_EQ(dataset.blocks[0].name, "A/1");
  EXPECT_EQ(dataset.block, "A/2");
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
}

// --- arrays without an image --------------------------------------------------------------------

TEST(Zarr, AxesAreTheUsualOnesOrThoseAskedFor) {
  const TestFolder folder;
  const auto store = [&](const Sizes& shape) {
    fs::remove_all(folder.file("a.zarr"));
    return write_store(folder, "a.zarr",
                       store_of({.shape = shape, .chunk = Sizes(shape.size(), 2)}));
  };
  EXPECT_EQ(read_dataset({store({4, 5})}).lattice.dims, (Index3{5, 4, 1}));
  const Dataset colours = read_dataset({store({2, 3, 4, 3})});
  EXPECT_EQ(colours.array().num_components, 3);
  EXPECT_EQ(values_of<std::uint16_t>(colours.array()), expected_values({2, 3, 4, 3}));
  EXPECT_EQ(read_dataset({store({2, 3, 4, 5})}).num_steps, 2);
  EXPECT_EQ(read_dataset({store({2, 3, 4, 5, 5})}).arrays.size(), 3U);

  ReadOptions options;
  options.raw.axis_order = "czyx";
  Dataset asked = read_dataset({store({2, 3, 4, 5})}, options);
  ASSERT_EQ(asked.arrays.size(), 2U);
  EXPECT_EQ(asked.arrays[1].name, "channel 2");
  options.raw.axis_order = "xyz";
  asked = read_dataset({store({3, 4, 5})}, options);
  EXPECT_EQ(asked.lattice.dims, (Index3{3, 4, 5}));
  EXPECT_EQ(values_of<std::uint16_t>(asked.array())[1], value_at({1, 0, 0}));
  for (const auto& [order, what] :
       {std::pair("zyxc", "has 4 letters, the array has 3 axes: (3, 4, 5)"),
        {"zzyx", "expected letters of t, c, z, y and x, each once"},
        {"tcz", "expected y and x among the letters"}}) {
    options.raw.axis_order = order;
    EXPECT_NE(error_of_reading(folder.file("a.zarr"), options).find(what), std::string::npos);
  }
}

TEST(Zarr, AGroupsArraysAreReadIfTheyAreOfOneSize) {
  const TestFolder folder;
  ZarrFiles files{{".zgroup", kZgroup}, {"g/.zgroup", kZgroup}};
  files.merge(store_of({.prefix = "g/a/"}));
  files.merge(store_of({.prefix = "g/b/"}));
  files.merge(store_of({.shape = {7}, .chunk = {7}, .prefix = "g/list/"}));
  const std::string path = write_store(folder, "a.zarr", files);
  const Dataset dataset = read_dataset({path});
  ASSERT_EQ(dataset.arrays.size(), 2U);
  EXPECT_EQ(dataset.arrays[1].name, "g/b");
  EXPECT_EQ(read_dataset({path}, {.array = "b"}).array("b").num_tuples, 60);
  write_store(folder, "a.zarr", store_of({.shape = {4, 4, 4}, .prefix = "c/"}));
  EXPECT_EQ(error_of_reading(path), "invalid-argument: " + path +
                                        ": holds arrays of several sizes: choose one with "
                                        "--array: 'c' 'g/a' 'g/b'");
  EXPECT_EQ(read_dataset({path}, {.array = "c"}).lattice.dims, (Index3{4, 4, 4}));
}

// As xarray writes them.
TEST(Zarr, NamedAxesHavePlacesTimesAndMissingSamples) {
  const TestFolder folder;
  ZarrFiles files{{".zgroup", kZgroup}};
  files.merge(store_of({.shape = {2, 3, 4, 5}, .chunk = {1, 3, 4, 5}, .prefix = "v/"}));
  files["v/.zarray"] = with(files["v/.zarray"], R"("fill_value": 0)", R"("fill_value": 1012)");
  files["v/.zattrs"] = R"({"_ARRAY_DIMENSIONS": ["time", "level", "lat", "lon"],
                           "scale_factor": 0.5, "add_offset": -3, "units": "K"})";
  for (const auto& [name, count] : {std::pair("time", 2), {"level", 3}, {"lat", 4}, {"lon", 5}}) {
    const std::string text = "[" + std::to_string(count) + "]";
    files[std::string(name) + "/.zarray"] = zarray({.shape = text, .chunks = text});
    std::string places;
    for (int i = 0; i < count; ++i) places += static_cast<char>(10 + i * count);
    files[std::string(name) + "/0"] = places;
  }
  const Dataset dataset = read_dataset({write_store(folder, "a.zarr", files)}, {.step = 1});
  EXPECT_EQ(dataset.times, (std::vector<double>{10, 12}));
  EXPECT_EQ(dataset.lattice.world_from_index.linear().diagonal(), Vec3(5, 4, 3));
  EXPECT_EQ(dataset.lattice.world_from_index.translation(), Vec3(10, 10, 10));
  const DataArray& array = dataset.array();
  EXPECT_EQ(array.value_scale, 0.5);
  EXPECT_EQ(array.value_offset, -3);
  EXPECT_EQ(array.unit, "K");
  ASSERT_EQ(array.type, ScalarType::kFloat32);
  const std::vector<float> values = values_of<float>(array);
  EXPECT_TRUE(std::isnan(values[7]));  // 1012: time 1, level 0, lat 1, lon 2
  EXPECT_EQ(values[8], 1013);
}

TEST(Zarr, WhatMemoryDoesNotHoldIsReadChunkByChunk) {
  const TestFolder folder;
  const std::string path =
      write_store(folder, "a.zarr", store_of({.shape = {2, 3, 7, 8, 9}, .chunk = {1, 2, 3, 3, 4}}));
  ReadOptions options;
  options.raw.axis_order = "ctzyx";
  options.step = 2;
  options.array = "channel 2";
  const std::vector<std::uint16_t> expected =
      values_of<std::uint16_t>(read_dataset({path}, options).array());
  options.may_stay_in_file = true;
  options.memory_limit = 1;
  const Dataset dataset = read_dataset({path}, options);
  const auto& stored = dataset.arrays.at(0).stored;
  ASSERT_NE(stored, nullptr);
  ASSERT_EQ(stored->num_bytes(), static_cast<std::int64_t>(expected.size() * 2));
  for (const auto& [first, count] :
       {std::pair<std::size_t, std::size_t>(0, expected.size()), {5, 100}, {503, 1}}) {
    std::vector<std::uint16_t> values(count);
    stored->read(static_cast<std::int64_t>(first * 2), std::as_writable_bytes(std::span(values)));
    EXPECT_EQ(values, std::vector(expected.begin() + static_cast<std::ptrdiff_t>(first),
                                  expected.begin() + static_cast<std::ptrdiff_t>(first + count)));
  }
}

// --- version 3 ----------------------------------------------------------------------------------

std::string zarr_json(const std::string& codecs) {
  return R"({"zarr_format": 3, "node_type": "array", "shape": [3, 4, 5], "data_type": "uint16",
    "chunk_grid": {"name": "regular", "configuration": {"chunk_shape": [2, 3, 2]}},
    "chunk_key_encoding": {"name": "default", "configuration": {"separator": "/"}},
    "fill_value": 0, "dimension_names": ["z", "y", "x"], "codecs": [)" +
         codecs + "]}";
}

ZarrFiles as_version_3(const StoreOptions& options, const std::string& codecs) {
  ZarrFiles files{{"zarr.json", zarr_json(codecs)}};
  for (const auto& [key, value] : store_of(options))
    if (key != ".zarray") files["c/" + key] = value;
  return files;
}

TEST(Zarr, VersionThreeIsRead) {
  expect_samples(as_version_3({.separator = "/"},
                              R"({"name": "bytes", "configuration": {"endian": "little"}})"),
                 "plain");
  expect_samples(
      as_version_3(
          {.is_big_endian = true, .is_first_fastest = true, .separator = "/", .pack = with_zstd},
          R"({"name": "transpose", "configuration": {"order": [2, 1, 0]}},
                      {"name": "bytes", "configuration": {"endian": "big"}},
                      {"name": "zstd", "configuration": {"level": 1, "checksum": false}})"),
      "transposed, big endian, packed");
}

// Chunks of (2, 3, 2) in shards of (2, 3, 4), the first of which lacks one.
TEST(Zarr, ChunksInShardsAreFound) {
  const auto number = [](std::uint64_t value) {
    std::string bytes;
    for (int i = 0; i < 8; ++i) bytes += static_cast<char>(value >> (8 * i) & 255);
    return bytes;
  };
  const std::string index_sum(4, 'x');
  for (const bool is_index_first : {false, true}) {
    const std::string codecs =
        R"({"name": "sharding_indexed", "configuration": {"chunk_shape": [2, 3, 2],
          "codecs": [{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "zstd"}],
          "index_codecs": [{"name": "bytes", "configuration": {"endian": "little"}}, {"name": "crc32c"}],
          "index_location": ")" +
        std::string(is_index_first ? "start" : "end") + "\"}}";
    const ZarrFiles chunks = store_of({.separator = "/", .pack = with_zstd});
    ZarrFiles files{{"zarr.json", with(zarr_json(codecs), "[2, 3, 2]", "[2, 3, 4]")}};
    for (const char* const row : {"0/0/", "0/1/", "1/0/", "1/1/"}) {
      for (int shard = 0; shard < 2; ++shard) {
        std::string index, packed;
        std::uint64_t at = is_index_first ? 36 : 0;
        for (int i = 2 * shard; i < 2 * shard + 2; ++i) {
          const auto chunk = chunks.find(row + std::to_string(i));
          const bool is_there = chunk != chunks.end() && (i > 0 || row != std::string("1/1/"));
          index += is_there ? number(at) + number(chunk->second.size()) : std::string(16, '\xff');
          if (!is_there) continue;
          packed += chunk->second;
          at += chunk->second.size();
        }
        files["c/" + (row + std::to_string(shard))] =
            is_index_first ? index + index_sum + packed : packed + index + index_sum;
      }
    }
    const TestFolder folder;
    const std::string path = write_store(folder, "a.zarr", files);
    std::vector<std::uint16_t> expected = expected_values({3, 4, 5});
    expected[55] = expected[56] = 0;  // z 2, y 3, x 0 and 1
    EXPECT_EQ(values_of<std::uint16_t>(read_dataset({path}).array()), expected);
    files["c/0/0/0"] = is_index_first ? number(1000) + std::string(80, 'x') : std::string(35, 'x');
    const std::string said = error_of_reading(write_store(folder, "a.zarr", files));
    EXPECT_NE(
        said.find(is_index_first ? "lies outside the file" : "is shorter than a shard's index"),
        std::string::npos)
        << said;
  }
}

// The sum of "123456789" is that of the standard.
TEST(Zarr, ChecksumsAreVerified) {
  const std::string codecs = R"({"name": "bytes"}, {"name": "crc32c"})";
  const std::string description =
      with(with(zarr_json(codecs), "[3, 4, 5]", "[1, 1, 9]"), "[2, 3, 2]", "[1, 1, 9]");
  const std::string sum = "\x83\x92\x06\xe3";
  const TestFolder folder;
  ZarrFiles files{{"zarr.json", with(description, "uint16", "uint8")},
                  {"c/0/0/0", "123456789" + sum}};
  EXPECT_EQ(values_of<char>(read_dataset({write_store(folder, "a.zarr", files)}).array())[8], '9');
  files["c/0/0/0"] = "123456780" + sum;
  EXPECT_NE(error_of_reading(write_store(folder, "a.zarr", files)).find("checksum is wrong"),
            std::string::npos);
}

// --- what is refused ----------------------------------------------------------------------------

TEST(Zarr, DescriptionsThatAreNotReadAreRefusedByName) {
  const TestFolder folder;
  const auto said = [&](const std::string& description) {
    return error_of_reading(write_store(folder, "a.zarr", {{".zarray", description}}));
  };
  const auto expect_said = [&](const std::string& description, const char* what) {
    EXPECT_NE(said(description).find(what), std::string::npos) << said(description);
  };
  expect_said(zarray({.filters = R"([{"id": "delta"}])"}), "filter 'delta'");
  expect_said(zarray({.compressor = R"({"id": "lzma"})"}), "is packed by 'lzma'");
  expect_said(zarray({.dtype = "<f3"}), "'<f3'");
  expect_said(zarray({.shape = "[0, 3, 4]"}), "shape[0] = 0: expected a whole number from 1");
  expect_said(zarray({.shape = "[2, 3, 1e300]"}), "shape[2]");
  expect_said(zarray({.chunks = "[0, 1, 1]"}), "chunks[0] = 0");
  expect_said(zarray({.chunks = "[2, 2]"}), "must have 3 elements");
  expect_said(zarray({.shape = "[2147483647, 2147483647, 2147483647]"}), "is larger than any file");
  expect_said(zarray({.chunks = "[2048, 2048, 2048]"}), "expected at most 2 GiB");
  expect_said(zarray({.separator = "x"}), "expected . or /");
  expect_said(with(zarray({}), "\"zarr_format\": 2", "\"zarr_format\": 1"), "version 2 or 3");
  expect_said(R"({"zarr_format": 2)", "not JSON");
  fs::create_directories(folder.file("b.zarr"));
  EXPECT_EQ(error_of_reading(folder.file("b.zarr")),
            "file-format: " + folder.file("b.zarr") +
                ": has no .zarray, .zgroup or zarr.json, which describe a Zarr folder");
}

TEST(Zarr, DamagedChunksAreNamed) {
  OVOID_NOT_UNDER_TSAN();
  const TestFolder folder;
  const auto refused = [&](const StoreOptions& options, const std::string& chunk) {
    ZarrFiles files = store_of(options);
    files["1.1.2"] = chunk;
    const std::string said = error_of_reading(write_store(folder, "a.zarr", files));
    return said.find("file-format: " + folder.file("a.zarr/1.1.2")) == 0;
  };
  const Pack blosc = [](const std::string& bytes) { return with_blosc(bytes, "lz4", 1, 2); };
  const Pack gzip = [](const std::string& bytes) { return deflated(bytes, 31); };
  const std::string whole(24, 'a'), more(26, 'a'), less(22, 'a');
  const std::pair<const char*, Pack> packs[] = {{"blosc", blosc},
                                                {"gzip", gzip},
                                                {"zstd", with_zstd},
                                                {"lz4", with_lz4},
                                                {"bz2", with_bzip2}};
  EXPECT_TRUE(refused({}, less));
  EXPECT_TRUE(refused({}, ""));
  for (const auto& [id, pack] : packs) {
    SCOPED_TRACE(id);
    const StoreOptions options{.compressor = std::string(R"({"id": ")") + id + R"("})",
                               .pack = pack};
    EXPECT_FALSE(refused(options, pack(whole)));
    EXPECT_TRUE(refused(options, pack(more)));
    EXPECT_TRUE(refused(options, pack(less)));
    EXPECT_TRUE(refused(options, pack(whole).substr(0, pack(whole).size() - 10)));
    EXPECT_TRUE(refused(options, whole));
    EXPECT_TRUE(refused(options, ""));
  }
}

// Fails if a description can name files elsewhere.
TEST(Zarr, NothingLeadsOutOfTheFolder) {
  const TestFolder folder;
  write_store(folder, "other", store_of({}));
  for (const char* const path : {"../other", "/tmp", "a/../../other", "", "a//b", "."}) {
    ZarrFiles files{{".zgroup", kZgroup}};
    files[".zattrs"] =
        std::string(R"({"multiscales": [{"axes": ["z", "y", "x"], "datasets": [{"path": ")") +
        path + R"("}]}]})";
    EXPECT_NE(error_of_reading(write_store(folder, "a.zarr", files))
                  .find("expected a path below its folder"),
              std::string::npos);
  }
  ZarrFiles files = store_of({});
  files.erase("0.0.0");
  const std::string root = write_store(folder, "b.zarr", files);
  fs::create_symlink(folder.file("other/0.0.0"), root + "/0.0.0");
  EXPECT_NE(error_of_reading(root).find("--data-folder"), std::string::npos);
  ReadOptions options;
  options.data_folders = {folder.file("other")};
  EXPECT_EQ(values_of<std::uint16_t>(read_dataset({root}, options).array()),
            expected_values({3, 4, 5}));
}

}  // namespace zarr_test
}  // namespace ovoid::io
