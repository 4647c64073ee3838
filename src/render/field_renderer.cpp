// SPDX-License-Identifier: Apache-2.0
#include "render/field_renderer.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <new>
#include <optional>

#include "data/validate.h"
#include "model/own_array.h"
#include "ovoid/error.h"
#include "ovoid/model.h"
#include "render/features.h"
#include "render/lattice_sheets.h"
#include "render/passes/added_pictures.h"
#include "render/reference/reference_renderer.h"
#include "view/look/isosurfaces.h"
#include "view/look/light.h"
#include "view/look/look_2d.h"
#include "view/plan/coverage.h"
#include "view/plan/space_part.h"

namespace ovoid {
namespace {

// Bilinear spread is a weighted mean of a lattice's samples. Throws Error(kUnsupported).
void require_spread(const Field& field, const RenderOptions& options) {
  if (options.spread == Spread::kGaussian) return;
  if (field.kernels() != nullptr)
    throw Error(ErrorCode::kUnsupported, "spread: bilinear is for lattices");
  if (field.lattice()->reconstruction() == Reconstruction::kSum)
    throw Error(ErrorCode::kUnsupported, "spread: bilinear is for normalized lattices, not sums");
}

// Throws Error(kUnsupported).
void require_central_differences(const RenderOptions& options) {
  if (options.gradient == GradientMethod::kAuto || options.gradient == GradientMethod::kCentral)
    return;
  throw Error(
      ErrorCode::kUnsupported,
      "gradient: kernel sets take central differences; exact and corrected are for lattices");
}

bool is_same_lattice(const LatticeGeometry& a, const LatticeGeometry& b) {
  return a.kind == b.kind && a.dims == b.dims &&
         a.world_from_index.matrix() == b.world_from_index.matrix();
}

// Throws Error unless a look's 2-D transfer function, if it has one, says all about the picture.
void require_2d(const Field& field, const Look& look, const RenderOptions& options) {
  if (!look.transfer_function_2d) return;
  const auto refuse = [](const char* why) {
    throw Error(ErrorCode::kUnsupported, std::string("2-D transfer function: ") + why);
  };
  if (look.mode != Mode::kComposite) refuse("is for the mode composite");
  if (options.classification == Classification::kPreintegrated)
    refuse("is for the classifications refined and sampled, not for pre-integrated");
  if (field.kernels() != nullptr && field.kernels()->has_own_color())
    refuse("gives colours itself, which an attribute of their own cannot give, too");
  if (look.occlusion > 0 || look.shadows > 0)
    refuse(
        "occlusion and shadows come from a coarse volume that knows no gradients; both must be 0");
}

// Throws Error(kInvalidArgument).
void require_moments(const KernelField& field, const Trail& trail) {
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::kInvalidArgument, "trail.moments" + what);
  };
  if (trail.moments.empty()) refuse(": are none, as the trail of a set of kernels has them");
  for (std::size_t i = 0; i < trail.moments.size(); ++i) {
    const auto& [moment, share] = trail.moments[i];
    const std::string which = fmt::format("[{}]", i);
    if (moment.is_empty()) refuse(which + ".field: has no kernels");
    if (!(share > 0) || !std::isfinite(share))
      refuse(fmt::format("{}.share = {}: must be finite and > 0", which, share));
    if (moment.reconstruction() != field.reconstruction())
      refuse(which + ".field: is summed in another way than the field");
    if (moment.has_own_color() != field.has_own_color())
      refuse(which + ".field: has its colours from another attribute than the field");
  }
  if (field.reconstruction() == Reconstruction::kSum && trail.moments.size() > 1)
    refuse(
        fmt::format(": are {}, must be one of a sum: a set of all their kernels, weights times "
                    "shares, as kernel_trail_before() makes it",
                    trail.moments.size()));
}

// Throws Error unless the trail can be drawn with the field.
void require_trail(const Field& field, const Look& look, const Trail& trail,
                   const RenderOptions& options) {
  if (look.mode != Mode::kComposite && look.mode != Mode::kIsosurface)
    throw Error(ErrorCode::kUnsupported, "trail: is for the modes composite and isosurface");
  if (look.transfer_function_2d)
    throw Error(ErrorCode::kUnsupported, "trail: is for looks without a 2-D transfer function");
  if (look.mode == Mode::kIsosurface && !look.isosurfaces.empty())
    throw Error(ErrorCode::kUnsupported, "trail: is for one isosurface, not for several");
  if (is_published(options.post_convolution))
    throw Error(ErrorCode::kUnsupported, "trail: is for post-convolution off and auto");
  if (options.part != nullptr)
    throw Error(ErrorCode::kUnsupported, "trail: is for whole pictures, not for parts");
  if (field.kernels() != nullptr) return require_moments(*field.kernels(), trail);
  if (options.depth_limits != nullptr)
    throw Error(ErrorCode::kUnsupported, "trail: is for pictures of lattices without depth limits");
  if (trail.field.is_empty() ||
      !is_same_lattice(trail.field.geometry(), field.lattice()->geometry()))
    throw Error(ErrorCode::kInvalidArgument, "trail.field: must be on the lattice of the field");
}

