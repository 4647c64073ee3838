// SPDX-License-Identifier: Apache-2.0
// ovoid_experiments FOLDER [NAME...]: runs the experiments of docs/numerics.md, all of them or
// those named, prints their tables as Markdown and writes their pictures into FOLDER.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "experiments/adam_baseline.h"
#include "experiments/between_sheets.h"
#include "experiments/crisp_edges.h"
#include "experiments/fields.h"
#include "experiments/grid_pattern.h"
#include "experiments/kernel_choice.h"
#include "experiments/picture_cost.h"
#include "experiments/pictures.h"
#include "experiments/popping.h"
#include "experiments/removed_samples.h"
#include "experiments/site_fits.h"
#include "experiments/site_shapes.h"
#include "ovoid/io.h"

namespace ovoid::experiments {
namespace {

// Reach 2 is four samples per axis, which the CPU back end sums fastest; more than 3 changes
// nothing.
std::vector<KernelChoice> choices() {
  std::vector<KernelChoice> list = {published_choice()};
  for (const bool prefilter : {false, true}) {
    for (const double sigma : {0.4, 0.45, 0.5, 0.55, 0.6, 0.65}) {
      list.push_back(normalized_choice(sigma, 2, prefilter));
    }
    list.push_back(normalized_choice(0.6, 2.5, prefilter));
    list.push_back(normalized_choice(0.7, 3, prefilter));
  }
  list.push_back(catmull_rom_choice());
  list.push_back(default_choice());
  return list;
}

const char* name_of(GradientMethod gradient) {
  switch (gradient) {
    case GradientMethod::kCorrected:
      return "corrected";
    case GradientMethod::kExact:
      return "exact";
    default:
      return "central";
  }
}

void print_row(const std::string& name, const KernelErrors& e) {
  fmt::print(
      "| {} | {:.2f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.3f} | {:.3f} | {:.3f} | {:.2f} | "
      "{:.2f} | {:.1f} |\n",
      name, 100 * e.rms, 100 * e.greatest, e.exact_deg, e.corrected_deg, e.central_deg, e.quarter,
      e.half, 100 * e.ripple, e.ramp_deg, e.corrected_ramp_deg, 100 * e.overshoot);
}

void kernels(const std::string&) {
  constexpr int kNumPoints = 10000;
  fmt::print(
      "| field | rms % | greatest % | exact | corrected | central | at 1/4 | at 1/2 | ripple % | "
      "ramp, exact | "
      "ramp, corrected | overshoot % |\n|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  print_row("trilinear", measure_trilinear(kNumPoints));
  for (const KernelChoice& choice : choices()) {
    print_row(choice.name, measure_kernel(choice, kNumPoints));
  }
}

void kernel_cost(const std::string&) {
  std::vector<KernelChoice> list = {default_choice(), catmull_rom_choice(),
                                    normalized_choice(0.5, 2, false)};
  for (const double reach : {2.0, 2.5, 3.0}) list.push_back(normalized_choice(0.6, reach, false));
  list.push_back(normalized_choice(0.6, 2, true));
  const std::vector<double> times = measure_kernel_cost(list, 128, 256);
  fmt::print("| field | processor time |\n|---|---|\n");
  for (std::size_t n = 0; n < list.size(); ++n) {
    fmt::print("| {} | {:.2f} |\n", list[n].name, times[n]);
  }
}

void pictures(const std::string&) {
  const std::vector<PictureCost> rows = measure_picture_cost(128, 256);
  const double first = rows.front().cpu_ms;
  fmt::print(
      "| slab | gradient | sheets per spacing | dB to 8 sheets | processor time |\n"
      "|---|---|---|---|---|\n");
  for (const PictureCost& row : rows) {
    fmt::print("| {} | {} | {} | {:.1f} | {:.2f} |\n", row.slab == Slab::kMid ? "mid" : "mean",
               name_of(row.gradient), row.sheets_per_spacing, row.psnr_db, row.cpu_ms / first);
  }
}

void grid(const std::string& folder) {
  std::vector<KernelChoice> list = {published_choice()};
  for (const double sigma : {0.4, 0.5, 0.55, 0.6, 0.65}) {
    list.push_back(normalized_choice(sigma, 2, false));
  }
  list.push_back(normalized_choice(0.6, 2.5, false));
  list.push_back(normalized_choice(0.7, 3, false));
  list.push_back(normalized_choice(0.5, 2, true));
  list.push_back(normalized_choice(0.6, 2, true));
  list.push_back(normalized_choice(0.6, 2.5, true));
  list.push_back(normalized_choice(0.7, 3, true));
  list.push_back(catmull_rom_choice());
  list.push_back(default_choice());
  fmt::print(
      "| field | plane, exact | ball, exact | plane, corrected | ball, corrected |\n"
      "|---|---|---|---|---|\n");
  for (const KernelChoice& choice : list) {
    std::string row = fmt::format("| {} |", choice.name);
    for (const GradientMethod gradient : {GradientMethod::kExact, GradientMethod::kCorrected}) {
      for (const SmoothSurface surface : {SmoothSurface::kPlane, SmoothSurface::kBall}) {
        const GridPatternOptions options{surface, 256, 12, gradient};
        row += fmt::format(" {:.2f} |", measure_grid_pattern(choice, options).residual);
      }
    }
    fmt::print("{}\n", row);
  }
  std::vector<Image> images;
  const auto draw = [&](const KernelChoice& choice, GradientMethod gradient) {
    const GridPatternOptions options{SmoothSurface::kBall, 200, 9, gradient};
    images.push_back(measure_grid_pattern(choice, options).image);
  };
  draw(published_choice(), GradientMethod::kExact);
  draw(normalized_choice(0.5, 2, false), GradientMethod::kExact);
  draw(normalized_choice(0.5, 2, false), GradientMethod::kCorrected);
  draw(default_choice(), GradientMethod::kCorrected);
  write_figure(side_by_side(images), folder + "/grid-pattern.png");
}

void popping(const std::string& folder) {
  const TurnOptions options;
  struct Variant {
    const char* name;
    Turn turn;
  };
  const std::vector<Variant> variants = {
      {"image-aligned, CPU back end, lit", turn_renderer(options)},
      {"image-aligned, control renderer", turn_control(Sheets::kImageAligned, options)},
      {"axis-aligned planes, control renderer", turn_control(Sheets::kAxisPlanes, options)},
      {"axis-aligned slices of whole kernels, control renderer",
       turn_control(Sheets::kAxisSlices, options)}};
  fmt::print(
      "| sheets | median step | greatest other step | step through 45 degrees | jump |\n"
      "|---|---|---|---|---|\n");
  for (const Variant& variant : variants) {
    std::vector<double> others = variant.turn.changes;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(others.size() / 2));
    fmt::print("| {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", variant.name, variant.turn.median(),
               *std::max_element(others.begin(), others.end()), variant.turn.at_switch(),
               variant.turn.jump());
  }
  const Turn& aligned = variants[1].turn;
  const Turn& slices = variants[3].turn;
  const auto shown = [](const Image& image) { return magnified(image, 0, 0, image.width, 2); };
  write_figure(side_by_side({shown(slices.before), shown(slices.after),
                             shown(difference(slices.before, slices.after, 4)),
                             shown(difference(aligned.before, aligned.after, 4))}),
               folder + "/popping.png");
}

void edges(const std::string& folder) {
  fmt::print("| zoom | classified after reconstruction, px | before, px |\n|---|---|---|\n");
  for (const double zoom : {1.0, 2.0, 4.0, 8.0, 16.0}) {
    const CrispEdge edge = measure_edge(zoom, 128);
    fmt::print("| {} | {:.2f} | {:.2f} |\n", zoom, edge.post_px, edge.pre_px);
  }
  const CrispEdge edge = measure_edge(16, 240);
  write_figure(side_by_side({edge.post, edge.pre}), folder + "/crisp-edges.png");
}

std::string_view name_of(Classification classification) {
  switch (classification) {
    case Classification::kSampled:
      return "sampled";
    case Classification::kPreintegrated:
      return "pre-integrated";
    case Classification::kRefined:
      return "refined";
  }
  return "";
}

void between(const std::string& folder) {
  const std::vector<BetweenSheets> rows = measure_between_sheets(64, 256);
  fmt::print(
      "| look | classification | sheets per spacing | dB to 16 sheets | processor time |\n"
      "|---|---|---|---|---|\n");
  std::vector<Image> images;
  for (const BetweenSheets& row : rows) {
    const bool is_fine = row.cpu_ms == 0;
    if (row.look == "layers" && (row.sheets_per_spacing == 1.0 || is_fine))
      images.push_back(row.image);
    if (is_fine) continue;
    // Times are relative to samples at one sheet per spacing.
    const auto plain = std::find_if(rows.begin(), rows.end(), [&](const BetweenSheets& other) {
      return other.look == row.look && other.classification == Classification::kSampled &&
             other.sheets_per_spacing == 1.0;
    });
    fmt::print("| {} | {} | {} | {:.1f} | {:.2f} |\n", row.look, name_of(row.classification),
               row.sheets_per_spacing, row.psnr_db, row.cpu_ms / plain->cpu_ms);
  }
  write_figure(side_by_side(images), folder + "/between-sheets.png");
}

std::vector<std::string> split_at_colons(std::string text) {
  std::vector<std::string> parts;
  while (!text.empty()) {
    const auto end = std::min(text.find(':'), text.size());
    parts.push_back(text.substr(0, end));
    text.erase(0, end + 1);
  }
  return parts;
}

// The files that OVOID_EXPERIMENT_FILES names, with colons between; none: formulas.
std::vector<Dataset> removed_data() {
  const char* files = std::getenv("OVOID_EXPERIMENT_FILES");
  if (files == nullptr)
    return {make_sample("head", {.size = {128, 128, 128}}),
            make_sample("tornado", {.size = {96, 96, 96}})};
  std::vector<Dataset> data;
  for (const std::string& name : split_at_colons(files)) data.push_back(read_dataset({name}));
  return data;
}

void removed(const std::string&) {
  const std::vector<FieldWay> ways = field_ways();
  std::string head = "| dB |";
  std::string line = "|---|";
  for (const FieldWay& way : ways) {
    head += fmt::format(" {} |", way.name);
    line += "---|";
  }
  fmt::print("{}\n{}\n", head, line);
  const auto print = [](const std::string& name, const std::vector<double>& decibels) {
    std::string row = fmt::format("| {} |", name);
    for (const double db : decibels) row += fmt::format(" {:.1f} |", db);
    fmt::print("{}\n", row);
    std::fflush(stdout);
  };
  for (const Dataset& dataset : removed_data()) {
    const RemovedErrors errors = measure_removed(dataset, ways, 20000);
    const std::string name = dataset.source.substr(dataset.source.rfind('/') + 1);
    print(name, errors.as_they_are);
    print(name + ", half-band", errors.band_limited);
  }
}

void unity_of_sites() {
  fmt::print(
      "| sites | shapes | ellipsoids | axis ratio, median | 95 % | greatest | sum of f = 1, mean | "
      "deviation | after 3 passes | deviation | after 10 | deviation |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Sites& sites : {jittered_sites(20, 0.4, 1), c_grid_sites()}) {
    for (const SiteShape shape : kSiteShapes) {
      const SiteKernels kernels = kernels_of_sites(sites, shape);
      const std::vector<double>& ratios = kernels.ratios;
      fmt::print("| {} | {} | {:.1f} % | {:.1f} | {:.1f} | {:.0f} |", sites.name, name_of(shape),
                 100 * kernels.ellipsoid_share, ratios[ratios.size() / 2],
                 ratios[ratios.size() * 19 / 20], ratios.back());
      for (const int passes : {0, 3, 10}) {
        const Unity unity = measure_unity(sites, with_passes(kernels, passes));
        fmt::print(" {:.3f} | {:.1f} % |", unity.mean, 100 * unity.deviation);
      }
      fmt::print("\n");
    }
  }
}

void errors_of_sites(const std::vector<TestField>& fields) {
  fmt::print(
      "\n| field | sites | shapes | raw sum | normalized (Shepard) | fitted sum | fitted, "
      "normalized |\n|---|---|---|---|---|---|---|\n");
  for (const TestField& field : fields) {
    for (const SiteShape shape :
         {SiteShape::kPca, SiteShape::kRidge, SiteShape::kScaledPca, SiteShape::kScaledRidge}) {
      const SiteErrors errors = measure_site_errors(field, shape);
      fmt::print("| {} | {}^3 | {} | {:.2f} % | {:.2f} % | {:.2f} % | {:.2f} % |\n", field.name,
                 field.side, name_of(shape), 100 * errors.raw, 100 * errors.normalized,
                 100 * errors.fitted_sum, 100 * errors.fitted);
    }
  }
}

void convergence_of_sites(const std::vector<TestField>& fields) {
  constexpr int kSteps = 24, kShown[] = {0, 1, 2, 4, 8, 16, 24};
  fmt::print("\n| field | centres | first values |");
  for (const int step : kShown) fmt::print(" {} |", step);
  fmt::print(" steps to 0.1 dB |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const TestField& field : fields) {
    for (const Centers centers : {Centers::kMoved, Centers::kMerged}) {
      for (const FirstValues first :
           {FirstValues::kMean, FirstValues::kNormalized, FirstValues::kSibson}) {
        const Convergence found = measure_convergence(field, centers, first, kSteps);
        fmt::print("| {} | {} | {} |", field.name, name_of(centers), name_of(first));
        for (const int step : kShown)
          fmt::print(" {:.2f} % |", 100 * found.errors[static_cast<std::size_t>(step)]);
        fmt::print(" {} |\n", found.steps);
      }
    }
  }
}

void sites(const std::string&) {
  const std::vector<TestField> fields = {franke_field(20), marschner_lobb_field(40)};
  unity_of_sites();
  errors_of_sites(fields);
  convergence_of_sites(fields);
}

// A mesh by formula, and the files that OVOID_EXPERIMENT_FILES names, which are one dataset here.
void adam(const std::string&) {
  std::vector<std::pair<std::string, Dataset>> data = {{"fin", make_sample("fin")}};
  if (const char* files = std::getenv("OVOID_EXPERIMENT_FILES")) {
    const std::vector<std::string> names = split_at_colons(files);
    data.emplace_back(names.back().substr(names.back().rfind('/') + 1), read_dataset(names));
  }
  fmt::print("| data | kernels | way | steps | time, s | PSNR, dB |\n|---|---|---|---|---|---|\n");
  for (const auto& [name, dataset] : data) {
    const RefineComparison found = compare_refinement(dataset, {});
    fmt::print("| {} | {} | clusters | 0 | 0 | {:.1f} |\n", name, found.kernels, found.start);
    for (const RefineCurve& curve : found.curves) {
      for (const RefineCurve::Point& point : curve.points) {
        fmt::print("| {} | {} | {} | {} | {:.1f} | {:.1f} |\n", name, found.kernels, curve.way,
                   point.steps, point.seconds, point.psnr);
      }
    }
    std::fflush(stdout);
  }
}

struct Experiment {
  const char* name;
  void (*run)(const std::string& folder);
};
constexpr Experiment kExperiments[] = {
    {"kernels", &kernels}, {"cost", &kernel_cost}, {"pictures", &pictures}, {"grid", &grid},
    {"removed", &removed}, {"popping", &popping},  {"edges", &edges},       {"between", &between},
    {"sites", &sites},     {"adam", &adam}};

int run(const std::vector<std::string>& arguments) {
  const auto is_known = [](const std::string& name) {
    return std::any_of(std::begin(kExperiments), std::end(kExperiments),
                       [&](const Experiment& experiment) { return name == experiment.name; });
  };
  if (arguments.empty() || !std::all_of(arguments.begin() + 1, arguments.end(), is_known)) {
    fmt::print(stderr, "usage: ovoid_experiments FOLDER [NAME...], NAME one of:");
    for (const Experiment& experiment : kExperiments) fmt::print(stderr, " {}", experiment.name);
    fmt::print(stderr, "\n");
    return 2;
  }
  for (const Experiment& experiment : kExperiments) {
    const bool is_wanted =
        arguments.size() == 1 ||
        std::find(arguments.begin() + 1, arguments.end(), experiment.name) != arguments.end();
    if (!is_wanted) continue;
    fmt::print("\n## {}\n\n", experiment.name);
    experiment.run(arguments.front());
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace ovoid::experiments

int main(int argc, char** argv) {
  try {
    return ovoid::experiments::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "ovoid_experiments: {}\n", error.what());
    return 1;
  }
}
