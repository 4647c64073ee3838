// SPDX-License-Identifier: Apache-2.0
#include "support/compare.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "ovoid/error.h"
#include "ovoid/io.h"

namespace ovoid::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A channel of a pixel, colours over `peak`.
double channel(const Image& image, std::size_t position, std::size_t c, double peak) {
  return static_cast<double>(image.rgba[4 * position + c]) / (c < 3 ? peak : 1.0);
}

double distance(double a, double b) {
  if (std::isnan(a) && std::isnan(b)) return 0;
  const double difference = std::abs(a - b);
  return a == b ? 0 : std::isnan(difference) ? kInfinity : difference;
}

int steps_of(double value) {
  return std::isnan(value) ? -1000
                           : static_cast<int>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

double percentile_999(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto rank = static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

void compare_depths(const Image& actual, const Image& expected, ImageDifference& result) {
  std::vector<double> differences;
  for (std::size_t p = 0; p < actual.depth.size(); ++p) {
    const bool has_actual = std::isfinite(actual.depth[p]);
    const bool has_expected = std::isfinite(expected.depth[p]);
    if (has_actual != has_expected) ++result.num_depth_missing;
    if (!has_actual || !has_expected) continue;
    differences.push_back(
        distance(static_cast<double>(actual.depth[p]), static_cast<double>(expected.depth[p])));
    result.max_depth = std::max(result.max_depth, differences.back());
  }
  result.p999_depth = percentile_999(std::move(differences));
}

// |a - b| with the greatest at full range, opaque: for the eye.
Image difference_picture(const Image& actual, const Image& expected) {
  Image picture = actual;
  float greatest = 0;
  for (std::size_t n = 0; n < picture.rgba.size(); ++n) {
    picture.rgba[n] = std::abs(actual.rgba[n] - expected.rgba[n]);
    if (std::isfinite(picture.rgba[n])) greatest = std::max(greatest, picture.rgba[n]);
  }
  for (std::size_t n = 0; n < picture.rgba.size(); ++n) {
    const float scaled = greatest > 0 ? picture.rgba[n] / greatest : 0.0F;
    picture.rgba[n] = n % 4 == 3 ? 1.0F : std::isfinite(scaled) ? scaled : 1.0F;
  }
  return picture;
}

// Where the pictures went, or why they did not.
std::string write_evidence(const Image& actual, const Image& expected, const std::string& name) {
  const std::filesystem::path folder = OVOID_TEST_OUTPUT;
  try {
    std::filesystem::create_directories(folder);
    write_image(actual, (folder / (name + "_actual.npy")).string());
    write_image(expected, (folder / (name + "_expected.npy")).string());
    const Image difference = difference_picture(actual, expected);
    write_image(difference, (folder / (name + "_difference.png")).string());
  } catch (const std::exception& error) {
    return fmt::format("pictures not written: {}", error.what());
  }
  return fmt::format("pictures: {}/{}_*", folder.string(), name);
}

}  // namespace

std::string ImageDifference::to_string() const {
  return fmt::format(
      "PSNR {:.2f} dB, max {} / 255 ({:.3g}), {} beyond, p99.9 {:.3g}, {} pixels covered, worst at "
      "({}, {}); "
      "depth: {} missing in "
      "one, max {:.3g}, p99.9 {:.3g}",
      psnr_db, max_8bit, max_float, num_beyond, p999, num_covered, worst_x, worst_y,
      num_depth_missing, max_depth, p999_depth);
}

ImageDifference compare(const Image& actual, const Image& expected, double peak) {
  if (actual.width != expected.width || actual.height != expected.height) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("pictures of {} x {} and {} x {}: expected equal sizes", actual.width,
                            actual.height, expected.width, expected.height));
  }
  ImageDifference result;
  std::vector<double> differences;
  double sum_of_squares = 0;
  double sum_of_others = 0;
  for (int y = 0; y < actual.height; ++y) {
    for (int x = 0; x < actual.width; ++x) {
      const auto position = static_cast<std::size_t>(y) * static_cast<std::size_t>(actual.width) +
                            static_cast<std::size_t>(x);
      double worst = 0;
      double squares = 0;
      int most_steps = 0;
      for (std::size_t c = 0; c < 4; ++c) {
        const double a = channel(actual, position, c, peak);
        const double b = channel(expected, position, c, peak);
        worst = std::max(worst, distance(a, b));
        squares += distance(a, b) * distance(a, b);
        most_steps = std::max(most_steps, std::abs(steps_of(a) - steps_of(b)));
      }
      result.max_8bit = std::max(result.max_8bit, most_steps);
      if (worst > result.max_float) {
        result.max_float = worst;
        result.worst_x = x;
        result.worst_y = y;
      }
      const bool is_covered =
          !(channel(actual, position, 3, 1) <= 0) || !(channel(expected, position, 3, 1) <= 0);
      if (!is_covered) continue;
      ++result.num_covered;
      sum_of_squares += squares;
      if (most_steps > kAgreement8BitDifference) {
        ++result.num_beyond;
      } else {
        sum_of_others += squares;
      }
      differences.push_back(worst);
    }
  }
  const auto decibels = [](double squares, std::int64_t pixels) {
    return squares > 0 ? -10 * std::log10(squares / (4 * static_cast<double>(pixels)))
                       : std::numeric_limits<double>::infinity();
  };
  result.psnr_db = decibels(sum_of_squares, result.num_covered);
  result.psnr_of_others_db = decibels(sum_of_others, result.num_covered - result.num_beyond);
  result.p999 = percentile_999(std::move(differences));
  compare_depths(actual, expected, result);
  return result;
}

double greatest_color(const Image& image) {
  double greatest = 0;
  for (std::size_t n = 0; n < image.rgba.size(); ++n) {
    const double magnitude = std::abs(static_cast<double>(image.rgba[n]));
    if (n % 4 != 3 && std::isfinite(magnitude)) greatest = std::max(greatest, magnitude);
  }
  return greatest;
}

::testing::AssertionResult agree(const Image& actual, const Image& expected,
                                 const std::string& name, const ImageTolerance& tolerance) {
  const ImageDifference difference = compare(actual, expected, tolerance.peak);
  const bool is_all_near =
      difference.psnr_db >= tolerance.min_psnr_db && difference.max_8bit <= tolerance.max_8bit;
  const double per_mille = tolerance.beyond_per_mille / 1000;
  const bool are_others_near =
      per_mille > 0 && difference.psnr_of_others_db >= tolerance.min_psnr_db &&
      static_cast<double>(difference.num_beyond) <=
          std::max(1.0, per_mille * static_cast<double>(difference.num_covered));
  if (is_all_near || are_others_near)
    return ::testing::AssertionSuccess() << difference.to_string();
  return ::testing::AssertionFailure()
         << name << ": " << difference.to_string() << "; expected PSNR >= " << tolerance.min_psnr_db
         << " dB and max <= " << tolerance.max_8bit << " / 255; "
         << write_evidence(actual, expected, name);
}

}  // namespace ovoid::test