// What is seen of each ray is one sample of each volume, which has no place in a mixture.
bool shows_extremes(Mode mode) { return mode == Mode::kMaximum || mode == Mode::kMinimum; }

// Throws Error unless the volumes can be drawn with the field.
void require_further(const DrawnFields& fields, const RenderOptions& options) {
  const auto& [field, look, trail, volumes, mixing] = fields;
  if (volumes.empty()) return;
  const auto refuse = [](const std::string& why) {
    throw Error(ErrorCode::kUnsupported, "several volumes: " + why);
  };
  if (field.lattice() == nullptr) refuse("are for lattices, the field is a set of kernels");
  const bool is_composite = look.mode == Mode::kComposite;
  if (!is_composite && !shows_extremes(look.mode))
    refuse("are for the modes composite, maximum and minimum");
  const bool are_colors = mixing == Mixing::kColored;
  if (are_colors && !is_composite) refuse("that are colours are for the mode composite");
  if (trail != nullptr) refuse("are for pictures without a trail");
  if (is_published(options.post_convolution)) refuse("are for post-convolution off and auto");
  if (options.part != nullptr && !is_composite)
    refuse("in the modes maximum and minimum are for whole pictures, not for parts");
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    volumes[i].look.validate();
    if (volumes[i].look.mode != look.mode)
      refuse(fmt::format("volumes[{}].look has another mode than the picture", i + 1));
    if (are_colors && !is_same_lattice(volumes[i].field.geometry(), field.lattice()->geometry()))
      refuse(fmt::format("volumes[{}].field is on another lattice than what it colours", i + 1));
    require_2d(volumes[i].field, volumes[i].look, options);
    if (volumes[i].look.transfer_function_2d && (look.occlusion > 0 || look.shadows > 0)) {
      refuse(
          fmt::format("volumes[{}].look has a 2-D transfer function, so that occlusion and "
                      "shadows of the picture's look must be 0",
                      i + 1));
    }
  }
}

// Where a frame has a trail, samples are classified at their pixels, the trail's without pieces.
view::TrailView view_of(const Trail& trail, const Look& look, const RenderOptions& options) {
  view::TrailView view{&trail.field, trail.moments, {}, options};
  double sum = 0;
  for (const KernelMoment& moment : view.moments) sum += moment.share;
  for (KernelMoment& moment : view.moments) moment.share /= sum;
  view.look.color_function = look.color_function;
  view.look.transfer_function = trail.transfer_function;
  view.look.transfer_function.gradient_opacities.clear();
  view.look.shade = false;
  view.look.unit_distance = look.unit_distance;
  view.look.validate();
  view.options.classification = Classification::kSampled;
  view.options.depth_limits = nullptr;
  // A mean may show where no moment's own values do.
  if (view.moments.size() > 1) view.options.skip_irrelevant = false;
  return view;
}

// Of a back end that runs on none.
[[noreturn]] void refuse_device(const RendererSetup& setup) {
  throw Error(
      ErrorCode::kInvalidArgument,
      setup.backend == Backend::kAuto
          ? fmt::format("device = {}: there is none that backend auto would take: leave it "
                        "out to draw on the cpu, or name backend vulkan to hear why",
                        setup.device)
          : fmt::format("device = {}: is for backend vulkan, not {}: leave one of them out",
                        setup.device, setup.backend == Backend::kCpu ? "cpu" : "reference"));
}

using Clock = std::chrono::steady_clock;

// A look with what a frame takes for granted where it says nothing.
Look completed(Look look, const Field& field, const Camera& camera) {
  look.unit_distance = unit_distance_of(look, field);
  if (look.light == Light::kStudio && !look.light_direction)
    look.light_direction = view::studio_key(camera);
  look.isovalue = view::solid_isovalue(look);  // what light is worked out for
  return view::with_envelope(std::move(look));
}

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

