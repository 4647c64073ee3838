// SPDX-License-Identifier: Apache-2.0
#include "render_flags.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "session.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

const Names<Slab> kSlabs = {{"auto", Slab::kAuto}, {"mid", Slab::kMid}, {"mean", Slab::kMean}};
const Names<GradientMethod> kGradients = {{"auto", GradientMethod::kAuto},
                                          {"corrected", GradientMethod::kCorrected},
                                          {"exact", GradientMethod::kExact},
                                          {"central", GradientMethod::kCentral}};
const Names<Classification> kClassifications = {{"sampled", Classification::kSampled},
                                                {"pre-integrated", Classification::kPreintegrated}};
const Names<Evaluate> kEvaluates = {
    {"auto", Evaluate::kAuto}, {"gather", Evaluate::kGather}, {"scatter", Evaluate::kScatter}};
const Names<PostConvolution> kPostConvolutions = {{"off", PostConvolution::kOff},
                                                  {"bilinear", PostConvolution::kBilinear},
                                                  {"gaussian", PostConvolution::kGaussian},
                                                  {"cubic", PostConvolution::kCubic},
                                                  {"auto", PostConvolution::kAuto}};
const Names<ovoid::Spread> kSpreads = {{"gaussian", ovoid::Spread::kGaussian},
                                       {"bilinear", ovoid::Spread::kBilinear}};
const Names<Backend> kBackends = {{"auto", Backend::kAuto},
                                  {"cpu", Backend::kCpu},
                                  {"vulkan", Backend::kVulkan},
                                  {"reference", Backend::kReference}};
const Names<SheetPrecision> kSheetPrecisions = {{"fp32", SheetPrecision::kSingle},
                                                {"fp16", SheetPrecision::kHalf}};

constexpr int kMaxThreads = 1024;
constexpr int kMaxDevices = 1023;

// A flag that takes one name of a table, with its default named in the help.
template <typename T>
void choice(Flags& flags, const char* name, const Names<T>& names, const char* text, T* into) {
  flags.value(name, joined(names), fmt::format("{} (default {})", text, name_in(names, *into)),
              [into, &names](const std::string& given) { *into = parse_name(given, names); });
}

// The flag for a choice, none for the default.
template <typename T>
void tell_choice(FlagSet* flags, const char* flag, const Names<T>& names, T value, T usual) {
  flags->erase(flag);
  if (value != usual) flags->set(flag, name_in(names, value));
}

void tell_toggle(FlagSet* flags, const char* flag, bool is_set) {
  flags->erase(flag);
  if (is_set) flags->set(flag, true);
}

ClipPlane parse_clip(const std::string& text) {
  const std::vector<double> numbers = parse_numbers(text, 4);
  ClipPlane plane{{numbers[0], numbers[1], numbers[2]}, numbers[3]};
  if (plane.normal.norm() == 0)
    throw BadValue("expected NX,NY,NZ,D with a normal other than 0,0,0");
  return plane;
}

}  // namespace

void add_number_flags(Flags& flags, RenderOptions* options) {
  flags.section("numbers");
  flags.value("--sampling-distance", "D",
              "distance of sheets, world (default: a lattice's smallest spacing, else twice the "
              "sigma of a small kernel)",
              [options](const std::string& text) {
                options->sampling_distance = parse_number(text, {.lo = 0, .lo_open = true});
              });
  choice(flags, "--slab", kSlabs,
         "a sample is the field in the middle of its slab, or its mean there", &options->slab);
  choice(flags, "--gradient", kGradients,
         "the kernels' derivative, constant on ramps or as it is, or differences of samples",
         &options->gradient);
  choice(flags, "--classification", kClassifications,
         "colour and opacity of a sample, or of the piece from the sheet before it",
         &options->classification);
  choice(flags, "--evaluate", kEvaluates, "samples gather kernels, or kernels scatter to samples",
         &options->evaluate);
  choice(flags, "--post-convolution", kPostConvolutions,
         "magnified sheets are sampled at nodes, large kernels of a set on coarser levels; the "
         "three by name are published ways that blur",
         &options->post_convolution);
  choice(
      flags, "--sheet-precision", kSheetPrecisions,
      "of a kernel set's sheets, backend vulkan: fp16 is half the memory, where none would see it",
      &options->sheet_precision);
  choice(flags, "--spread", kSpreads,
         "samples add to nodes by their kernel, or in the published ways to the four around",
         &options->spread);
  flags.repeatable(
      "--clip", "NX,NY,NZ,D", "keep points with n.x >= D, world (repeatable)",
      [options](const std::string& text) {
        if (options->clip_planes.size() == RenderOptions::kMaxClipPlanes) {
          throw BadValue(fmt::format("expected at most {} planes", RenderOptions::kMaxClipPlanes));
        }
        options->clip_planes.push_back(parse_clip(text));
      });
}

