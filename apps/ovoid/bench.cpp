// SPDX-License-Identifier: Apache-2.0
// ovoid bench: time the stages on standard scenes. Every picture is checked before it is timed.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "command.h"
#include "console.h"
#include "environment.h"
#include "make_field.h"
#include "profile.h"
#include "scenes.h"
#include "settings.h"
#include "suggest.h"
#include "usage.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMinFrames = 10;  // fewer make no quartiles
constexpr int kMaxFrames = 10'000;

struct BenchFlags {
  std::vector<std::string> names;
  int frames = kMinFrames;
  bool is_json = false;
  bool lists = false;
  ModelFlags model;
  RenderOptions options;
  RendererSetup run = setup_of_environment();
};

const Table<BenchFlags>& bench_settings() {
  using B = BenchFlags;
  static const Table<B> all = {
      {"--json", Toggle(), &B::is_json, "results as JSON on standard output"},
      {"--list", Toggle(), &B::lists, "names of the scenes"},
      {"--frames", integer("N", kMinFrames, kMaxFrames), &B::frames,
       fmt::format("frames per scene, at least {} (default {})", kMinFrames, B{}.frames)},
  };
  return all;
}

struct SceneResult {
  BenchScene scene;
  double model_ms = 0;
  Quartiles frame_ms;
  FrameProfile profile;  // of one more frame, with stage times
};

// The scenes whose name contains one of `names`, in the standard order; all, if there are none.
std::vector<BenchScene> select_scenes(const std::vector<std::string>& names) {
  std::vector<BenchScene> all = standard_scenes();
  if (names.empty()) return all;
  std::vector<std::string> known;
  known.reserve(all.size());
  for (const BenchScene& scene : all) known.push_back(scene.name());
  const auto matches = [](const std::string& scene, const std::string& name) {
    return scene.find(name) != std::string::npos;
  };
  std::vector<BenchScene> selected;
  for (const std::string& name : names) {
    if (const std::optional<BenchScene> own = scene_named(name)) {
      selected.push_back(*own);
      continue;
    }
    if (std::none_of(known.begin(), known.end(),
                     [&](const std::string& scene) { return matches(scene, name); })) {
      throw UsageError(fmt::format(
          "SCENE '{}': expected a scene's name or a part of it{} (see ovoid bench --list), or "
          "VOLUME-SAMPLES-WIDTHxHEIGHT-LOOK",
          name, did_you_mean(name, known)));
    }
  }
  for (const BenchScene& scene : all) {
    if (std::any_of(names.begin(), names.end(),
                    [&](const std::string& name) { return matches(scene.name(), name); })) {
      selected.push_back(scene);
    }
  }
  return selected;
}

// A picture that is wrong must not be timed. Throws what is wrong with it.
void check_picture(const Image& image, const std::string& scene) {
  const bool is_finite =
      std::all_of(image.rgba.begin(), image.rgba.end(), [](float v) { return std::isfinite(v); });
  std::size_t covered = 0;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) covered += image.rgba[i] > 0 ? 1 : 0;
  if (is_finite && covered > 0) return;
  throw std::runtime_error(
      fmt::format("scene {}: the picture {}", scene, is_finite ? "is empty" : "is not finite"));
}

// The volume of a scene and what it took to model it; made once for the scenes that share it.
struct BenchVolume {
  std::string name;
  Field field;
  Camera camera;
  double model_ms = 0;
};

Dataset make_data(const BenchScene& scene) {
  const std::int64_t n = scene.samples;
  if (!scene.is_lattice) return make_sample(scene.volume, {.count = n});
  return make_sample(scene.volume, {.size = {n, n, n}, .type = ScalarType::kUInt8});
}

BenchVolume make_volume(const BenchScene& scene, const BenchFlags& bench, Session& session) {
  const Dataset dataset = make_data(scene);
  BenchVolume volume;
  volume.name = scene.volume_name();
  const Stopwatch modelling;
  volume.field = make_field(dataset, bench.model, bench.run.threads, session).field;
  volume.model_ms = modelling.ms();
  volume.camera = default_camera(volume.field.world_bounds(), dataset.space);
  volume.camera.azimuth(kSceneAzimuth);
  volume.camera.elevation(kSceneElevation);
  return volume;
}

SceneResult measure(const BenchScene& scene, const BenchVolume& volume, const BenchFlags& bench,
                    Renderer& renderer, const Session& session) {
  RenderOptions options = bench.options;
  options.width = scene.width;
  options.height = scene.height;
  const Look look = make_scene_look(scene.look, volume.field.value_range());
  RenderHooks hooks;
  hooks.stop = session.stop();
  const auto draw = [&](const Camera& camera) {
    return renderer.render({volume.field, look}, camera, options, hooks);
  };
  Camera middle = volume.camera;
  middle.zoom(scene.magnification);
  check_picture(draw(middle).image, scene.name());  // also the frame to warm up

  SceneResult result;
  result.scene = scene;
  result.model_ms = volume.model_ms;
  std::vector<double> frames_ms;
  for (int i = 0; i < bench.frames; ++i) {
    Camera turned = middle;
    turned.azimuth(kTurnDegrees * i);
    frames_ms.push_back(draw(turned).profile.frame_ms);
  }
  result.frame_ms = quartiles(frames_ms);
  options.collect_profile = true;
  result.profile = draw(middle).profile;
  return result;
}