void add_notice(FrameProfile& profile, const std::string& notice) {
  if (!profile.notice.empty()) profile.notice += "; ";
  profile.notice += notice;
}

// Where half sheets are asked for and nothing is kept that could be halved.
void note_on_precision(FrameProfile& profile, const FrameJob& job) {
  if (job.options.sheet_precision == SheetPrecision::kSingle) return;
  const bool is_device = profile.backend == "vulkan";
  if (!draws(is_device ? Backend::kVulkan : Backend::kCpu, Feature::kHalfSheets)) {
    add_notice(profile, fmt::format("sheet precision: floats; backend {} has no half sheets",
                                    profile.backend));
  } else if (job.field.lattice() != nullptr) {
    add_notice(profile, "sheet precision: floats; of lattices no sheets are kept");
  }
}

// Where there were fewer threads than wanted.
Frame with_note_on_threads(Frame frame, int wanted) {
  if (frame.profile.threads < wanted) {
    frame.profile.notice =
        fmt::format("threads: {} were wanted, the system grants {}", wanted, frame.profile.threads);
  }
  return frame;
}

Frame draw_on(BackEnd& chosen, const FrameJob& job, bool is_distance_free) {
  require_features(chosen.kind(), job);
  const std::optional<LatticeSheets> sheets = lattice_sheets_for(chosen, job, is_distance_free);
  if (!sheets) return chosen.draw(job);
  RenderOptions options = job.options;
  options.sampling_distance = sheets->sampling_distance;
  return chosen.draw({job.field, job.camera, job.look, job.trail, options, job.hooks, job.light,
                      &sheets->base, job.further, job.mixing});
}

class CpuBackEnd final : public BackEnd {
 public:
  explicit CpuBackEnd(const cpu::Machine& machine) : machine_(machine) {}
  Backend kind() const noexcept override { return Backend::kCpu; }

  Frame draw(const FrameJob& job) override {
    return with_note_on_threads(cpu::render(job, machine_), machine_.runner->num_wanted());
  }

 private:
  const cpu::Machine& machine_;
};

class ReferenceBackEnd final : public BackEnd {
 public:
  explicit ReferenceBackEnd(int num_threads) : num_threads_(num_threads) {}
  Backend kind() const noexcept override { return Backend::kReference; }

  Frame draw(const FrameJob& job) override {
    const int wanted = std::min(num_threads_, job.options.height);  // a thread has a row at least
    return with_note_on_threads(reference::render(job, wanted), wanted);
  }

 private:
  int num_threads_;
};

}  // namespace

FieldRenderer::FieldRenderer(const RendererSetup& setup) {
  if (setup.threads < 0) {
    throw Error(
        ErrorCode::kInvalidArgument,
        fmt::format("threads = {}: must be >= 1, or 0 for one per hardware thread", setup.threads));
  }
  if (setup.device < -1) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("device = {}: must be >= 0, or -1 for the first", setup.device));
  }
  Backend backend = setup.backend;
  if (backend == Backend::kAuto)
    backend = has_device_for_auto(setup) ? Backend::kVulkan : Backend::kCpu;
  if (setup.device >= 0 && backend != Backend::kVulkan) refuse_device(setup);
  if (backend == Backend::kVulkan) back_end_ = make_vulkan_back_end(setup);
  machine_ = {cpu::make_runner(setup.threads), simd::SimdTarget(setup.simd_target)};
  if (backend == Backend::kReference) back_end_ = std::make_unique<ReferenceBackEnd>(threads());
  if (backend == Backend::kCpu) back_end_ = std::make_unique<CpuBackEnd>(machine_);
  if (backend == Backend::kVulkan && setup.backend == Backend::kAuto)
    fallback_ = std::make_unique<CpuBackEnd>(machine_);
}

