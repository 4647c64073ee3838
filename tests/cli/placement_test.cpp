// SPDX-License-Identifier: Apache-2.0
// Files that place a volume: matrices, and ITK's transforms, whose numbers are checked against the
// maps that ITK's own classes make of them by their definitions.
#include "placement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "ovoid/error.h"

namespace ovoid::cli_tests {
namespace placement_test {

using cli::placement_from_text;

std::string itk(const std::string& type, const std::string& parameters,
                const std::string& fixed = "0 0 0") {
  return "#Insight Transform File V1.0\n#Transform 0\nTransform: " + type +
         "\nParameters: " + parameters + "\nFixedParameters: " + fixed + "\n";
}

Affine3 placed(const std::string& text, Space space = Space::kLps) {
  return placement_from_text(text, "a.tfm", space);
}

void expect_map(const Affine3& map, const Vec3& from, const Vec3& to) {
  EXPECT_LT((map * from - to).norm(), 1e-12 * (1 + to.norm())) << (map * from).transpose();
}

// Fails if rows are taken for columns, or the matrix for its inverse.
TEST(Placement, MatrixLeadsFromTheFilesWorldToThePictures) {
  const std::string rows = "0 -1 0 10\n1 0 0 20 # turned\n0 0 2 30\n";
  const std::string texts[] = {rows + "0 0 0 1\n", rows, "[" + rows + "]",
                               "# a comment\n0,-1,0,10; 1,0,0,20; 0,0,2,30; 0,0,0,1"};
  for (const std::string& text : texts) expect_map(placed(text), {1, 2, 3}, {8, 21, 36});
  // It is in the picture's own coordinates, whatever its space.
  expect_map(placed(rows, Space::kRas), {1, 2, 3}, {8, 21, 36});
}

// Fails if the direction, the centre, the order of angles or the space of ITK's files is another.
TEST(Placement, ItkTransformLeadsFromThePictureToTheVolume) {
  expect_map(placed(itk("TranslationTransform_double_3_3", "1 2 3")), {11, 22, 33}, {10, 20, 30});
  expect_map(placed(itk("TranslationTransform_double_3_3", "1 2 3"), Space::kRas), {-11, -22, 33},
             {-10, -20, 30});
  expect_map(placed(itk("TranslationTransform_double_3_3", "1 2 3"), Space::kNone), {11, 22, 33},
             {10, 20, 30});
  // y = M (x - c) + c + t, inverted.
  const std::string affine = "0 -1 0 1 0 0 0 0 2 5 6 7";
  for (const char* const type :
       {"AffineTransform_double_3_3", "MatrixOffsetTransformBase_float_3_3"})
    expect_map(placed(itk(type, affine, "1 1 1")),
               {1 - (5 - 1) + 5, 1 + (4 - 1) + 6, 1 + 2 * 2 + 7}, {4, 5, 3});
  // A quarter about z as a versor, and as the third of Euler's angles.
  const double half = std::sqrt(0.5);
  const std::string quarter = "0 0 " + std::to_string(half) + " 1 2 3";
  EXPECT_LT((placed(itk("VersorRigid3DTransform_double_3_3", quarter)) * Vec3(1 - 5, 2 + 4, 3 + 6) -
             Vec3(4, 5, 6))
                .norm(),
            1e-5);
  const std::string similar = "0 0 " + std::to_string(half) + " 1 2 3 2";
  EXPECT_LT(
      (placed(itk("Similarity3DTransform_double_3_3", similar)) * Vec3(1 - 10, 2 + 8, 3 + 12) -
       Vec3(4, 5, 6))
          .norm(),
      1e-5);
  // Rz Rx Ry, or Rz Ry Rx if the file says so.
  const std::string angles = "1.5707963267948966 1.5707963267948966 0 0 0 0";
  expect_map(placed(itk("Euler3DTransform_double_3_3", angles)), {3, 1, 2}, {1, 2, 3});
  expect_map(placed(itk("Euler3DTransform_double_3_3", angles, "0 0 0 1")), {2, -3, -1}, {1, 2, 3});
  // Of a composite the last is applied first: twice x, then by (1, 2, 3).
  const std::string composite =
      "#Insight Transform File V1.0\nTransform: CompositeTransform_double_3_3\n"
      "Transform: TranslationTransform_double_3_3\nParameters: 1 2 3\nFixedParameters:\n"
      "Transform: AffineTransform_double_3_3\nParameters: 2 0 0 0 1 0 0 0 1 0 0 0\r\n"
      "FixedParameters: 0 0 0\n";
  expect_map(placed(composite), {9, 7, 9}, {4, 5, 6});
}

// Fails if a file that places nothing is taken for one that does.
TEST(Placement, RefusesWhatPlacesNothing) {
  const auto expect_refused = [](const std::string& text, const std::string& words) {
    try {
      placed(text);
      ADD_FAILURE() << "was taken: " << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
      EXPECT_NE(std::string(error.what()).find("'a.tfm': "), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  };
  expect_refused("", "has 0 numbers");
  expect_refused("1 0 0 0 1 0 0 0 1", "has 9 numbers");
  expect_refused("1 0 0 0 0 1 0 0 0 0 one 0", "'one' is no number");
  expect_refused("1 0 0 0 0 1 0 0 0 0 inf 0", "'inf' is no number");
  expect_refused("1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1", "last row");
  expect_refused("1 0 0 0 0 1 0 0 1 1 0 0", "singular");
  expect_refused("0 0 0 0 0 0 0 0 0 0 0 0", "singular");
  expect_refused(std::string("1 0 0\0 0", 8), "is no text");
  expect_refused("#Insight Transform File V1.0\n", "names no transform");
  expect_refused(itk("AffineTransform_double_2_2", "1 0 0 1 0 0"), "three dimensions");
  expect_refused(itk("BSplineTransform_double_3_3", "1 2 3"), "none of the transforms");
  expect_refused(itk("AffineTransform_double_3_3", "1 2 3"), "has 3 parameters, expected 12");
  expect_refused(itk("AffineTransform_double_3_3", "1 0 0 0 1 0 0 0 0 0 0 0"), "singular");
  expect_refused(itk("VersorRigid3DTransform_double_3_3", "1 1 0 0 0 0"), "longer than 1");
  const std::string one = itk("TranslationTransform_double_3_3", "1 2 3");
  expect_refused(one + one.substr(one.find('\n') + 1), "has 2 transforms");
}

// Fails if a volume in one patient's space is drawn in another's as it is.
TEST(Placement, SpacesOfPatientsDifferInTwoSigns) {
  expect_map(cli::between_spaces(Space::kLps, Space::kRas), {1, 2, 3}, {-1, -2, 3});
  expect_map(cli::between_spaces(Space::kRas, Space::kLps), {1, 2, 3}, {-1, -2, 3});
  expect_map(cli::between_spaces(Space::kRas, Space::kRas), {1, 2, 3}, {1, 2, 3});
  expect_map(cli::between_spaces(Space::kNone, Space::kLps), {1, 2, 3}, {1, 2, 3});
}

}  // namespace placement_test
}  // namespace ovoid::cli_tests
