// SPDX-License-Identifier: Apache-2.0
#include "io/images/npy.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "io/core/short_floats.h"
#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"

namespace ovoid::io {
namespace npy_test {

std::string npy(const std::string& dict, const std::string& samples, int version = 1) {
  std::string result = "\x93NUMPY";
  result += {static_cast<char>(version), '\0', static_cast<char>(dict.size() % 256),
             static_cast<char>(dict.size() / 256)};
  if (version > 1) result += {'\0', '\0'};
  return result + dict + samples;
}

Dataset read(const std::string& content, const ReadOptions& options = {}) {
  return read_npy(*open_memory("a.npy", std::as_bytes(std::span(content))), options);
}

const std::string kDict = "{'descr': '<i2', 'fortran_order': False, 'shape': (2, 3, 4), }\n";

TEST(Npy, ShapeIsZYXInAllVersions) {
  const auto values = counting<std::int16_t>(24);
  for (const int version : {1, 2, 3}) {
    const Dataset dataset = read(npy(kDict, bytes_of(values), version));
    EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2})) << version;
    EXPECT_EQ(values_of<std::int16_t>(dataset.array()), values) << version;
  }
}

TEST(Npy, LastAxisOfFourHoldsComponents) {
  const Dataset dataset = read(
      npy("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3, 4, 3)}", std::string(72, 'x')));
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  EXPECT_EQ(dataset.array().num_components, 3);
  EXPECT_EQ(dataset.array().num_tuples, 24);
}

// What is no number of components was read as so many of them, up to 64.
TEST(Npy, OtherLastAxesOfFourAreSamples) {
  for (const int last : {5, 7, 8, 10, 64}) {
    const std::string samples(static_cast<std::size_t>(2 * last), 'x');
    const std::string file = npy("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 1, 1, " +
                                     std::to_string(last) + ")}",
                                 samples);
    const Dataset dataset = read(file);
    EXPECT_EQ(dataset.num_steps, 2);
    EXPECT_EQ(dataset.lattice.dims, (Index3{last, 1, 1}));
    ASSERT_EQ(dataset.notes.size(), 1U);
    EXPECT_EQ(dataset.notes[0], "a.npy: shape (2, 1, 1, " + std::to_string(last) +
                                    ") taken as (time, z, y, x); --axis-order says another");
  }
  for (const int last : {1, 2, 3, 4, 6, 9}) {
    const Dataset dataset =
        read(npy("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 1, 1, " +
                     std::to_string(last) + ")}",
                 std::string(static_cast<std::size_t>(2 * last), 'x')));
    EXPECT_EQ(dataset.array().num_components, last);
  }
}

TEST(Npy, FiveAxesAndLongOnesBeginWithTime) {
  std::string samples;
  for (const char step : {'a', 'b', 'c'}) samples += std::string(2 * 3 * 4 * 2, step);
  const std::string five =
      npy("{'descr': '|u1', 'fortran_order': False, 'shape': (3, 2, 3, 4, 2)}", samples);
  Dataset dataset = read(five, {.step = 1});
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  EXPECT_EQ(dataset.num_steps, 3);
  EXPECT_EQ(dataset.step, 1);
  EXPECT_EQ(dataset.array().num_components, 2);
  EXPECT_EQ(values_of<char>(dataset.array()), std::vector<char>(48, 'b'));
  const std::string wide = npy("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 1, 1, 72)}",
                               std::string(72, 'x') + std::string(71, 'y') + "z");
  dataset = read(wide);  // the first that varies
  EXPECT_EQ(dataset.step, 1);
  EXPECT_EQ(dataset.array().num_components, 1);
  EXPECT_EQ(
      error_of([&] { read(wide.substr(0, wide.size() - 1)); }),
      "file-format: a.npy: holds 143 bytes of samples, shape (2, 1, 1, 72) of uint8 needs 144");
  // In Fortran order the steps of a sample lie behind each other.
  std::string columns;
  for (int i = 0; i < 36; ++i) columns += i < 35 ? "xy" : "xz";
  dataset =
      read(with(npy("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 1, 1, 36)}", columns),
                "False", "True "));
  EXPECT_EQ(dataset.step, 1);
  EXPECT_EQ(values_of<char>(dataset.array()).back(), 'z');
}

