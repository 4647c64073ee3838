// SPDX-License-Identifier: Apache-2.0
// How DICOM is told from other files. What would make these fail: the first bytes of a preamble,
// which are for other programs, decide; a file that happens to hold the letters DICM is taken.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "io/core/signatures.h"
#include "io/core/test_folder.h"
#include "io/dicom/test_dicom_series.h"
#include "io/images/test_volumes.h"
#include "ovoid/io.h"

namespace ovoid::io {
namespace dicom_detection_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST(DicomDetection, APreambleMayLookLikeAnotherFile) {
  using namespace std::string_literals;
  for (const std::string& start :
       {"II*\0\x54\0\0\0"s, "MM\0*\0\0\0\x54"s, "\x89PNG\r\n"s, "\xff\xd8\xff"s, "\x1f\x8b\x08"s,
        "NRRD0004\n"s, "PK\x03\x04"s, "# vtk DataFile"s, "<VTKFile "s, "\x93NUMPY"s,
        "\x89HDF\r\n\x1a\n"s, "CDF\x01"s, std::string(128, '7')}) {
    const TestFolder folder;
    for (int i = 0; i < 2; ++i) {
      const std::string slice = dicom_slice(slice_in_time(0, i));
      folder.write("s" + std::to_string(i), start + slice.substr(start.size()));
    }
    EXPECT_EQ(read_dataset({folder.file("s0")}).format, "DICOM") << start;
    const auto dims_of = [](const std::vector<std::string>& paths) {
      return read_dataset(paths).lattice.dims;
    };
    EXPECT_THAT(dims_of({folder.file("s0"), folder.file("s1")}), ElementsAre(3, 2, 2)) << start;
    EXPECT_THAT(dims_of({folder.file("")}), ElementsAre(3, 2, 2)) << start;
  }
}

TEST(DicomDetection, AnotherFileMayHoldTheLetters) {
  const std::string picture =
      std::string("II*\0", 4) + std::string(124, '\0') + "DICM" + std::string(200, '\1');
  EXPECT_FALSE(has_dicom_header(picture));
  EXPECT_EQ(picture_format_of(picture), "TIFF");
  const TestFolder folder;
  const std::string path = folder.write("a.tif", picture);
  EXPECT_THAT(error_of([&] { read_dataset({path}); }), Not(HasSubstr("DICOM")));
}

TEST(DicomDetection, ADirectoryOfAMediumNamesItsFolder) {
  const TestFolder folder;
  const std::string directory = folder.write(
      "DICOMDIR", dicom_file(kExplicitUid, DicomElements().text(0x00041130, "CS", "D").bytes()));
  EXPECT_THAT(error_of([&] { read_dataset({directory}); }),
              HasSubstr("DICOMDIR: is a DICOMDIR, the directory of a medium, without images: open "
                        "the folder that it lies in, '"));
  EXPECT_THAT(error_of([&] { read_dataset({folder.file("")}); }),
              HasSubstr("holds a DICOMDIR, the directory of a medium, and no images"));
}

}  // namespace dicom_detection_test
}  // namespace ovoid::io
