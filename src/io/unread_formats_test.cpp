// SPDX-License-Identifier: Apache-2.0
#include "io/unread_formats.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "fuzz/seeds.h"
#include "io/core/test_folder.h"
#include "io/images/test_volumes.h"
#include "io/read_source.h"

namespace ovoid::io {
namespace unread_formats_test {

std::string error_for(const std::string& name, const std::string& content) {
  return error_of([&] { read_source(*open_memory(name, std::as_bytes(std::span(content))), {}); });
}

// Fails if a well known file is called unknown, or taken for what its container is.
TEST(UnreadFormats, AreNamedWithAWayOut) {
  const std::string mrc = std::string(208, '\0') + "MAP " + std::string(300, '\0');
  const std::tuple<const char*, std::string, const char*, const char*> cases[] = {
      {"a.mgz", fuzz::gzip(std::string("\0\0\0\1", 4)), "FreeSurfer (MGH, MGZ)", "mri_convert"},
      {"a.mgh", std::string("\0\0\0\1", 4), "FreeSurfer", "mri_convert"},
      {"a+orig.HEAD", "type = string-attribute", "AFNI", "3dAFNItoNIFTI"},
      {"a+orig.BRIK.gz", fuzz::gzip("x"), "AFNI", "3dAFNItoNIFTI"},
      {"a.cube", "title", "Gaussian cube", "numpy.save"},
      {"a.map", mrc, "MRC or CCP4", "mrc2tif"},
      {"a.mrc.gz", fuzz::gzip(mrc), "MRC or CCP4", "mrc2tif"},
      {"a", "ZISRAWFILE", "Zeiss CZI", "OME-TIFF"},
      {"a.mnc", std::string("CDF\1\0\0\0\0", 8), "MINC", "mnc2nii"},
      {"a.cgns", "\x89HDF\r\n\x1a\n", "CGNS", "meshio"},
      {"a.mat", "MATLAB 5.0 MAT-file", "MATLAB", "loadmat"},
      {"a.foam", "", "OpenFOAM", "foamToVTK"},
      {"a.tar", std::string(257, 'x') + "ustar", "tar archive", "unpacked"}};
  for (const auto& [name, content, format, way] : cases) {
    const std::string error = error_for(name, content);
    EXPECT_EQ(error.substr(0, 13), "unsupported: ") << name;
    EXPECT_NE(error.find(format), std::string::npos) << error;
    EXPECT_NE(error.find(way), std::string::npos) << error;
  }
  EXPECT_NE(error_for("a.abcd", "hello").find("the format is not known"), std::string::npos);
}

TEST(UnreadFormats, FoldersAreNamed) {
  const TestFolder folder;
  std::filesystem::create_directory(folder.file("plt"));
  folder.write("plt/Header", "HyperCLaw-V1.1\n");
  EXPECT_NE(error_of([&] { read_dataset({folder.file("plt")}); }).find("is an AMReX plotfile"),
            std::string::npos);
}

// CIFTI has NIfTI's magic, and its numbers are those of no lattice.
TEST(UnreadFormats, CiftiIsNamed) {
  std::string header(540, '\0');
  header.replace(0, 12, std::string("\x1c\x02\0\0n+2\0\r\n\x1a\n", 12));
  header[12] = 16;
  header[14] = 32;
  header[504] = static_cast<char>(3006 % 256);
  header[505] = static_cast<char>(3006 / 256);
  const std::string error = error_for("a.dscalar.nii", header + std::string(100, '\0'));
  EXPECT_NE(error.find("is CIFTI"), std::string::npos) << error;
  EXPECT_NE(error.find("wb_command -cifti-separate"), std::string::npos) << error;
}

}  // namespace unread_formats_test
}  // namespace ovoid::io