Frame FieldRenderer::draw(const DrawnFields& fields, const Camera& camera,
                          const RenderOptions& options, const RenderHooks& hooks,
                          const LightBlockers& blockers) try {
  const auto& [field, look, trail, all_further, mixing] = fields;
  data::require_field(field);
  camera.validate();
  look.validate();
  options.validate();
  require_spread(field, options);
  require_2d(field, look, options);
  if (trail != nullptr) require_trail(field, look, *trail, options);
  require_further(fields, options);
  if (shows_extremes(look.mode) && !all_further.empty())
    return draw_each(fields, camera, options, hooks);
  if (field.kernels() != nullptr) require_central_differences(options);
  const int level = trail == nullptr ? coarsest_level(field, camera, options) : 0;
  // Not for long there, if further volumes have levels, too.
  const Field drawn = levels_.at(field, level, threads(), hooks.stop);
  const Look own_look = completed(look, field, camera);
  const std::vector<FurtherVolume> further = further_to_draw(all_further, camera, options, hooks);
  RenderOptions own_options = options;
  own_options.sampling_distance = sheet_distance(drawn, look, options);
  for (const FurtherVolume& volume : further) {
    own_options.sampling_distance =
        std::min(own_options.sampling_distance, sheet_distance(volume.field, volume.look, options));
  }
  std::optional<view::TrailView> trail_view;
  if (trail != nullptr) {
    if (field.lattice() != nullptr) own_options.post_convolution = PostConvolution::kOff;
    trail_view = view_of(*trail, look, own_options);
  }
  PartSheets sheets;
  if (options.part != nullptr) {
    const view::ViewLattice lattice(camera, options.width, options.height,
                                    own_options.sampling_distance, LatticeGeometry{});
    sheets = view::sheets_of_part(*options.part, lattice);
    own_options.depth_limits = std::make_shared<DepthLimits>(
        view::limits_of_part(sheets, lattice, options.depth_limits.get()));
  }
  const Clock::time_point light_start = Clock::now();
  const SurfaceLight lit_by = light_of(
      {drawn, own_look, options.clip_planes, further, mixing, blockers.solid, blockers.geometry},
      hooks);
  const double light_ms = milliseconds_since(light_start);
  const FrameJob job{drawn,       camera, own_look,      trail_view ? &*trail_view : nullptr,
                     own_options, hooks,  lit_by.volume, nullptr,
                     further,     mixing};
  Frame frame = draw_by_choice(job, options.sampling_distance == 0);
  if (!lit_by.notice.empty()) add_notice(frame.profile, lit_by.notice);
  if (lit_by.volume != nullptr) {
    frame.profile.frame_ms += light_ms;
    if (options.collect_profile) frame.profile.stages_ms.emplace_back("light volume", light_ms);
  }
  std::span<const float> coverage;
  if (options.depth_limits != nullptr) coverage = options.depth_limits->coverage;
  if (options.part != nullptr) {
    frame.seen = view::runs_of_part(frame.image, look.mode, sheets, coverage);
  } else if (trail == nullptr || coverage.empty()) {
    view::apply_coverage(coverage, look.mode, frame.image);
  } else {
    view::blend_by_coverage(coverage, trail_alone(job, frame.profile), frame.image);
  }
  note_on_precision(frame.profile, job);
  return frame;
} catch (const std::bad_alloc&) {
  // What is large names itself.
  throw Error(ErrorCode::kOutOfMemory,
              fmt::format("a frame of {} x {} pixels: no memory for its plan", options.width,
                          options.height));
}

SurfaceLight FieldRenderer::light_for(const DrawnFields& fields, const LightBlockers& blockers,
                                      const Camera& camera, const RenderOptions& options,
                                      const RenderHooks& hooks) {
  const Field& field = fields.field;
  const Look own_look = completed(fields.look, field, camera);
  if (blockers.geometry.empty())
    return light_of({field, own_look, options.clip_planes, {}, {}, blockers.solid}, hooks);
  require_further(fields, options);
  const Field drawn =
      levels_.at(field, coarsest_level(field, camera, options), threads(), hooks.stop);
  const std::vector<FurtherVolume> further =
      further_to_draw(fields.further, camera, options, hooks);
  return light_of({drawn, own_look, options.clip_planes, further, fields.mixing, blockers.solid,
                   blockers.geometry},
                  hooks);
}

const LatticeField& FieldRenderer::nothing_in(const Bounds3& bounds) {
  const auto is_kept = [&] {
    return nothing_ && nothing_->first.min() == bounds.min() &&
           nothing_->first.max() == bounds.max();
  };
  if (is_kept()) return nothing_->second;
  constexpr double kSamples = 192;  // along the longest side; four of them are a cell of light
  constexpr double kFlat = 1e-3;    // of the diagonal, so that a plane has room around it
  const double least = std::max(kFlat * bounds.diagonal().norm(), 1e-30);
  const Vec3 sides = bounds.sizes().cwiseMax(least);
  const double spacing = sides.maxCoeff() / kSamples;
  Dataset dataset;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double samples = std::ceil(sides[static_cast<int>(axis)] / spacing);
    dataset.lattice.dims[axis] = std::max<std::int64_t>(2, static_cast<std::int64_t>(samples));
  }
  const Index3& dims = dataset.lattice.dims;
  const Vec3 first = bounds.center() - 0.5 * spacing * Vec3(dims[0] - 1, dims[1] - 1, dims[2] - 1);
  dataset.lattice.world_from_index =
      Affine3(Eigen::Translation3d(first) * Eigen::Scaling(Vec3(Vec3::Constant(spacing))));
  dataset.arrays = {model::array_of_numbers(
      "nothing", 1, std::vector<std::uint8_t>(static_cast<std::size_t>(num_samples(dims)), 0))};
  nothing_.emplace(bounds, make_lattice_field(dataset, {.kernel = LatticeKernel{}}));
  return nothing_->second;
}