// Fails if an axis of one entry is taken for one of the others, wherever it stands.
TEST(Npy, AxesOfOneEntryDoNotMatter) {
  const auto values = counting<std::int16_t>(30);
  for (const char* const shape : {"1, 1, 2, 3, 5", "1, 2, 3, 5", "2, 3, 5, 1", "2, 1, 3, 5",
                                  "1, 2, 3, 1, 5, 1", "1, 1, 1, 2, 3, 5"}) {
    const std::string file =
        npy("{'descr': '<i2', 'fortran_order': False, 'shape': (" + std::string(shape) + ")}",
            bytes_of(values));
    const Dataset dataset = read(file);
    EXPECT_EQ(dataset.lattice.dims, (Index3{5, 3, 2})) << shape;
    EXPECT_EQ(dataset.num_steps, 1) << shape;
    EXPECT_EQ(dataset.array().num_components, 1) << shape;
    EXPECT_EQ(values_of<std::int16_t>(dataset.array()), values) << shape;
    EXPECT_EQ(dataset.notes.size(), 1U) << shape;
  }
  // Of five that matter the second is one of channels.
  const Dataset channels = read(npy(
      "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3, 2, 1, 5)}", std::string(60, 'x')));
  EXPECT_EQ(channels.lattice.dims, (Index3{5, 2, 3}));  // (time, z, y, 1, x)
  EXPECT_EQ(channels.num_steps, 2);
  EXPECT_EQ(read(npy("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3, 2, 2, 5)}",
                     std::string(120, 'x')))
                .arrays.size(),
            3U);
  EXPECT_EQ(error_of([] {
              read(npy("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 2, 2, 2, 2, 5)}",
                       std::string(160, 'x')));
            }).find("--axis-order, as tczyx or yx, says which axis is which") != std::string::npos,
            true);
  // An order may leave them out.
  ReadOptions options;
  options.raw.axis_order = "xyz";
  EXPECT_EQ(read(npy("{'descr': '<i2', 'fortran_order': False, 'shape': (1, 2, 3, 1, 5)}",
                     bytes_of(values)),
                 options)
                .lattice.dims,
            (Index3{2, 3, 5}));
}

// Samples lie in several chunks, of which the last along an axis is short.
TEST(Npy, LargeArraysInEitherOrder) {
  constexpr int kZ = 7, kY = 401, kX = 503;
  std::vector<std::int32_t> expected(kZ * kY * kX), fortran;
  for (std::size_t i = 0; i < expected.size(); ++i) expected[i] = static_cast<std::int32_t>(i);
  for (int x = 0; x < kX; ++x)
    for (int y = 0; y < kY; ++y)
      for (int z = 0; z < kZ; ++z)
        fortran.push_back(expected[static_cast<std::size_t>((z * kY + y) * kX + x)]);
  const std::string dict = "{'descr': '<i4', 'fortran_order': False, 'shape': (7, 401, 503)}";
  EXPECT_EQ(values_of<std::int32_t>(read(npy(dict, bytes_of(expected))).array()), expected);
  EXPECT_EQ(
      values_of<std::int32_t>(read(npy(with(dict, "False", "True "), bytes_of(fortran))).array()),
      expected);
}

// Channels, in either order of memory, and axes that are not z, y, x.
TEST(Npy, AxesAreInTheOrderThatIsAskedFor) {
  std::string samples;
  for (char i = 0; i < 48; ++i) samples += i;
  const std::string file =
      npy("{'descr': '|u1', 'fortran_order': False, 'shape': (2, 2, 3, 4)}", samples);
  ReadOptions options;
  options.raw.axis_order = "czyx";
  Dataset dataset = read(file, options);
  EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
  ASSERT_EQ(dataset.arrays.size(), 2U);
  EXPECT_EQ(dataset.arrays[1].name, "channel 2");
  EXPECT_EQ(values_of<char>(dataset.arrays[1]).front(), 24);
  EXPECT_EQ(values_of<char>(dataset.arrays[1]).back(), 47);
  options.raw.axis_order = "ctyx";
  options.step = 1;
  dataset = read(file, options);
  EXPECT_EQ(dataset.num_steps, 2);
  EXPECT_EQ(values_of<char>(dataset.arrays[0]).front(), 12);
  // (x, y, z, component) in Fortran order: x is fastest, then y.
  options.raw.axis_order = "xyzc";
  options.step.reset();
  dataset = read(with(file, "False", "True "), options);
  EXPECT_EQ(dataset.lattice.dims, (Index3{2, 2, 3}));
  EXPECT_EQ(dataset.array().num_components, 4);
  const std::vector<char> values = values_of<char>(dataset.array());
  for (int c = 0; c < 4; ++c) EXPECT_EQ(values[static_cast<std::size_t>(4 + c)], 1 + 12 * c);
  options.raw.axis_order = "zyx";
  EXPECT_EQ(error_of([&] { read(file, options); }),
            "invalid-argument: a.npy: axis order 'zyx': has 3 letters, the array has 4 axes: "
            "(2, 2, 3, 4)");
}

