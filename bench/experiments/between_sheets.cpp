// SPDX-License-Identifier: Apache-2.0
#include "experiments/between_sheets.h"

#include <algorithm>
#include <ctime>
#include <limits>
#include <utility>

#include "experiments/fields.h"

namespace ovoid::experiments {

namespace {

constexpr int kRepeats = 3;
constexpr double kFineSheets = 16;

struct Subject {
  std::string name;
  LatticeField field;
  Look look;
};

// Thin shells at five values.
Look layers() {
  Look look;
  look.transfer_function = color_map("turbo");
  look.transfer_function.opacities.clear();
  for (const double value : {0.1, 0.25, 0.4, 0.6, 0.8}) {
    auto& points = look.transfer_function.opacities;
    points.insert(points.end(), {{value - 0.02, 0}, {value, 0.5}, {value + 0.02, 0}});
  }
  return look;
}

Look bone() {
  Look look;
  look.transfer_function.colors = {{-500, {0.90, 0.60, 0.45}}, {1500, {1.00, 1.00, 0.95}}};
  look.transfer_function.opacities = {{-500, 0},   {-300, 0.04}, {100, 0.04},
                                      {250, 0.01}, {400, 0.5},   {1500, 0.8}};
  return look;
}

std::vector<Subject> subjects(std::int64_t size) {
  const Index3 dims{size, size, size};
  return {{"layers", field_of(make_sample("ball", {dims}), default_choice()), layers()},
          {"skin and bone", field_of(make_sample("head", {dims}), default_choice()), bone()}};
}

}  // namespace

std::vector<BetweenSheets> measure_between_sheets(std::int64_t size, int pixels) {
  Renderer renderer(Backend::kCpu);
  std::vector<BetweenSheets> rows;
  for (const Subject& subject : subjects(size)) {
    Camera camera = default_camera(subject.field.world_bounds(), Space::kNone);
    camera.azimuth(35);
    camera.elevation(15);
    camera.parallel_projection = true;
    camera.parallel_scale = 0.6 * subject.field.world_bounds().sizes().maxCoeff();
    RenderOptions options;
    options.sheets = Sheets::kImage;
    options.width = pixels;
    options.height = pixels;
    const double spacing = subject.field.default_sampling_distance();
    options.sampling_distance = spacing / kFineSheets;
    options.classification = Classification::kSampled;
    const Image fine = renderer.render({subject.field, subject.look}, camera, options).image;
    for (const Classification classification :
         {Classification::kSampled, Classification::kPreintegrated, Classification::kRefined}) {
      for (const double sheets : {0.5, 1.0, 2.0, 4.0}) {
        options.classification = classification;
        options.sampling_distance = spacing / sheets;
        BetweenSheets row{
            subject.name, classification, sheets, 0, std::numeric_limits<double>::infinity(), {}};
        for (int n = 0; n < kRepeats; ++n) {
          const std::clock_t start = std::clock();
          row.image = renderer.render({subject.field, subject.look}, camera, options).image;
          row.cpu_ms = std::min(row.cpu_ms,
                                1e3 * static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
        }
        row.psnr_db = psnr(row.image, fine);
        rows.push_back(std::move(row));
      }
    }
    rows.push_back({subject.name, Classification::kSampled, kFineSheets,
                    std::numeric_limits<double>::infinity(), 0, fine});
  }
  return rows;
}

}  // namespace ovoid::experiments
