// SPDX-License-Identifier: Apache-2.0
#include "io/images/metaimage.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "fuzz/seeds.h"
#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/read_source.h"

namespace ovoid::io {
namespace metaimage_test {

using fuzz::deflated;

const std::string kMeta =
    "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = MET_UCHAR\n";
const std::string kLocal = "ElementDataFile = LOCAL\n";

Dataset read_meta(const std::string& content, const MemoryFiles& files = {},
                  const ReadOptions& options = {}) {
  return read_source(*open_memory("dir/a.mha", std::as_bytes(std::span(content))), options,
                     files.opener());
}

std::string meta_error(const std::string& content, const MemoryFiles& files = {}) {
  return error_of([&] { read_meta(content, files); });
}

TEST(MetaImage, ReadsRawCompressedAndText) {
  const auto values = counting<std::uint8_t>(24);
  const std::string raw = bytes_of(values);
  std::string text;
  for (const auto value : values) text += std::to_string(value) + (value % 5 == 0 ? "\r\n" : " ");
  const std::string packed = deflated(raw, 15);
  for (const std::string& content :
       {kMeta + kLocal + raw, kMeta + "BinaryData = True\r\n" + kLocal + raw,
        kMeta + "CompressedData = True\n" + kLocal + packed,
        kMeta + "CompressedData = T\nCompressedDataSize = " + std::to_string(packed.size()) + "\n" +
            kLocal + packed,
        kMeta + "BinaryData = False\n" + kLocal + text,
        kMeta + "HeaderSize = -1\n" + kLocal + "anything" + raw}) {
    const Dataset dataset = read_meta(content);
    EXPECT_EQ(dataset.format, "MetaImage");
    EXPECT_EQ(dataset.lattice.dims, (Index3{4, 3, 2}));
    EXPECT_EQ(values_of<std::uint8_t>(dataset.array()), values);
    EXPECT_EQ(dataset.array().name, "values");
    EXPECT_EQ(dataset.space, Space::kLps);
    EXPECT_TRUE(dataset.notes.empty()) << dataset.notes[0];
  }
}

// Fails if the matrix is read by columns: an image of it, transposed, is left-handed here.
TEST(MetaImage, PlaceInTheWorld) {
  const Dataset dataset =
      read_meta(kMeta +
                "TransformMatrix = 0 1 0 0 0 1 1 0 0\nOffset = 10 20 30\nElementSpacing = 2 3 4\n"
                "ElementSize = 9 9 9\nCenterOfRotation = 0 0 0\nAnatomicalOrientation = RAS\n" +
                kLocal + std::string(24, 'x'));
  EXPECT_EQ(dataset.lattice.world_from_index * Vec3(1, 0, 0), Vec3(10, 22, 30));
  EXPECT_EQ(dataset.lattice.world_from_index * Vec3(0, 1, 0), Vec3(10, 20, 33));
  EXPECT_EQ(dataset.lattice.world_from_index * Vec3(0, 0, 1), Vec3(14, 20, 30));
  EXPECT_TRUE(dataset.notes.empty()) << dataset.notes[0];
  // Older names; the size of an element stands in for its spacing; what is ignored is told.
  const Dataset other =
      read_meta(kMeta +
                "Orientation = 0 1 0 0 0 1 1 0 0\nPosition = 10 20 30\nElementSize = 2 3 4\n"
                "CenterOfRotation = 1 0 0\nDistanceUnits = um\nName = bone\n" +
                kLocal + std::string(24, 'x'));
  EXPECT_EQ(other.lattice.world_from_index.matrix(), dataset.lattice.world_from_index.matrix());
  EXPECT_EQ(other.array().name, "bone");
  EXPECT_EQ(other.notes,
            (std::vector<std::string>{
                "dir/a.mha: line 8: CenterOfRotation is not 0 and ignored: Offset is the place of "
                "the first sample",
                "dir/a.mha: lengths are in um, as the file has them"}));
}

TEST(MetaImage, TypesChannelsAndScale) {
  const std::string base =
      "NDims = 2\nDimSize = 2 1\nElementNumberOfChannels = 2\nElementType = MET_SHORT_ARRAY\n";
  const std::string data("\0\1\0\2\0\3\0\4", 8);
  const Dataset big = read_meta(base + "ElementByteOrderMSB = True\n" + kLocal + data);
  EXPECT_EQ(values_of<std::int16_t>(big.array()), (std::vector<std::int16_t>{1, 2, 3, 4}));
  EXPECT_EQ(big.array().num_components, 2);
  EXPECT_EQ(big.lattice.dims, (Index3{2, 1, 1}));
  const Dataset little = read_meta(base + kLocal + data);
  EXPECT_EQ(values_of<std::int16_t>(little.array())[0], 0x100);
  EXPECT_EQ(little.notes,
            (std::vector<std::string>{"dir/a.mha: no field 'BinaryDataByteOrderMSB' for int16 "
                                      "samples: taken as little"}));
  const std::pair<const char*, ScalarType> types[] = {
      {"MET_CHAR", ScalarType::kInt8},       {"MET_USHORT", ScalarType::kUInt16},
      {"MET_INT", ScalarType::kInt32},       {"MET_ULONG", ScalarType::kUInt32},
      {"MET_LONG", ScalarType::kInt32},      {"MET_UINT", ScalarType::kUInt32},
      {"MET_LONG_LONG", ScalarType::kInt64}, {"MET_ULONG_LONG", ScalarType::kUInt64},
      {"MET_FLOAT", ScalarType::kFloat32},   {"MET_DOUBLE", ScalarType::kFloat64}};
  for (const auto& [name, type] : types) {
    const DataArray array = read_meta(with(kMeta, "MET_UCHAR", name) +
                                      "BinaryDataByteOrderMSB = F\n"
                                      "ElementToIntensityFunctionSlope = 2\n"
                                      "ElementToIntensityFunctionOffset = -1\n" +
                                      kLocal + std::string(24 * size_of(type), 'x'))
                                .array();
    EXPECT_EQ(array.type, type) << name;
    EXPECT_EQ(array.value_scale, 2);
    EXPECT_EQ(array.value_offset, -1);
  }
}

TEST(MetaImage, ReadsOneStepOfTime) {
  const std::string content =
      "NDims = 4\nDimSize = 2 1 1 3\nElementSpacing = 1 1 1 0.5\nOffset = 0 0 0 7\n"
      "ElementType = MET_UCHAR\n" +
      kLocal + "aaabcd";
  const Dataset found = read_meta(content);
  EXPECT_EQ(found.step, 1);
  EXPECT_EQ(found.times, (std::vector<double>{7, 7.5, 8}));
  EXPECT_EQ(values_of<char>(found.array()), (std::vector<char>{'a', 'b'}));
  ReadOptions last;
  last.step = 2;
  EXPECT_EQ(values_of<char>(read_meta(content, {}, last).array()), (std::vector<char>{'c', 'd'}));
  EXPECT_EQ(meta_error("TransformMatrix = 1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1\n" + content),
            "unsupported: dir/a.mha: TransformMatrix: the fourth axis is not apart from the "
            "others: expected time");
}

TEST(MetaImage, DetachedDataLieBesideTheHeader) {
  const auto values = counting<std::uint8_t>(24);
  const std::string all = bytes_of(values);
  MemoryFiles files;
  files.files = {{"dir/a.raw", all},
                 {"dir/b c.raw", "head" + all},
                 {"dir/a.zraw", deflated(all, 15)},
                 {"dir/s01.raw", all.substr(0, 12)},
                 {"dir/s02.raw", all.substr(12)},
                 {"dir/z1", deflated(all.substr(0, 12), 15)},
                 {"dir/z2", deflated(all.substr(12), 15)}};
  for (const char* data :
       {"ElementDataFile = a.raw", "HeaderSize = 4\nElementDataFile = b c.raw",
        "HeaderSize = -1\nElementDataFile = b c.raw",
        "CompressedData = True\nElementDataFile = a.zraw", "ElementDataFile = s%02d.raw",
        "ElementDataFile = s%02d.raw 1", "ElementDataFile = s%02d.raw 1 2",
        "ElementDataFile = s%02d.raw 1 2 1", "ElementDataFile = LIST\ns01.raw\ns02.raw",
        "ElementDataFile = LIST 2D\r\ns01.raw\r\ns02.raw\r\n", "ElementDataFile = LIST 3\na.raw",
        "CompressedData = True\nElementDataFile = LIST\nz1\nz2"}) {
    EXPECT_EQ(values_of<std::uint8_t>(read_meta(kMeta + data, files).array()), values) << data;
  }
  EXPECT_EQ(meta_error(kMeta + "ElementDataFile = s%02d.raw 1 3 1", files),
            "file-format: dir/a.mha: ElementDataFile: names 3 files, sizes 4x3x2 with 2 axes in "
            "each need 2");
  EXPECT_EQ(meta_error(kMeta + "ElementDataFile = no.raw", files),
            "file-not-found: dir/a.mha: ElementDataFile: dir/no.raw: no such file");
  EXPECT_EQ(meta_error(kMeta + "ElementDataFile = a.mha", files),
            "file-format: dir/a.mha: ElementDataFile: 'a.mha': is the header itself");
  EXPECT_EQ(meta_error(kMeta + "CompressedDataSize = 999\nElementDataFile = a.raw", files),
            "file-format: dir/a.mha: CompressedDataSize: 999 bytes, dir/a.raw holds 24");
}

TEST(MetaImage, HeaderErrorsNameLineAndField) {
  const std::string data = kLocal + std::string(24, 'x');
  EXPECT_EQ(meta_error(with(kMeta, "4 3 2", "4 3") + data),
            "file-format: dir/a.mha: line 3: DimSize: '4 3' has 2 entries: expected 3");
  EXPECT_EQ(meta_error(with(kMeta, "4 3 2", "4 0 2") + data),
            "file-format: dir/a.mha: line 3: DimSize: '0': expected 1 to 2147483647");
  EXPECT_EQ(meta_error(with(kMeta, "MET_UCHAR", "MET_STRING") + data),
            "file-format: dir/a.mha: line 4: ElementType: 'MET_STRING': expected a type of numbers "
            "such as MET_UCHAR, MET_SHORT, MET_INT, MET_FLOAT or MET_DOUBLE");
  EXPECT_EQ(meta_error(with(kMeta, "Image", "Tube") + data),
            "unsupported: dir/a.mha: line 1: ObjectType: 'Tube': expected Image");
  EXPECT_EQ(meta_error(with(kMeta, "NDims = 3", "NDims = 5") + data),
            "unsupported: dir/a.mha: line 2: NDims: 5: expected 2 to 4");
  EXPECT_EQ(meta_error(kMeta + "NDims = 3\n" + data),
            "file-format: dir/a.mha: line 5: NDims: stands twice, first on line 2");
  EXPECT_EQ(meta_error(kMeta + "Offset = 1 2 nan\n" + data),
            "file-format: dir/a.mha: line 5: Offset: 'nan': expected finite numbers");
  EXPECT_EQ(meta_error(kMeta + "ElementSpacing = 1 0 1\n" + data).substr(0, 69),
            "file-format: dir/a.mha: TransformMatrix or ElementSpacing: the sample");
  EXPECT_EQ(meta_error(kMeta + "BinaryData = maybe\n" + data),
            "file-format: dir/a.mha: line 5: BinaryData: 'maybe': expected True or False");
  EXPECT_EQ(meta_error(kMeta + "words\n" + data),
            "file-format: dir/a.mha: line 5: 'words' is no 'Field = value' line");
  EXPECT_EQ(meta_error(kMeta), "file-format: dir/a.mha: the header has no field 'ElementDataFile'");
  EXPECT_EQ(meta_error(kMeta + "HeaderSize = 5\n" + data).substr(0, 70),
            "file-format: dir/a.mha: line 6: ElementDataFile: LOCAL: HeaderSize 5 e");
  EXPECT_EQ(meta_error(kMeta + kLocal + "short"),
            "file-format: dir/a.mha: holds 5 bytes, 4x3x2 uint8 needs 24: is the file truncated or "
            "a header field wrong?");
  EXPECT_EQ(read_meta(kMeta + "Wish = 1\n" + data).notes,
            (std::vector<std::string>{"dir/a.mha: line 5: field 'Wish' is not known and ignored"}));
}

TEST(MetaImage, FilesReadForListsTheData) {
  const TestFolder folder;
  folder.write("a.mhd", kMeta + "ElementDataFile = LIST\n1\n2\n3\n");
  folder.write("1", std::string(12, 'x'));
  folder.write("2", std::string(12, 'y'));
  EXPECT_EQ(files_read_for(folder.file("a.mhd")),
            (std::vector<std::string>{folder.file("a.mhd"), folder.file("1"), folder.file("2")}));
}

}  // namespace metaimage_test
}  // namespace ovoid::io
