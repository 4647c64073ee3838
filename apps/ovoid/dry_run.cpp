// SPDX-License-Identifier: Apache-2.0
#include "dry_run.h"

#include <fmt/format.h>

#include <algorithm>

#include "profile.h"

namespace ovoid::cli {
namespace {

// Fewer pixels tell too little about a picture.
constexpr int kLeastSide = 96;

RenderOptions resized(RenderOptions options, int width_divisor, int height_divisor) {
  const auto divided = [](int side, int divisor) {
    return std::max(side / divisor, std::min(side, kLeastSide));
  };
  options.width = divided(options.width, width_divisor);
  options.height = divided(options.height, height_divisor);
  return options;
}

double num_pixels(const RenderOptions& options) {
  return static_cast<double>(options.width) * options.height;
}

// Per pixel, and per sample of a base plane, four colour floats and two depths while it is drawn;
// then the file's own form, before it is compressed, and what is worked out for it, when the base
// plane is gone: of .exr nine channels, three of them normals.
double picture_bytes(const DryRun& run, double num_base_samples = 0) {
  constexpr double kDrawn = 24;
  const double written = is_for_eyes(run.output) ? 4 : has_ending(run.output, ".exr") ? 48 : 0;
  const double num = num_pixels(run.options);
  return kDrawn * num + std::max(written * num, kDrawn * num_base_samples);
}

// What a frame keeps of a kernel set: a splat for each kernel, and lists of those that each block
// adds, whose length is that of the strip's.
double splat_bytes(const DryRun& run, const FrameProfile& profile, const FrameProfile& strip,
                   double strip_pixels) {
  constexpr double kSplat = 64;
  constexpr double kListed = 4;
  if (run.scene.volumes.front().field.kernels() == nullptr) return 0;
  return kSplat * static_cast<double>(profile.kernels_drawn) +
         kListed * static_cast<double>(strip.kernels_loaded) * num_pixels(run.options) /
             strip_pixels;
}

std::string readable_count(double count) {
  if (count < 1e4) return fmt::format("{:.0f}", count);
  if (count < 1e6) return fmt::format("{:.0f} thousand", count / 1e3);
  return fmt::format("{:.{}f} million", count / 1e6, count < 1e7 ? 1 : 0);
}

std::string readable_time(double ms) {
  if (ms < 1000) return fmt::format("{:.0f} ms", ms);
  if (ms < 120'000) return fmt::format("{:.1f} s", ms / 1000);
  return fmt::format("{:.0f} min", ms / 60'000);
}

// Surfaces and points cost as much as they have parts and a few pixels: they are drawn, and
// forgotten.
std::string predict_by_drawing(const DryRun& run) {
  const Volume& volume = run.scene.volumes.front();
  const double resident = static_cast<double>(resident_memory_bytes());
  Renderer renderer(run.setup);
  const FrameProfile profile = renderer.render(run.scene, run.camera, run.options, {}).profile;
  const double peak =
      std::max(static_cast<double>(peak_memory_bytes()), resident + picture_bytes(run));
  const std::string what =
      volume.points
          ? readable_count(static_cast<double>(volume.field.num_kernels())) + " points"
          : readable_count(static_cast<double>(volume.boundary->triangles.size())) + " triangles";
  return fmt::format(
      "{:<26}{} x {} pixels{}{}\n{:<26}{}\n{:<26}about {} (cpu, {} thread{})\n{:<26}about {}\n",
      "picture", run.options.width, run.options.height, run.output.empty() ? "" : ", ",
      one_line(run.output), volume.points ? "points" : "surface", what, "time of a frame",
      readable_time(profile.frame_ms), profile.threads, profile.threads == 1 ? "" : "s",
      "greatest memory", readable_bytes(peak));
}

}  // namespace

std::string predict(const DryRun& run, Session& session) {
  const Volume& volume = run.scene.volumes.front();
  if (shows_boundary_alone(run.scene) || volume.points) return predict_by_drawing(run);
  const double resident = static_cast<double>(resident_memory_bytes());
  const RenderOptions small = resized(run.options, 4, 4);
  // A camera's picture keeps its scale when it gets narrower.
  const RenderOptions strip = resized(run.options, 8, 1);
  const double ratio = num_pixels(run.options) / num_pixels(small);
  Renderer renderer(run.setup);
  RenderHooks hooks;
  hooks.stop = session.stop();
  Progress progress("measuring");
  hooks.progress = progress.callback();
  const FrameProfile profile = renderer.render(run.scene, run.camera, small, hooks).profile;

  hooks.progress = nullptr;
  const FrameProfile timed = renderer.render(run.scene, run.camera, strip, hooks).profile;
  const double num_samples = ratio * static_cast<double>(profile.samples_reconstructed);
  const double ms_per_sample =
      timed.frame_ms / std::max(1.0, static_cast<double>(timed.samples_reconstructed));

  std::string out;
  const auto row = [&out](const char* name, const std::string& value) {
    out += fmt::format("{:<26}{}\n", name, value);
  };
  row("picture", fmt::format("{} x {} pixels{}{}", run.options.width, run.options.height,
                             run.output.empty() ? "" : ", ", one_line(run.output)));
  row("kernels", fmt::format("{}, {} of them where something can show",
                             readable_count(static_cast<double>(profile.kernels_total)),
                             readable_count(static_cast<double>(profile.kernels_drawn))));
  row("memory of the field", readable_bytes(static_cast<double>(volume.field.resident_bytes())));
  row("sampling distance",
      fmt::format("{:.6g}", sheet_distance(volume.field, volume.look, run.options)));
  row("samples",
      fmt::format("about {} reconstructed, {} of them visible", readable_count(num_samples),
                  readable_count(ratio * static_cast<double>(profile.samples_shaded))));
  row("time of a frame",
      fmt::format("about {} ({}{}{}, {} thread{})", readable_time(num_samples * ms_per_sample),
                  profile.backend, profile.simd_target.empty() ? "" : ", ", profile.simd_target,
                  profile.threads, profile.threads == 1 ? "" : "s"));
  const double peak =
      std::max(static_cast<double>(peak_memory_bytes()),
               resident + picture_bytes(run, ratio * static_cast<double>(profile.base_samples)) +
                   splat_bytes(run, profile, timed, num_pixels(strip)));
  row("greatest memory", fmt::format("about {}", readable_bytes(peak)));
  return out;
}

}  // namespace ovoid::cli
