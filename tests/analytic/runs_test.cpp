// SPDX-License-Identifier: Apache-2.0
// The primitive that stands for a run of samples that rise evenly: METHOD's exact form by two
// tables, against the sum of kernels, and against the field that is drawn of a simplified lattice.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "io/images/test_volumes.h"
#include "ovoid/model.h"
#include "ovoid/sampler.h"
#include "ovoid/simplify.h"

namespace ovoid::test {
namespace runs_test {

constexpr double kCutOff = 2;

// The dissertation's kernel.
double gaussian(double x) { return std::abs(x) <= kCutOff ? std::exp(-2 * x * x) : 0; }

// Sums over all kernels from one on, by tables over where they no longer change: T and U.
class RunTables {
 public:
  static double counts(double x) {
    return sum(x, [](double) { return 1.0; });
  }
  static double positions(double x) {
    return sum(x, [](double i) { return i; });
  }

 private:
  template <class Factor>
  static double sum(double x, const Factor& factor) {
    double total = 0;
    for (double i = std::max(0.0, std::ceil(x - kCutOff)); i <= x + kCutOff; ++i)
      total += factor(i) * gaussian(x - i);
    return total;
  }
};

// Of n samples a + b i.
struct EvenRun {
  double n, a, b;

  double exact(double x) const {
    const double counts = RunTables::counts(x - n);
    return a * (RunTables::counts(x) - counts) +
           b * (RunTables::positions(x) - RunTables::positions(x - n) - n * counts);
  }

  double summed(double x) const {
    double total = 0;
    for (double i = 0; i < n; ++i) total += (a + b * i) * gaussian(x - i);
    return total;
  }

  // Its ends by box filters of one sample.
  double smooth(double x) const {
    const double from = -0.5 - x, to = n - 0.5 - x, root = std::numbers::sqrt2;
    return (a + b * x) * std::sqrt(std::numbers::pi / 8) *
               (std::erf(root * to) - std::erf(root * from)) +
           b / 4 * (std::exp(-2 * from * from) - std::exp(-2 * to * to));
  }

  // The greatest errors of the smooth form, as shares of the peak: inside, and at the ends.
  std::array<double, 2> errors_of_smooth() const {
    std::array<double, 2> errors{};
    double peak = 0;
    for (double x = -3; x <= n + 2; x += 1.0 / 64) {
      const bool is_inside = x >= 2 && x <= n - 3;
      double& error = errors[is_inside ? 0 : 1];
      error = std::max(error, std::abs(smooth(x) - summed(x)));
      peak = std::max(peak, std::abs(summed(x)));
    }
    return {errors[0] / peak, errors[1] / peak};
  }
};

// Fails if a table starts a kernel late, or a run ends a sample too early.
TEST(RunPrimitive, IsTheSumOfItsKernels) {
  EXPECT_NEAR((EvenRun{4, 1, 0}).exact(1.5), 1.23528, 5e-6);
  EXPECT_NEAR((EvenRun{4, 1, 0}).smooth(1.5), 1.25323, 5e-6);
  for (const EvenRun& run :
       {EvenRun{1, 2, 0}, EvenRun{4, 1, 0}, EvenRun{7, -1, 0.5}, EvenRun{30, 3, -2}}) {
    for (double x = -4; x < run.n + 4; x += 0.093)
      EXPECT_NEAR(run.exact(x), run.summed(x), 1e-12 * run.n * 60);
  }
}

// The smooth form is no substitute where a neighbour is a sample: 1.4 % of the peak inside, which
// is the kernels' ripple, 6.5 % at the ends of runs of one value.
TEST(RunPrimitive, TheSmoothFormErrsAtTheEnds) {
  const std::array<double, 2> constant = (EvenRun{12, 1, 0}).errors_of_smooth();
  EXPECT_NEAR(constant[0], 0.0142, 0.002);
  EXPECT_NEAR(constant[1], 0.065, 0.005);
  const std::array<double, 2> ramp = (EvenRun{12, 1, 1}).errors_of_smooth();
  EXPECT_GT(ramp[1], 0.06);
  EXPECT_LT(ramp[1], 0.09);
}

// Fails if the field that is drawn of a simplified lattice is not the sum of its primitives: a run
// along x in nothing, with the published kernel, whose weights sum to one over the plane.
TEST(RunPrimitive, IsWhatIsDrawn) {
  constexpr std::int64_t kBegin = 6, kEnd = 15;
  const Index3 dims{24, 9, 9};
  const auto value = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return i >= kBegin && i < kEnd && j == 4 && k == 4 ? 10 + 3.0 * static_cast<double>(i - kBegin)
                                                       : 0.0;
  };
  Dataset dataset;
  dataset.lattice.dims = dims;
  std::vector<float> values;
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      for (std::int64_t i = 0; i < dims[0]; ++i)
        values.push_back(static_cast<float>(value(i, j, k)));
    }
  }
  dataset.arrays = {io::make_array("v", ScalarType::kFloat32, values)};
  const LatticeBoxes boxes = simplify_lattice(dataset, {});
  ASSERT_EQ(boxes.boxes.size(), 1U);
  ASSERT_EQ(boxes.boxes[0].size[0], kEnd - kBegin);
  dataset.arrays = {io::make_array("v", ScalarType::kFloat32, samples_of(boxes))};
  LatticeModelOptions model;
  model.kernel = LatticeKernel{};
  model.prefilter = false;
  model.reconstruction = Reconstruction::kSum;
  const FieldSampler field{make_lattice_field(dataset, model)};
  const EvenRun run{static_cast<double>(kEnd - kBegin), 10, 3};
  const double integral = std::sqrt(std::numbers::pi / 2);
  for (double x = 3.1; x < 19; x += 0.37) {
    for (const double y : {4.0, 4.3, 5.2}) {
      const double primitive = run.exact(x - kBegin) * gaussian(y - 4) * gaussian(0.25);
      EXPECT_NEAR(field.at({x, y, 4.25}).value, primitive / std::pow(integral, 3), 2e-3 * 34);
    }
  }
}

}  // namespace runs_test
}  // namespace ovoid::test
