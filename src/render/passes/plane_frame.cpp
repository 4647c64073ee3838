// SPDX-License-Identifier: Apache-2.0
// In: what render() takes, and a plane. Out: up to three parts, each by the renderer, put together
// front to back: the half in front, the plane's values, the half behind.
#include "render/passes/plane_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "data/parallel.h"
#include "data/validate.h"
#include "ovoid/error.h"
#include "render/passes/plane_values.h"
#include "render/passes/plane_view.h"
#include "view/look/color_attribute.h"
#include "view/look/look_table.h"
#include "view/plan/coverage.h"

namespace ovoid {
namespace {

using Clock = std::chrono::steady_clock;

constexpr float kNowhere = std::numeric_limits<float>::infinity();

void require_valid(const Field& field, const Camera& camera, const Look& look,
                   const ValuePlane& plane, const RenderOptions& options) {
  data::require_field(field);
  camera.validate();
  look.validate();
  options.validate();
  if (!plane.normal.allFinite() || !(plane.normal.norm() > 0) ||
      !std::isfinite(plane.normal.norm()))
    throw Error(ErrorCode::kInvalidArgument, "plane.normal: must be finite and not zero");
  if (!std::isfinite(plane.offset))
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("plane.offset = {}: must be finite", plane.offset));
  constexpr int kMost = RenderOptions::kMaxClipPlanes - 1;
  if (options.clip_planes.size() > kMost) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("clip_planes: {} given, at most {} are possible beside a value plane",
                            options.clip_planes.size(), kMost));
  }
  if (look.mode != Mode::kComposite && look.mode != Mode::kIsosurface) {
    throw Error(ErrorCode::kUnsupported,
                "value plane: is for the modes composite and isosurface; the maximum, mean or "
                "integral of the half before an opaque plane says nothing");
  }
  if (options.part != nullptr)
    throw Error(ErrorCode::kUnsupported, "value plane: is for whole pictures, not for parts");
}

RenderOptions with_clip(const RenderOptions& options, const ClipPlane& plane) {
  RenderOptions more = options;
  more.clip_planes.push_back(plane);
  return more;
}

// Hooks of a part that takes `share` of the progress, after what is done.
RenderHooks hooks_of_part(const RenderHooks& hooks, double done, double share) {
  RenderHooks part;
  part.stop = hooks.stop;
  if (hooks.progress)
    part.progress = [&hooks, done, share](double fraction) {
      hooks.progress(std::min(1.0, done + share * fraction));
    };
  return part;
}

void require_running(const RenderHooks& hooks) {
  if (hooks.stop.stop_requested()) throw Error(ErrorCode::kCancelled, "rendering was cancelled");
}

void add_stage(FrameProfile& sum, const std::string& name, double ms) {
  const auto named = std::find_if(sum.stages_ms.begin(), sum.stages_ms.end(),
                                  [&](const auto& stage) { return stage.first == name; });
  if (named == sum.stages_ms.end()) {
    sum.stages_ms.emplace_back(name, ms);
  } else {
    named->second += ms;
  }
}

void add_profile(FrameProfile& sum, const FrameProfile& part) {
  if (sum.backend.empty()) {
    sum = part;
    return;
  }
  if (sum.notice.empty()) sum.notice = part.notice;
  sum.frame_ms += part.frame_ms;
  for (const auto& [name, ms] : part.stages_ms) add_stage(sum, name, ms);
  sum.kernels_drawn += part.kernels_drawn;
  sum.kernels_loaded += part.kernels_loaded;
  sum.samples_reconstructed += part.samples_reconstructed;
  sum.samples_shaded += part.samples_shaded;
  sum.gradients += part.gradients;
  sum.multiply_adds += part.multiply_adds;
  sum.bytes_loaded += part.bytes_loaded;
  sum.bytes_uploaded += part.bytes_uploaded;
  sum.blocks_total += part.blocks_total;
  sum.blocks_drawn += part.blocks_drawn;
  sum.blocks_skipped_empty += part.blocks_skipped_empty;
  sum.blocks_skipped_irrelevant += part.blocks_skipped_irrelevant;
  sum.blocks_skipped_opaque += part.blocks_skipped_opaque;
}

view::LookTable colors_of(const Field& field, const Look& look) {
  const bool has_own = field.kernels() != nullptr && field.kernels()->has_own_color();
  return view::colors_alone(has_own ? view::color_function_of(look) : look.transfer_function);
}

// The frame while its parts come in.
class PlaneFrame {
 public:
  PlaneFrame(const PlaneView& view, const RenderOptions& options)
      : view_(view),
        limits_(options.depth_limits.get()),
        opaque_at_(static_cast<float>(options.opaque_at)) {
    const auto count =
        static_cast<std::size_t>(options.width) * static_cast<std::size_t>(options.height);
    image_.width = options.width;
    image_.height = options.height;
    image_.rgba.assign(4 * count, 0.0F);
    image_.depth.assign(count, kNowhere);
    image_.front_depth.assign(count, kNowhere);
    takes_rest_.assign(count, 0);
  }

  void set_front(Image front) { image_ = std::move(front); }