// Samples per second of reconstruct-stage time and thread; 0 where the back end has no such stage.
double reconstructed_per_second(const FrameProfile& frame) {
  for (const auto& [stage, ms] : frame.stages_ms) {
    if (stage == "reconstruct" && ms > 0)
      return static_cast<double>(frame.samples_reconstructed) / ms * 1e3;
  }
  return 0;
}

Json to_json(const SceneResult& result) {
  const Quartiles& time = result.frame_ms;
  Json json;
  json["name"] = result.scene.name();
  json["volume"] = result.scene.volume;
  json["kind"] = result.scene.is_lattice ? "lattice" : "kernels";
  json[result.scene.is_lattice ? "samples_per_axis" : "count"] = result.scene.samples;
  json["size"] = {result.scene.width, result.scene.height};
  json["magnification"] = result.scene.magnification;
  json["model_ms"] = result.model_ms;
  json["frame_ms"] = {{"median", time.median},
                      {"q1", time.q1},
                      {"q3", time.q3},
                      {"min", time.min},
                      {"max", time.max}};
  json["stages_ms"] = stages_json(result.profile);
  json["samples_reconstructed_per_second"] = reconstructed_per_second(result.profile);
  json.update(counts_json(result.profile));
  return json;
}

// The processor's name as the system tells it; empty if it does not.
std::string cpu_name() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    const std::size_t colon = line.find(':');
    return colon == std::string::npos ? "" : line.substr(std::min(colon + 2, line.size()));
  }
  return "";
}

Json run_json(const FrameProfile& profile, int frames, const std::string& command) {
  Json json;
  json["command"] = command;
  json["version"] = OVOID_VERSION;
  json["compiler"] = __VERSION__;
  json["cpu"] = cpu_name();
  json["backend"] = profile.backend;
  json["device"] = profile.device;
  json["simd_target"] = profile.simd_target;
  json["threads"] = profile.threads;
  json["frames"] = frames;
  return json;
}

void print_row(const SceneResult& result) {
  const FrameProfile& frame = result.profile;
  print_out("{:<34}{:>9.1f}{:>9.1f}{:>9.1f}{:>10.1f}{:>10.2f}\n", result.scene.name(),
            result.frame_ms.median, result.frame_ms.q1, result.frame_ms.q3,
            reconstructed_per_second(frame) / 1e6, static_cast<double>(frame.samples_shaded) / 1e6);
  std::string stages;
  for (const auto& [stage, ms] : frame.stages_ms) stages += fmt::format("  {} {:.1f}", stage, ms);
  if (!stages.empty()) print_out("  {}\n", stages);
  flush_out();
}

void print_heading(const FrameProfile& frame, int frames) {
  print_out("{} {}, {} threads, {} frames each, {}\n\n", frame.backend,
            frame.device.empty() ? frame.simd_target : frame.device, frame.threads, frames,
            cpu_name());
  print_out("{:<34}{:>9}{:>9}{:>9}{:>10}{:>10}\n", "scene", "median ms", "q1", "q3", "Msample/s",
            "M shaded");
}

void measure_all(const BenchFlags& bench, Session& session) {
  Renderer renderer(bench.run);
  Json report;
  BenchVolume volume;
  for (const BenchScene& scene : select_scenes(bench.names)) {
    if (volume.name != scene.volume_name()) {
      volume = {};  // before the next one is made
      volume = make_volume(scene, bench, session);
    }
    const SceneResult result = measure(scene, volume, bench, renderer, session);
    if (report.empty()) {
      report = run_json(result.profile, bench.frames, session.command_line());
      if (!bench.is_json) print_heading(result.profile, bench.frames);
    }
    report["scenes"].push_back(to_json(result));
    if (!bench.is_json) print_row(result);
  }
  report["peak_memory_bytes"] = peak_memory_bytes();
  if (bench.is_json) print_out("{}\n", report.dump(2, ' ', false, Json::error_handler_t::replace));
}

}  // namespace

void run_bench(const Words& words, Session& session) {
  BenchFlags bench;
  Flags flags(
      "bench", "[SCENE...] [FLAG...]",
      "Times the stages on standard scenes: volumes (uint8), a mesh, particles and kernels by "
      "formula, semi-transparent (soft) and opaque, at two picture sizes. Flags of the model act "
      "on the scenes that they are for. Each scene is drawn once to check it, then timed.");
  flags.section("");
  flags.positionals(
      "SCENE",
      "names, or parts of names: head-256, 512px, opaque (default: all); or one of your "
      "own: head-512-1920x1080-soft, -x4 behind it for a view 4 times nearer",
      &bench.names);
  flags.add(bench_settings(), &bench);
  add_kernel_flags(flags, &bench.model);
  flags.section("numbers");
  flags.add(number_settings(), &bench.options);
  flags.section("running");
  flags.add(run_settings(), &bench.run);
  flags.add(switch_settings(), &bench.options);
  if (!flags.parse(words)) return;
  if (bench.lists) {
    for (const BenchScene& scene : select_scenes(bench.names)) print_out("{}\n", scene.name());
    return;
  }
  measure_all(bench, session);
}

}  // namespace ovoid::cli
