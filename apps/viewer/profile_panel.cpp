// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "panels.h"

namespace ovoid::viewer {
namespace {

constexpr std::array<Backend, 4> kBackends = {Backend::kAuto, Backend::kCpu, Backend::kVulkan,
                                              Backend::kReference};

void engine_settings(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  RenderOptions& options = document.view.options;
  int backend = static_cast<int>(
      std::find(kBackends.begin(), kBackends.end(), document.setup.backend) - kBackends.begin());
  if (widgets.choice("profile.backend", "back end", {"auto", "cpu", "vulkan", "reference"},
                     &backend)) {
    document.setup.backend = kBackends[static_cast<std::size_t>(backend)];
    document.touch_beside_view();
  }
  if (widgets.whole("profile.threads", "threads (0: all)", &document.setup.threads, 0, 64))
    document.touch_beside_view();
  bool is_changed = false;
  double distance = sheet_distance(document.shown->field(), document.view.look, options);
  const double natural = document.shown->field().default_sampling_distance();
  if (widgets.number("profile.sampling-distance", "sampling distance", &distance,
                     {.lo = natural / 16, .hi = natural * 16, .speed = natural / 50})) {
    options.sampling_distance = distance;
    is_changed = true;
  }
  int post = static_cast<int>(options.post_convolution);
  if (widgets.choice("profile.post-convolution", "post-convolution",
                     {"off", "bilinear", "gaussian", "cubic", "auto"}, &post)) {
    options.post_convolution = static_cast<PostConvolution>(post);
    is_changed = true;
  }
  int slab = static_cast<int>(options.slab);
  if (widgets.choice("profile.slab", "slab", {"auto", "mid", "mean"}, &slab)) {
    options.slab = static_cast<Slab>(slab);
    is_changed = true;
  }
  int gradient = static_cast<int>(options.gradient);
  if (widgets.choice("profile.gradient", "gradient", {"auto", "corrected", "exact", "central"},
                     &gradient)) {
    options.gradient = static_cast<GradientMethod>(gradient);
    is_changed = true;
  }
  int classification = static_cast<int>(options.classification);
  if (document.view.look.mode == Mode::kComposite &&
      widgets.choice("profile.classification", "classification",
                     {"sampled", "pre-integrated", "refined"}, &classification)) {
    options.classification = static_cast<Classification>(classification);
    is_changed = true;
  }
  int evaluate = static_cast<int>(options.evaluate);
  if (widgets.choice("profile.evaluate", "evaluate", {"auto", "gather", "scatter"}, &evaluate)) {
    options.evaluate = static_cast<Evaluate>(evaluate);
    is_changed = true;
  }
  if (is_changed) document.touch();
}

}  // namespace

void profile_panel(Panel& panel) {
  engine_settings(panel);
  ImGui::Separator();
  const Status& status = panel.status;
  const FrameProfile& profile = status.profile;
  panel.widgets.row("back end", profile.device.empty()
                                    ? fmt::format("{} {}", profile.backend, profile.simd_target)
                                    : fmt::format("{}: {}", profile.backend, profile.device));
  panel.widgets.row("threads", fmt::format("{}", profile.threads));
  panel.widgets.row("picture", fmt::format("{:.1f} ms", status.picture_ms));
  panel.widgets.row("pictures per second", fmt::format("{:.1f}", status.pictures_per_second));
  panel.widgets.row("interface", fmt::format("{:.1f} ms", status.interface_ms));
  ImGui::TextDisabled("stages, summed over threads:");
  for (const auto& [stage, ms] : profile.stages_ms)
    panel.widgets.row(("  " + stage).c_str(), fmt::format("{:.2f} ms", ms));
  panel.widgets.row("kernels",
                    fmt::format("{} of {}", profile.kernels_drawn, profile.kernels_total));
  panel.widgets.row("samples", fmt::format("{}", profile.samples_reconstructed));
  panel.widgets.row("  shaded", fmt::format("{}", profile.samples_shaded));
  panel.widgets.row("blocks", fmt::format("{} of {}", profile.blocks_drawn, profile.blocks_total));
  panel.widgets.row("  empty", fmt::format("{}", profile.blocks_skipped_empty));
  panel.widgets.row("  irrelevant", fmt::format("{}", profile.blocks_skipped_irrelevant));
  panel.widgets.row("  opaque", fmt::format("{}", profile.blocks_skipped_opaque));
  panel.widgets.row(
      "memory of the data",
      fmt::format("{:.1f} MiB",
                  static_cast<double>(panel.document.shown->field().resident_bytes()) / 1048576));
  if (!profile.notice.empty()) ImGui::TextWrapped("%s", profile.notice.c_str());
}

}  // namespace ovoid::viewer