TEST(Npy, ByteOrderAndBooleans) {
  EXPECT_EQ(values_of<std::uint16_t>(
                read(npy("{'descr': '>u2', 'fortran_order': False, 'shape': (1,1,1)}", "\x12\x34"))
                    .array())[0],
            0x1234);
  const Dataset dataset = read(
      npy("{'descr': '|b1', 'fortran_order': False, 'shape': (1, 1, 2)}", std::string("\0\1", 2)));
  EXPECT_EQ(values_of<std::uint8_t>(dataset.array()), (std::vector<std::uint8_t>{0, 1}));
  EXPECT_EQ(dataset.notes.size(), 1U);
}

// Sizes above the transposition's block of 32 and no multiples of it, so that its edges are met.
// Halves 1 to 24; fails if one of the ways to the samples takes their bits for integers.
TEST(Npy, HalvesBecomeFloat32) {
  std::string little, big;
  for (int i = 1; i <= 24; ++i) {
    const std::uint16_t bits = bits_of(static_cast<float>(i), ShortFloat::kHalf);
    const char low = static_cast<char>(bits & 255U), high = static_cast<char>(bits >> 8U);
    little += {low, high};
    big += {high, low};
  }
  const auto file = [](const std::string& descr, const char* order, const char* shape,
                       const std::string& samples) {
    return npy("{'descr': '" + descr + "', 'fortran_order': " + order + ", 'shape': " + shape + "}",
               samples);
  };
  const auto all = counting<float>(24);
  const Dataset dataset = read(file("<f2", "False", "(2, 3, 4)", little));
  EXPECT_EQ(values_of<float>(dataset.array()), all);
  EXPECT_EQ(dataset.notes, std::vector<std::string>{"a.npy: float16 becomes float32"});
  EXPECT_EQ(values_of<float>(read(file(">f2", "False", "(2, 3, 4)", big)).array()), all);
  EXPECT_EQ(values_of<float>(read(file("<f2", "True", "(4, 3, 2)", little)).array()),
            (std::vector<float>{1, 13, 5, 17, 9,  21, 2, 14, 6, 18, 10, 22,
                                3, 15, 7, 19, 11, 23, 4, 16, 8, 20, 12, 24}));
  ReadOptions options;
  options.step = 1;
  EXPECT_EQ(values_of<float>(read(file(">f2", "False", "(2, 2, 3, 2, 1)", big), options).array()),
            (std::vector<float>(all.begin() + 12, all.end())));
  options.step.reset();
  options.raw.axis_order = "xyz";
  EXPECT_EQ(values_of<float>(read(file("<f2", "False", "(2, 3, 4)", little), options).array())[1],
            13);
}

TEST(Npy, FortranOrderIsTransposed) {
  constexpr int kZ = 35, kY = 3, kX = 41, kC = 2;
  const auto value = [](int z, int y, int x, int c) {
    return static_cast<std::int32_t>(((z * kY + y) * kX + x) * kC + c);
  };
  std::vector<std::int32_t> fortran, expected;
  for (int c = 0; c < kC; ++c)
    for (int x = 0; x < kX; ++x)
      for (int y = 0; y < kY; ++y)
        for (int z = 0; z < kZ; ++z) fortran.push_back(value(z, y, x, c));
  for (int i = 0; i < kZ * kY * kX * kC; ++i) expected.push_back(i);
  const Dataset dataset = read(
      npy("{'descr': '<i4', 'fortran_order': True, 'shape': (35, 3, 41, 2)}", bytes_of(fortran)));
  EXPECT_EQ(dataset.lattice.dims, (Index3{kX, kY, kZ}));
  EXPECT_EQ(values_of<std::int32_t>(dataset.array()), expected);
}