  // The plane joins what is in front of it, and where it does not, it is noted whether more than
  // that can be seen.
  void add_plane(const PlaneValues& values, const view::LookTable& colors,
                 const data::ParallelPlan& rows) {
    data::parallel_ranges(rows, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t y = begin; y < end; ++y) {
        for (int x = 0; x < image_.width; ++x) add_plane_at(x, static_cast<int>(y), values, colors);
      }
    });
  }

  bool takes_rest() const {
    return std::any_of(takes_rest_.begin(), takes_rest_.end(), [](auto t) { return t != 0; });
  }

  // What is seen beside the plane: the half behind, or, where the half in front is shown, the
  // whole.
  void add_rest(const Image& rest) {
    for (std::size_t i = 0; i < takes_rest_.size(); ++i) {
      if (takes_rest_[i] == 0) continue;
      std::copy_n(rest.rgba.data() + 4 * i, 4, image_.rgba.data() + 4 * i);
      image_.depth[i] = rest.depth[i];
      image_.front_depth[i] = rest.front_depth[i];
    }
  }

  Image take() { return std::move(image_); }

 private:
  void add_plane_at(int x, int y, const PlaneValues& values, const view::LookTable& colors) {
    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) +
                          static_cast<std::size_t>(x);
    float* rgba = image_.rgba.data() + 4 * i;
    if (rgba[3] >= opaque_at_) return;
    const auto hit = view_.hit(x, y);
    if (!hit) {
      takes_rest_[i] = is_before_plane(x, y) ? 0 : 1;
      return;
    }
    const bool is_shown = view_.is_kept(hit->at) && is_within_limits(x, y, *hit);
    const auto value = is_shown ? values.at(*hit) : std::nullopt;
    if (!value) {
      takes_rest_[i] = view_.meets_box_beyond(view_.ray(x, y), hit->depth) ? 1 : 0;
      return;
    }
    const view::LookTable::Sample color = colors.at(*value);
    const float rest = 1.0F - rgba[3];
    rgba[0] += rest * color.r;
    rgba[1] += rest * color.g;
    rgba[2] += rest * color.b;
    rgba[3] = 1.0F;
    for (std::vector<float>* depths : {&image_.depth, &image_.front_depth}) {
      float& depth = (*depths)[i];
      if (!(depth < kNowhere)) depth = static_cast<float>(hit->depth);
    }
  }

  // All of the ray that is drawn lies on the eye's side; else the near plane hides where it leaves
  // it.
  bool is_before_plane(int x, int y) const {
    return !(view_.normal().dot(view_.ray(x, y).direction) > 0);
  }

  bool is_within_limits(int x, int y, const PlaneHit& hit) const {
    return limits_ == nullptr || limits_->shows_field_at(x, y, static_cast<float>(hit.depth));
  }

  const PlaneView& view_;
  const DepthLimits* limits_;  // null: none
  float opaque_at_;
  Image image_;
  std::vector<std::uint8_t> takes_rest_;  // of each pixel: no plane hides what is behind in it
};

}  // namespace

Frame draw_with_plane(FieldRenderer& renderer, const DrawnFields& fields, const ValuePlane& plane,
                      const Camera& camera, const RenderOptions& asked_options,
                      const RenderHooks& hooks) {
  const Field& field = fields.field;
  const Look& look = fields.look;
  require_valid(field, camera, look, plane, asked_options);
  // The plane's values are of pixels; what lies on either side is, too.
  RenderOptions options = asked_options;
  if (options.sheets == Sheets::kAuto) options.sheets = Sheets::kImage;
  if (options.depth_limits != nullptr && !options.depth_limits->coverage.empty()) {
    // What is put together is of whole pixels.
    auto whole = std::make_shared<DepthLimits>(*options.depth_limits);
    whole->coverage.clear();
    options.depth_limits = std::move(whole);
  }
  const Clock::time_point start = Clock::now();
  const auto elapsed_ms = [&] {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
  };
  const PlaneView view(field, camera, plane, options);
  if (!view.is_met()) return renderer.draw(fields, camera, asked_options, hooks);
  const bool is_shown = plane.front == PlaneFront::kShown;
  const RenderOptions behind = with_clip(options, view.behind());
  const std::vector<Vec3> footprint = view.footprint();
  if (footprint.size() < 3) {
    return renderer.draw(fields, camera,
                         is_shown ? asked_options : with_clip(asked_options, view.behind()), hooks);
  }

  constexpr double kShareOfValues = 0.1;
  const double share = (1 - kShareOfValues) / (is_shown ? 2 : 1);
  double done = kShareOfValues;
  Frame out;
  const PlaneValues values(renderer, field, look, view, footprint, options,
                           hooks_of_part(hooks, 0, done));
  out.profile = values.profile();
  PlaneFrame frame(view, options);
  if (is_shown) {
    require_running(hooks);
    Frame front = renderer.draw(fields, camera, with_clip(options, view.front()),
                                hooks_of_part(hooks, done, share));
    done += share;
    add_profile(out.profile, front.profile);
    frame.set_front(std::move(front.image));
  }
  const double parts_ms = out.profile.frame_ms;
  const int threads = out.profile.backend == "vulkan" ? 0 : out.profile.threads;
  frame.add_plane(values, colors_of(field, look), {options.height, 8, threads, hooks.stop});
  if (options.collect_profile) add_stage(out.profile, "plane", elapsed_ms() - parts_ms);
  if (frame.takes_rest()) {
    require_running(hooks);
    const Frame rest = renderer.draw(fields, camera, is_shown ? options : behind,
                                     hooks_of_part(hooks, done, 1 - done));
    add_profile(out.profile, rest.profile);
    frame.add_rest(rest.image);
  } else if (hooks.progress) {
    hooks.progress(1.0);
  }
  require_running(hooks);
  out.image = frame.take();
  if (asked_options.depth_limits != nullptr)
    view::apply_coverage(asked_options.depth_limits->coverage, look.mode, out.image);
  out.profile.frame_ms = elapsed_ms();
  if (hooks.tile_done) hooks.tile_done({0, 0, options.width, options.height, &out.image});
  return out;
}

}  // namespace ovoid
