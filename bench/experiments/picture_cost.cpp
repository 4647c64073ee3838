// SPDX-License-Identifier: Apache-2.0
#include "experiments/picture_cost.h"

#include <algorithm>
#include <ctime>
#include <limits>
#include <utility>

namespace ovoid::experiments {

namespace {

constexpr int kCostRepeats = 5;

Look skin_and_bone() {
  Look look;
  look.transfer_function.colors = {{-500, {0.90, 0.60, 0.45}},
                                   {150, {0.95, 0.70, 0.55}},
                                   {350, {1.00, 0.95, 0.85}},
                                   {1500, {1.00, 1.00, 0.95}}};
  look.transfer_function.opacities = {{-500, 0},   {-300, 0.04}, {100, 0.04},
                                      {250, 0.01}, {400, 0.5},   {1500, 0.8}};
  return look;
}

Camera three_quarter_view(const LatticeField& field) {
  Camera camera = default_camera(field.world_bounds(), Space::kLps);
  camera.azimuth(35);
  camera.elevation(15);
  return camera;
}

struct TimedFrame {
  Image image;
  double cpu_ms;  // of all threads: other programs on the machine disturb it least
};

// The same frame several times; returns the cheapest.
TimedFrame best_of(Renderer& renderer, const LatticeField& field, const Look& look,
                   const RenderOptions& options) {
  const Camera camera = three_quarter_view(field);
  TimedFrame best{{}, std::numeric_limits<double>::infinity()};
  for (int n = 0; n < kCostRepeats; ++n) {
    const std::clock_t start = std::clock();
    Frame frame = renderer.render({field, look}, camera, options);
    const double cpu_ms = 1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    if (cpu_ms < best.cpu_ms) best = {std::move(frame.image), cpu_ms};
  }
  return best;
}

RenderOptions square(int pixels) {
  RenderOptions options;
  options.sheets = Sheets::kImage;
  options.width = pixels;
  options.height = pixels;
  options.classification = Classification::kSampled;
  return options;
}

}  // namespace

std::vector<PictureCost> measure_picture_cost(std::int64_t size, int pixels) {
  const LatticeField field = field_of(make_sample("head", {{size, size, size}}), default_choice());
  const Look look = skin_and_bone();
  const double spacing = field.default_sampling_distance();
  Renderer renderer(Backend::kCpu);
  RenderOptions options = square(pixels);
  options.sampling_distance = spacing / 8;
  const Image fine = renderer.render({field, look}, three_quarter_view(field), options).image;

  std::vector<PictureCost> rows;
  for (const Slab slab : {Slab::kMid, Slab::kMean}) {
    for (const GradientMethod gradient :
         {GradientMethod::kCorrected, GradientMethod::kExact, GradientMethod::kCentral}) {
      for (const double sheets : {1.0, 2.0, 4.0}) {
        // The mean of a thin slab is its middle.
        if (slab == Slab::kMean && (sheets > 2 || gradient != GradientMethod::kCorrected)) continue;
        options.slab = slab;
        options.gradient = gradient;
        options.sampling_distance = spacing / sheets;
        TimedFrame frame = best_of(renderer, field, look, options);
        PictureCost row{slab, gradient, sheets, psnr(frame.image, fine), frame.cpu_ms, {}};
        row.image = std::move(frame.image);
        rows.push_back(std::move(row));
      }
    }
  }
  return rows;
}

std::vector<double> measure_kernel_cost(const std::vector<KernelChoice>& choices, std::int64_t size,
                                        int pixels) {
  const Dataset head = make_sample("head", {{size, size, size}});
  Renderer renderer(Backend::kCpu);
  std::vector<double> times;
  for (const KernelChoice& choice : choices) {
    const LatticeField field = field_of(head, choice);
    times.push_back(best_of(renderer, field, skin_and_bone(), square(pixels)).cpu_ms);
  }
  const double first = times.front();
  for (double& time : times) time /= first;
  return times;
}

}  // namespace ovoid::experiments