TEST(Npy, SpacingMayBeGiven) {
  ReadOptions options;
  options.raw.spacing = Vec3(1, 2, 3);
  EXPECT_EQ(read(npy(kDict, std::string(48, 'x')), options).lattice.spacing(), Vec3(1, 2, 3));
}

TEST(Npy, ErrorsNameFieldAndValue) {
  const auto message = [](const std::string& dict, std::size_t size) {
    return error_of([&] { read(npy(dict, std::string(size, 'x'))); });
  };
  EXPECT_EQ(message(kDict, 47),
            "file-format: a.npy: holds 47 bytes of samples, shape (2, 3, 4) of int16 needs 48");
  EXPECT_EQ(message("{'descr': '<f3', 'fortran_order': False, 'shape': (1,1,1)}", 2),
            "unsupported: a.npy: descr: '<f3': expected booleans, integers of 1 to 8 bytes, or "
            "floats of 2 to 8");
  EXPECT_EQ(message("{'descr': '|O', 'fortran_order': False, 'shape': (1,1,1)}", 2).substr(0, 12),
            "unsupported:");
  EXPECT_EQ(message("{'descr': [('a', '<i4')], 'fortran_order': False, 'shape': (1,1,1)}", 4),
            "unsupported: a.npy: descr: is a record of several fields: expected one number type");
  EXPECT_EQ(
      message("{'descr': '<i4', 'fortran_order': False, 'shape': (7, 5)}", 140),
      "unsupported: a.npy: shape: (7, 5): expected (z, y, x), (z, y, x, component) with 2 to "
      "4, 6 or 9 components, (time, z, y, x) with components or without, or (time, channel, z, "
      "y, x), besides axes of one entry; or (N, 3) or (N, 4) for more than 4 points; "
      "--axis-order, as tczyx or yx, says which axis is which");
  EXPECT_EQ(message("{'descr': '<U4', 'fortran_order': False, 'shape': (1,1,1)}", 16),
            "unsupported: a.npy: descr: '<U4' (text): expected booleans, integers of 1 to 8 bytes, "
            "or floats of 2 to 8");
  EXPECT_EQ(message("{'descr': '<i4', 'fortran_order': False, 'shape': (0, 3, 4)}", 0),
            "file-format: a.npy: shape: 0x3x4 has an axis of 0 samples: expected 1 to 2147483647");
  EXPECT_EQ(message("{'descr': '<i4', 'fortran_order': Maybe, 'shape': (1, 1, 1)}", 4),
            "file-format: a.npy: NPY header: expected True or False at 'Maybe, 'shape': (1, '");
  EXPECT_EQ(message("{'descr': '<i4', 'shape': (1, 1, 1)}", 4),
            "file-format: a.npy: NPY header: expected the keys descr, fortran_order and shape");
  EXPECT_EQ(error_of([] { read("\x93NUMPY\x01"); }),
            "file-format: a.npy: NPY header: the file ends within it");
  EXPECT_EQ(error_of([] { read(std::string("\x93NUMPY\x09\0\0\0\0\0", 12)); }),
            "unsupported: a.npy: NPY version 9: expected 1 to 3");
}

TEST(Npy, HeaderIsWhatNumpyWrites) {
  const std::int64_t shape[] = {2, 3, 4};
  const std::string header = npy_header(ScalarType::kFloat32, shape);
  EXPECT_EQ(header.size() % 64, 0U);
  EXPECT_EQ(header.substr(10, 62),
            "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3, 4), }");
  EXPECT_EQ(header.back(), '\n');
}

TEST(Npy, RoundTrip) {
  const TestFolder folder;
  const auto values = counting<float>(2 * 3 * 4 * 2);
  write_npy({4, 3, 2}, make_array("v", ScalarType::kFloat32, values, 2), folder.file("a.npy"));
  const Dataset dataset = read_npy(*open_file(folder.file("a.npy")), {});
  EXPECT_EQ(values_of<float>(dataset.array()), values);
  EXPECT_EQ(dataset.array().num_components, 2);
}

}  // namespace npy_test
}  // namespace ovoid::io