Frame FieldRenderer::draw_each(const DrawnFields& fields, const Camera& camera,
                               const RenderOptions& options, const RenderHooks& hooks) {
  const std::span<const FurtherVolume> further = fields.further;
  const auto part_of_hooks = [&](std::size_t i) {
    RenderHooks part;  // of the picture so far there is none
    part.stop = hooks.stop;
    part.team = hooks.team;
    if (hooks.progress) {
      part.progress = [&hooks, i, count = further.size() + 1](double done) {
        hooks.progress((static_cast<double>(i) + done) / static_cast<double>(count));
      };
    }
    return part;
  };
  Frame frame = draw({fields.field, fields.look}, camera, options, part_of_hooks(0));
  for (std::size_t i = 0; i < further.size(); ++i) {
    const Field field(further[i].field);
    const Frame other = draw({field, further[i].look}, camera, options, part_of_hooks(i + 1));
    add_picture(other.image, frame.image);
    add_work(other.profile, frame.profile);
  }
  finish_sum(fields.mixing, frame.image);
  if (hooks.tile_done) hooks.tile_done({0, 0, options.width, options.height, &frame.image});
  return frame;
}

std::vector<FurtherVolume> FieldRenderer::further_to_draw(std::span<const FurtherVolume> further,
                                                          const Camera& camera,
                                                          const RenderOptions& options,
                                                          const RenderHooks& hooks) {
  std::vector<FurtherVolume> volumes;
  for (const FurtherVolume& given : further) {
    const Field field = given.field;
    const Field& drawn =
        levels_.at(field, coarsest_level(field, camera, options), threads(), hooks.stop);
    volumes.push_back({*drawn.lattice(), completed(given.look, field, camera)});
  }
  return volumes;
}

Image FieldRenderer::trail_alone(const FrameJob& job, FrameProfile& profile) const {
  DepthLimits nowhere;
  nowhere.width = job.options.width;
  nowhere.height = job.options.height;
  nowhere.first.assign(job.options.depth_limits->first.size(), 0);
  RenderOptions options = job.options;
  options.depth_limits = std::make_shared<DepthLimits>(std::move(nowhere));
  RenderHooks hooks;
  hooks.stop = job.hooks.stop;
  const FrameJob alone{job.field, job.camera, job.look, job.trail, options, hooks};
  Frame frame = draw_by_choice(alone, false);
  profile.frame_ms += frame.profile.frame_ms;
  return std::move(frame.image);
}

SurfaceLight FieldRenderer::light_of(const LitScene& scene, const RenderHooks& hooks) {
  try {
    return {lights_.at(scene, threads(), hooks.stop, hooks.team.get()), {}};
  } catch (const std::bad_alloc&) {
    if (hooks.team) throw;  // the others have light, or wait for this one
    lights_ = {};
    return {nullptr, "light volume: no memory for it; drawn without occlusion and shadows"};
  }
}

Frame FieldRenderer::draw_by_choice(const FrameJob& job, bool is_distance_free) const {
  if (fallback_ == nullptr) return draw_on(*back_end_, job, is_distance_free);
  try {
    return draw_on(*back_end_, job, is_distance_free);
  } catch (const Error& error) {
    const bool is_of_device = error.code() == ErrorCode::kOutOfMemory ||
                              error.code() == ErrorCode::kDeviceLost ||
                              error.code() == ErrorCode::kUnsupported;
    if (!is_of_device) throw;
    // What the cpu cannot do either, it refuses likewise.
    Frame frame = draw_on(*fallback_, job, is_distance_free);
    add_notice(frame.profile, fmt::format("{}; drawn by backend cpu", error.what()));
    return frame;
  }
}

}  // namespace ovoid