void add_plane_flag(Flags& flags, std::optional<ValuePlane>* plane) {
  flags.value("--value-plane", "NX,NY,NZ,D[,shown]",
              "an opaque plane n.x = D, world, with the field's own colours; what is before it is "
              "cut away, or shown",
              [plane](const std::string& text) {
                constexpr const char* kShown = ",shown";
                const bool is_shown = has_ending(text, kShown);
                const auto numbers = text.size() - (is_shown ? std::strlen(kShown) : 0);
                const ClipPlane parsed = parse_clip(text.substr(0, numbers));
                *plane = ValuePlane{parsed.normal, parsed.offset,
                                    is_shown ? PlaneFront::kShown : PlaneFront::kRemoved};
              });
}

void add_run_flags(Flags& flags, RendererSetup* run) {
  flags.section("running");
  flags.value("--backend", joined(kBackends),
              fmt::format("what draws (default {})", name_in(kBackends, run->backend)),
              [run](const std::string& text) { run->backend = parse_name(text, kBackends); });
  flags.value("--threads", "N", "(default 0: one per hardware thread)",
              [run](const std::string& text) {
                run->threads = static_cast<int>(parse_integer(text, 0, kMaxThreads));
              });
  flags.value("--device", "N",
              "of the devices that 'ovoid info --devices' lists (default: the first GPU)",
              [run](const std::string& text) {
                run->device = static_cast<int>(parse_integer(text, 0, kMaxDevices));
              });
  flags.value("--device-memory", "SIZE",
              "of the device for data; more is drawn piece by piece (default: most of it)",
              [run](const std::string& text) {
                run->device_memory = static_cast<std::uint64_t>(parse_bytes(text));
              });
}

void add_switch_flags(Flags& flags, RenderOptions* options) {
  flags.toggle("--no-skip", "reconstruct also what cannot be seen (slower, same picture)",
               &options->skip_irrelevant, false);
  flags.toggle("--no-stop", "work also on what is behind the opaque (slower, same picture)",
               &options->stop_opaque, false);
  flags.toggle("--no-pack",
               "backend vulkan: sum a set's kernels on one sheet at a time (slower, same picture)",
               &options->pack_sheets, false);
}

void tell_numbers(const RenderOptions& options, FlagSet* flags) {
  const RenderOptions usual;
  flags->erase("sampling-distance");
  if (options.sampling_distance > 0)
    flags->set("sampling-distance", fmt::format("{}", options.sampling_distance));
  tell_choice(flags, "slab", kSlabs, options.slab, usual.slab);
  tell_choice(flags, "gradient", kGradients, options.gradient, usual.gradient);
  tell_choice(flags, "classification", kClassifications, options.classification,
              usual.classification);
  tell_choice(flags, "evaluate", kEvaluates, options.evaluate, usual.evaluate);
  tell_choice(flags, "post-convolution", kPostConvolutions, options.post_convolution,
              usual.post_convolution);
  tell_choice(flags, "sheet-precision", kSheetPrecisions, options.sheet_precision,
              usual.sheet_precision);
  tell_choice(flags, "spread", kSpreads, options.spread, usual.spread);
  flags->erase("clip");
  nlohmann::ordered_json planes = nlohmann::ordered_json::array();
  for (const ClipPlane& plane : options.clip_planes) {
    planes.push_back(fmt::format("{},{},{},{}", plane.normal.x(), plane.normal.y(),
                                 plane.normal.z(), plane.offset));
  }
  if (!planes.empty()) flags->set("clip", planes);
  tell_toggle(flags, "no-skip", !options.skip_irrelevant);
  tell_toggle(flags, "no-stop", !options.stop_opaque);
  tell_toggle(flags, "no-pack", !options.pack_sheets);
}

void tell_plane(const std::optional<ValuePlane>& plane, FlagSet* flags) {
  flags->erase("value-plane");
  if (!plane) return;
  const Vec3& n = plane->normal;
  flags->set("value-plane", fmt::format("{},{},{},{}{}", n.x(), n.y(), n.z(), plane->offset,
                                        plane->front == PlaneFront::kShown ? ",shown" : ""));
}

void tell_run(const RendererSetup& run, FlagSet* flags) {
  tell_choice(flags, "backend", kBackends, run.backend, RendererSetup{}.backend);
  for (const char* const flag : {"threads", "device", "device-memory"}) flags->erase(flag);
  if (run.threads > 0) flags->set("threads", fmt::format("{}", run.threads));
  const bool is_on_device = run.backend == Backend::kAuto || run.backend == Backend::kVulkan;
  if (run.device >= 0 && is_on_device) flags->set("device", fmt::format("{}", run.device));
  if (run.device_memory > 0) flags->set("device-memory", fmt::format("{}", run.device_memory));
}

}  // namespace ovoid::cli
