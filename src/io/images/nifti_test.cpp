// SPDX-License-Identifier: Apache-2.0
#include "io/images/nifti.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "fuzz/seeds.h"
#include "io/core/test_folder.h"
#include "io/images/nifti_header.h"
#include "io/images/test_volumes.h"
#include "io/read_source.h"

namespace ovoid::io {
namespace nifti_test {

using fuzz::gzip;
using fuzz::nifti1;
using fuzz::nifti2;
using Shorts = std::vector<std::int16_t>;

Dataset read_nii(const std::string& content, const ReadOptions& options = {}) {
  return read_source(*open_memory("a.nii", std::as_bytes(std::span(content))), options);
}

std::string nii_error(const std::string& content) {
  return error_of([&] { read_nii(content); });
}

// 4 x 3 x 2 int16 counting from 1, in the header's byte order.
std::string counted(bool is_big_endian = false) {
  auto values = counting<std::int16_t>(24);
  if (is_big_endian) {
    for (std::int16_t& value : values)
      value = static_cast<std::int16_t>(__builtin_bswap16(static_cast<std::uint16_t>(value)));
  }
  return bytes_of(values);
}

// Fails if a field is looked for at another place, or read in another byte order.
TEST(Nifti, BothVersionsAndByteOrders) {
  for (const bool is_big : {false, true}) {
    const std::string one = nifti1({3, 4, 3, 2}, 4, 16, is_big).bytes();
    const std::string two = nifti2({3, 4, 3, 2}, 4, 16, is_big).bytes();
    for (const std::string& header : {one, two}) {
      for (const std::string& content :
           {header + counted(is_big), gzip(header + counted(is_big))}) {
        const Dataset dataset = read_nii(content);
        EXPECT_EQ(dataset.format, header == one ? "NIfTI-1" : "NIfTI-2");
        EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
        EXPECT_EQ(dataset.lattice.spacing(), Vec3(1, 2, 3));
        EXPECT_EQ(Vec3(dataset.lattice.world_from_index.translation()), Vec3(0, 0, 0));
        EXPECT_EQ(dataset.space, Space::kNone);
        EXPECT_EQ(dataset.array().name, "values");
        EXPECT_EQ(values_of<std::int16_t>(dataset.array()), counting<std::int16_t>(24));
        EXPECT_FALSE(dataset.array().is_scaled());
        EXPECT_TRUE(dataset.notes.empty()) << dataset.notes[0];
      }
    }
  }
}

TEST(Nifti, KnowsEveryType) {
  const std::pair<int, ScalarType> types[] = {
      {2, ScalarType::kUInt8},    {4, ScalarType::kInt16},    {8, ScalarType::kInt32},
      {16, ScalarType::kFloat32}, {64, ScalarType::kFloat64}, {256, ScalarType::kInt8},
      {512, ScalarType::kUInt16}, {768, ScalarType::kUInt32}, {1024, ScalarType::kInt64},
      {1280, ScalarType::kUInt64}};
  for (const auto& [code, type] : types) {
    const auto size = size_of(type);
    const auto header =
        nifti1({3, 2, 1, 1}, static_cast<std::int16_t>(code), static_cast<std::int16_t>(8 * size));
    EXPECT_EQ(read_nii(header.bytes() + std::string(2 * size, 'x')).array().type, type);
    EXPECT_EQ(nifti_code_of(type), code);
  }
  const Dataset colors = read_nii(nifti1({3, 2, 1, 1}, 128, 24).bytes() + "abcdef");
  EXPECT_EQ(colors.array().num_components, 3);
  EXPECT_EQ(values_of<char>(colors.array()), (std::vector<char>{'a', 'b', 'c', 'd', 'e', 'f'}));
  EXPECT_EQ(nii_error(nifti1({3, 2, 1, 1}, 32, 64).bytes() + std::string(16, 'x')),
            "unsupported: a.nii: datatype 32 (complex64): expected integers of 1 to 8 bytes, "
            "float32, float64, RGB24 or RGBA32");
  EXPECT_EQ(nii_error(nifti1({3, 2, 1, 1}, 3, 8).bytes()).substr(0, 34),
            "unsupported: a.nii: datatype 3: ex");
}

TEST(Nifti, PlaceFromTheSform) {
  auto header = nifti1({3, 4, 3, 2}, 4, 16);
  header.put<std::int16_t>(254, {4});
  header.put<float>(280, {0, -2, 0.5F, 5, 1, 0, 0, 6, 0, 0, 3, 7});
  const Dataset dataset = read_nii(header.bytes() + counted());
  EXPECT_EQ(dataset.space, Space::kRas);
  EXPECT_EQ(dataset.lattice.world_from_index * Vec3(1, 1, 1), Vec3(3.5, 7, 10));
  EXPECT_TRUE(dataset.notes.empty()) << dataset.notes[0];
}

// A quarter turn about z, and qfac -1: x to y, y to -x, z to -z.
TEST(Nifti, PlaceFromTheQform) {
  auto header = nifti1({3, 4, 3, 2}, 4, 16);
  header.put<std::int16_t>(252, {1}).put<float>(76, {-1});
  header.put<float>(256, {0, 0, 0.70710678F, 10, 20, 30});
  const Dataset dataset = read_nii(header.bytes() + counted());
  EXPECT_EQ(dataset.space, Space::kRas);
  EXPECT_TRUE((dataset.lattice.world_from_index * Vec3(1, 1, 1))
                  .isApprox(Vec3(10 - 2, 20 + 1, 30 - 3), 1e-6));
  // Half a turn, a bit longer than 1: scanners write such numbers.
  header.put<float>(76, {1}).put<float>(256, {1.000001F, 0, 0});
  EXPECT_TRUE((read_nii(header.bytes() + counted()).lattice.world_from_index * Vec3(1, 1, 1))
                  .isApprox(Vec3(10 + 1, 20 - 2, 30 - 3), 1e-6));
}

// Both transforms of an image that a scanner's software made; they must say the same.
TEST(Nifti, TransformsOfAScannerAgree) {
  auto header = nifti1({3, 128, 96, 24}, 2, 8);
  header.put<std::int16_t>(252, {1, 1}).put<float>(76, {-1, 2, 2, 2.1999991F});
  header.put<float>(
      256, {-1.9451068e-26F, -0.99670851F, -0.081068739F, 117.8551F, -35.722942F, -7.2487984F});
  header.put<float>(280, {-2, 0, 0, 117.8551F, 0, 1.9737115F, -0.35552824F, -35.722942F, 0,
                          0.32320762F, 2.1710818F, -7.2487984F});
  const std::string samples(128L * 96 * 24, 'x');
  const Dataset by_sform = read_nii(header.bytes() + samples);
  EXPECT_TRUE(by_sform.notes.empty()) << by_sform.notes[0];
  header.put<std::int16_t>(254, {0});
  const Dataset by_qform = read_nii(header.bytes() + samples);
  EXPECT_TRUE(by_qform.lattice.world_from_index.isApprox(by_sform.lattice.world_from_index, 1e-6));
}

TEST(Nifti, NotesWhatContradictsOrCannotBe) {
  auto header = nifti1({3, 4, 3, 2}, 4, 16);
  header.put<std::int16_t>(252, {1, 1});
  header.put<float>(280, {1, 0, 0, 4, 0, 2, 0, 0, 0, 0, 3, 0});
  const Dataset both = read_nii(header.bytes() + counted());
  EXPECT_EQ(both.lattice.world_from_index.translation()[0], 4);
  EXPECT_EQ(both.notes, (std::vector<std::string>{
                            "a.nii: sform and qform place samples up to 4 apart: sform is taken"}));
  header.put<float>(280, {0, 0, 0, 0});
  const Dataset flat = read_nii(header.bytes() + counted());
  EXPECT_EQ(flat.space, Space::kRas);
  EXPECT_EQ(flat.lattice.spacing(), Vec3(1, 2, 3));
  EXPECT_EQ(flat.notes,
            (std::vector<std::string>{"a.nii: sform is degenerate or not finite and is not used"}));
  header.put<std::int16_t>(252, {0});
  EXPECT_EQ(read_nii(header.bytes() + counted()).space, Space::kNone);
  auto metres = nifti1({3, 4, 3, 2}, 4, 16);
  metres.put<char>(123, {1});
  EXPECT_EQ(read_nii(metres.bytes() + counted()).notes,
            (std::vector<std::string>{"a.nii: lengths are in metres, as the file has them"}));
  // A single slice may leave open what lies behind it.
  auto slice = nifti1({2, 4, 6}, 4, 16);
  slice.put<std::int16_t>(254, {1}).put<float>(280, {0, 2, 0, 0, 3, 0, 0, 0, 0, 0, 0, 0});
  EXPECT_EQ(read_nii(slice.bytes() + counted()).lattice.world_from_index.linear().col(2),
            Vec3(0, 0, -2));
}

TEST(Nifti, ScaleStaysBesideTheSamples) {
  auto header = nifti1({3, 4, 3, 2}, 4, 16);
  header.put<float>(112, {2, -10}).text(328, "density");
  const DataArray array = read_nii(header.bytes() + counted()).array();
  EXPECT_EQ(array.value_scale, 2);
  EXPECT_EQ(array.value_offset, -10);
  EXPECT_EQ(array.name, "density");
  EXPECT_EQ(values_of<std::int16_t>(array), counting<std::int16_t>(24));
  header.put<float>(112, {0, 5});
  EXPECT_FALSE(read_nii(header.bytes() + counted()).array().is_scaled());
  header.put<float>(112, {1, NAN});
  const Dataset dataset = read_nii(header.bytes() + counted());
  EXPECT_FALSE(dataset.array().is_scaled());
  EXPECT_EQ(dataset.notes.size(), 1U);
}

// Fails if the steps are counted from the wrong place, or time is not in seconds.
TEST(Nifti, ReadsOneStepOfTime) {
  auto header = nifti1({4, 2, 1, 1, 3}, 4, 16, true);
  header.put<char>(123, {2 + 16}).put<float>(136, {250});
  const std::string data("\0\7\0\7\0\1\0\2\0\3\0\4", 12);
  for (const std::string& content : {header.bytes() + data, gzip(header.bytes() + data)}) {
    const Dataset found = read_nii(content);
    EXPECT_EQ(found.num_steps, 3);
    EXPECT_EQ(found.step, 1);
    EXPECT_EQ(values_of<std::int16_t>(found.array()), (Shorts{1, 2}));
    EXPECT_EQ(found.times, (std::vector<double>{0.25, 0.2505, 0.251}));
    EXPECT_EQ(found.notes, (std::vector<std::string>{
                               "a.nii: step 1 of 3, the first that varies; choose with --step"}));
    ReadOptions last;
    last.step = 2;
    EXPECT_EQ(values_of<std::int16_t>(read_nii(content, last).array()), (Shorts{3, 4}));
    last.step = 3;
    EXPECT_EQ(error_of([&] { read_nii(content, last); }),
              "invalid-argument: a.nii: step 3: expected 0 to 2");
  }
  header.put<char>(123, {2 + 32});  // a spectrum
  EXPECT_TRUE(read_nii(header.bytes() + data).times.empty());
}

// Components are slowest in the file and fastest in memory.
TEST(Nifti, VectorsAreInterleaved) {
  const Dataset still = read_nii(nifti1({5, 2, 2, 1, 1, 3}, 2, 8).bytes() + "abcdefghijkl");
  EXPECT_EQ(still.array().num_components, 3);
  EXPECT_EQ(values_of<char>(still.array()),
            (std::vector<char>{'a', 'e', 'i', 'b', 'f', 'j', 'c', 'g', 'k', 'd', 'h', 'l'}));
  // Two samples, three steps, two components.
  const std::string in_time = nifti1({5, 2, 1, 1, 3, 2}, 2, 8).bytes() + "aabcdeuvwxyz";
  EXPECT_EQ(values_of<char>(read_nii(in_time).array()), (std::vector<char>{'b', 'w', 'c', 'x'}));
  ReadOptions last;
  last.step = 2;
  EXPECT_EQ(values_of<char>(read_nii(in_time, last).array()),
            (std::vector<char>{'d', 'y', 'e', 'z'}));
}

TEST(Nifti, PairsOfFiles) {
  auto header = nifti1({3, 2, 1, 1}, 2, 8);
  header.put<float>(108, {3}).text(344, "ni1");
  MemoryFiles files;
  const auto read_pair = [&](const std::string& name, const std::string& content) {
    return read_source(*open_memory(name, std::as_bytes(std::span(content))), {}, files.opener());
  };
  EXPECT_EQ(error_of([&] { read_pair("dir/a.hdr", header.bytes()); }),
            "file-not-found: dir/a.hdr: its samples are in dir/a.img or dir/a.img.gz: neither can "
            "be opened");
  files.files["dir/a.img.gz"] = gzip("123xy");
  EXPECT_EQ(values_of<char>(read_pair("dir/a.hdr", header.bytes()).array()),
            (std::vector<char>{'x', 'y'}));
  files.files["dir/a.img"] = "123zy";
  for (const char* name : {"dir/a.hdr", "dir/a.hdr.gz"}) {
    const std::string content = name[8] != '\0' && std::string(name).ends_with("gz")
                                    ? gzip(header.bytes())
                                    : header.bytes().substr(0, 348);
    EXPECT_EQ(values_of<char>(read_pair(name, content).array()), (std::vector<char>{'z', 'y'}));
  }
  EXPECT_EQ(error_of([&] { read_pair("dir/a.img", "123zy"); }),
            "unsupported: dir/a.img: may be the samples of a NIfTI pair: expected its header, the "
            ".hdr file beside it");
  EXPECT_EQ(error_of([&] { read_pair("dir/a.nii", header.bytes()); }),
            "file-format: dir/a.nii: is the header of a pair: expected a name that ends in .hdr");
}

TEST(Nifti, HeaderErrorsNameTheField) {
  const auto with_header = [](auto change) {
    auto header = nifti1({3, 4, 3, 2}, 4, 16);
    change(header);
    return nii_error(header.bytes() + counted());
  };
  using Header = fuzz::BinaryHeader;
  EXPECT_EQ(with_header([](Header& h) { h.put<std::int16_t>(40, {8}); }),
            "file-format: a.nii: dim[0] = 8: expected 1 to 7 axes");
  EXPECT_EQ(with_header([](Header& h) { h.put<std::int16_t>(44, {-3}); }),
            "file-format: a.nii: dim[2] = -3: expected 1 to 2147483647");
  EXPECT_EQ(with_header([](Header& h) {
              h.put<std::int16_t>(40, {6, 4, 3, 2, 1, 1, 2});
            }),
            "unsupported: a.nii: dim[6] = 2: expected 1: only space, time and components are read");
  EXPECT_EQ(with_header([](Header& h) { h.put<std::int16_t>(72, {8}); }),
            "file-format: a.nii: bitpix = 8: datatype 4 (int16) has 16 bits");
  EXPECT_EQ(with_header([](Header& h) { h.put<float>(108, {100}); }),
            "file-format: a.nii: vox_offset = 100: expected at least 352, behind the header");
  EXPECT_EQ(with_header([](Header& h) { h.put<float>(108, {NAN}); }),
            "file-format: a.nii: vox_offset = nan: expected a number of bytes");
  EXPECT_EQ(with_header([](Header& h) { h.put<float>(108, {353}); }),
            "file-format: a.nii: holds 400 bytes, 4x3x2 int16 needs 401: is the file truncated or "
            "a header field wrong?");
  EXPECT_EQ(with_header([](Header& h) { h.put<float>(108, {0}); }), "");
  auto analyze = nifti1({3, 4, 3, 2}, 4, 16);
  analyze.text(344, std::string(4, '\0'));
  EXPECT_EQ(nii_error(analyze.bytes()).substr(0, 52),
            "unsupported: a.nii: is an ANALYZE 7.5 header without");
  EXPECT_EQ(error_of([&] {
              read_source(*open_memory("a.hdr", std::as_bytes(std::span(analyze.bytes()))), {});
            }).substr(0, 52),
            "unsupported: a.hdr: is an ANALYZE 7.5 header without");
  auto mangled = nifti2({3, 4, 3, 2}, 4, 16);
  mangled.text(8, "\n\n");
  EXPECT_EQ(nii_error(mangled.bytes()).substr(0, 44),
            "file-format: a.nii: magic: its line ends wer");
}

// A few bytes must not make the reader take gigabytes.
TEST(Nifti, ClaimsAreNotAllocated) {
  EXPECT_EQ(nii_error(nifti2({3, 2000000000, 2000000000, 2000000000}, 2, 8).bytes()),
            "file-format: a.nii: dim: 2000000000x2000000000x2000000000x1 uint8 is larger than any "
            "file");
  EXPECT_NE(nii_error(gzip(nifti1({3, 30000, 30000, 30000}, 2, 8).bytes()))
                .find(" bytes of gzip data hold at most "),
            std::string::npos);
  EXPECT_EQ(nii_error(nifti2({4, 1, 1, 1, 2000000}, 2, 8).bytes()),
            "unsupported: a.nii: dim[4]: 2000000 time steps: expected at most 1000000");
}

Dataset turned_dataset(Space space) {
  Dataset dataset;
  dataset.lattice.dims = {4, 3, 2};
  dataset.space = space;
  dataset.lattice.world_from_index = Eigen::Translation3d(10, -20, 30.5) *
                                     Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()) *
                                     Eigen::Scaling(0.5, 1.0, -2.5);
  dataset.arrays.push_back(make_array("speed", ScalarType::kInt16, counting<std::int16_t>(24)));
  return dataset;
}

// Fails if a patient's left becomes right, or if sform and qform are written differently: the
// reader would note that.
TEST(Nifti, RoundTripKeepsPlaceNameAndScale) {
  const TestFolder folder;
  for (const Space space : {Space::kRas, Space::kLps, Space::kNone}) {
    for (const char* name : {"a.nii", "a.nii.gz", "B.NII.GZ"}) {
      Dataset dataset = turned_dataset(space);
      dataset.arrays[0].value_scale = 0.5;
      dataset.arrays[0].value_offset = -1000;
      write_dataset(dataset, folder.file(name));
      const Dataset back = read_dataset({folder.file(name)});
      Affine3 expected = dataset.lattice.world_from_index;
      if (space == Space::kLps) expected = Eigen::Scaling(-1.0, -1.0, 1.0) * expected;
      EXPECT_TRUE(back.lattice.world_from_index.isApprox(expected, 1e-6));
      EXPECT_EQ(folder.read(name).starts_with("\x1f\x8b"), std::string(name) != "a.nii");
      EXPECT_EQ(back.space, Space::kRas);
      EXPECT_EQ(back.lattice.dims, dataset.lattice.dims);
      EXPECT_EQ(back.array().name, "speed");
      EXPECT_EQ(back.array().value_scale, 0.5);
      EXPECT_EQ(back.array().value_offset, -1000);
      EXPECT_EQ(values_of<std::int16_t>(back.array()), counting<std::int16_t>(24));
      EXPECT_TRUE(back.notes.empty()) << back.notes[0];
    }
  }
}

TEST(Nifti, WritesTheQformThatTheSformIs) {
  const TestFolder folder;
  write_dataset(turned_dataset(Space::kRas), folder.file("a.nii"));
  std::string content = folder.read("a.nii");
  EXPECT_EQ(content.substr(252, 4), std::string("\1\0\1\0", 4));
  content[254] = 0;  // without the sform
  const Dataset back = read_nii(content);
  EXPECT_TRUE(back.lattice.world_from_index.isApprox(
      turned_dataset(Space::kRas).lattice.world_from_index, 1e-6));
  // Skewed axes have no qform.
  Dataset skewed = turned_dataset(Space::kRas);
  skewed.lattice.world_from_index.linear().col(1) +=
      skewed.lattice.world_from_index.linear().col(0);
  write_dataset(skewed, folder.file("b.nii"));
  EXPECT_EQ(folder.read("b.nii").substr(252, 4), std::string("\0\0\1\0", 4));
}

TEST(Nifti, SpacingAloneNeedsNoPatientSpace) {
  const TestFolder folder;
  Dataset dataset = turned_dataset(Space::kNone);
  dataset.lattice.world_from_index = Eigen::Scaling(0.5, 1.0, 2.5);
  write_dataset(dataset, folder.file("a.nii"));
  const Dataset back = read_dataset({folder.file("a.nii")});
  EXPECT_EQ(back.space, Space::kNone);
  EXPECT_EQ(back.lattice.spacing(), Vec3(0.5, 1, 2.5));
}

// Also what is longer than version 1 can say, or finer than float32.
TEST(Nifti, WritesVectorsAndVersionTwo) {
  const TestFolder folder;
  Dataset vectors = turned_dataset(Space::kRas);
  vectors.arrays = {make_array("v", ScalarType::kFloat32, counting<float>(72), 3)};
  Dataset vast = turned_dataset(Space::kRas);
  vast.lattice.world_from_index.translation()[0] = 1e60;
  Dataset line = turned_dataset(Space::kLps);
  line.lattice.dims = {40000, 1, 1};
  line.arrays = {make_array("v", ScalarType::kUInt8, counting<std::uint8_t>(40000))};
  for (const auto& [dataset, format] :
       {std::pair{vectors, "NIfTI-1"}, std::pair{vast, "NIfTI-2"}, std::pair{line, "NIfTI-2"}}) {
    write_dataset(dataset, folder.file("a.nii.gz"));
    const Dataset back = read_dataset({folder.file("a.nii.gz")});
    EXPECT_EQ(back.format, format);
    EXPECT_EQ(back.lattice.dims, dataset.lattice.dims);
    EXPECT_EQ(back.array().num_components, dataset.array().num_components);
    EXPECT_EQ(values_of<std::uint8_t>(back.array()), values_of<std::uint8_t>(dataset.array()));
    EXPECT_TRUE(back.notes.empty()) << back.notes[0];
  }
}

TEST(Nifti, FilesReadForAPair) {
  const TestFolder folder;
  auto header = nifti1({3, 2, 1, 1}, 2, 8);
  header.put<float>(108, {0}).text(344, "ni1");
  folder.write("a.hdr", header.bytes());
  folder.write("a.img", "xy");
  EXPECT_EQ(files_read_for(folder.file("a.hdr")),
            (std::vector<std::string>{folder.file("a.hdr"), folder.file("a.img")}));
  EXPECT_EQ(values_of<char>(read_dataset({folder.file("a.hdr")}).array()),
            (std::vector<char>{'x', 'y'}));
}

}  // namespace nifti_test
}  // namespace ovoid::io
