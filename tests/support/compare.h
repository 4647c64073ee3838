// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <string>

#include "ovoid/image.h"
#include "support/tolerances.h"

namespace ovoid::test {

// How two pictures of one size differ. Differences are of premultiplied RGBA as they are in memory;
// a pixel of NaN in one picture alone differs by infinity.
struct ImageDifference {
  double psnr_db = std::numeric_limits<double>::infinity();
  int max_8bit = 0;  // steps of 1/255, each picture rounded on its own
  double max_float = 0;
  double p999 = 0;               // of the pixels' greatest channel difference, covered pixels
  std::int64_t num_covered = 0;  // pixels with alpha > 0 in either
  std::int64_t num_beyond = 0;   // pixels that differ by more than kAgreement8BitDifference
  double psnr_of_others_db = std::numeric_limits<double>::infinity();  // of the other pixels
  int worst_x = -1;
  int worst_y = -1;
  std::int64_t num_depth_missing = 0;  // pixels where one picture alone has a depth
  double max_depth = 0;                // world units, where both have one
  double p999_depth = 0;

  std::string to_string() const;
};

// `peak` divides colours before they are compared: 1, or for x-ray pictures the greatest integral
// in the expected one. Throws Error(kInvalidArgument) if the sizes differ.
ImageDifference compare(const Image& actual, const Image& expected, double peak = 1.0);

// The greatest finite magnitude in the colours of a picture: the peak of an x-ray picture.
double greatest_color(const Image& image);

struct ImageTolerance {
  double min_psnr_db = kAgreementPsnrDb;
  int max_8bit = kAgreement8BitDifference;
  double peak = 1.0;
  // Pixels, of a thousand covered ones, that may differ by more, of any number one: where floats
  // decide about whole samples, as whether there is one.
  double beyond_per_mille = 0;
};

// For EXPECT_TRUE. On failure prints the differences, writes NAME_actual, NAME_expected and
// NAME_difference (.npy; and .png of the absolute difference, stretched to full range) into the
// folder "test-output" of the build, and says so.
::testing::AssertionResult agree(const Image& actual, const Image& expected,
                                 const std::string& name, const ImageTolerance& tolerance = {});

}  // namespace ovoid::test
