// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "panels.h"

namespace ovoid::viewer {
namespace {

constexpr std::array<Backend, 4> kBackends = {Backend::kAuto, Backend::kCpu, Backend::kVulkan,
                                              Backend::kReference};

// How far apart sheets are, as a part of what is usual: what quality is in one word.
struct QualityName {
  const char* name;
  double factor;
};
constexpr std::array<QualityName, 4> kQualities = {
    {{"fast", 2}, {"normal", 1}, {"fine", 0.5}, {"finest", 0.25}}};
constexpr std::size_t kNormal = 1;

double usual_distance(const Document& document) {
  RenderOptions options = document.view.options;
  options.sampling_distance = 0;
  return sheet_distance(document.shown->field(), document.view.look, options);
}

// Its number in kQualities; another one if the distance is nobody's.
std::size_t quality_of(const Document& document) {
  const double distance = document.view.options.sampling_distance;
  if (distance == 0) return kNormal;
  const double usual = usual_distance(document);
  constexpr double kSame = 1e-6;  // of the usual one: a state's or a command's text may round
  const auto found = std::find_if(kQualities.begin(), kQualities.end(), [&](const QualityName& q) {
    return std::abs(distance - q.factor * usual) < kSame * usual;
  });
  return static_cast<std::size_t>(found - kQualities.begin());
}

void choose_quality(Panel& panel) {
  Document& document = panel.document;
  const auto before = static_cast<int>(quality_of(document));
  std::vector<const char*> options;
  options.reserve(kQualities.size() + 1);
  for (const QualityName& quality : kQualities) options.push_back(quality.name);
  if (before == static_cast<int>(kQualities.size())) options.push_back("by number");
  int chosen = before;
  const bool is_chosen = panel.widgets.choice("quality", "quality", options, &chosen);
  panel.widgets.tip(
      "Sheets twice as far apart as usual, or two and four times as near: the more of them, the "
      "longer a full picture takes. What moves is coarser by itself.");
  if (!is_chosen || chosen == before) return;
  const auto number = static_cast<std::size_t>(chosen);
  document.view.options.sampling_distance =
      number == kNormal ? 0 : kQualities[number].factor * usual_distance(document);
  document.touch();
}

void choose_back_end(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  int backend = static_cast<int>(
      std::find(kBackends.begin(), kBackends.end(), document.setup.backend) - kBackends.begin());
  if (widgets.choice("quality.backend", "back end", {"auto", "cpu", "vulkan", "reference"},
                     &backend)) {
    document.setup.backend = kBackends[static_cast<std::size_t>(backend)];
    document.touch_beside_view();
  }
  if (widgets.whole("quality.threads", "threads (0: all)", &document.setup.threads, 0, 64))
    document.touch_beside_view();
}

void edit_numbers(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  RenderOptions& options = document.view.options;
  bool is_changed = false;
  double distance = sheet_distance(document.shown->field(), document.view.look, options);
  const double natural = document.shown->field().default_sampling_distance();
  if (widgets.number("quality.sampling-distance", "sampling distance", &distance,
                     {.lo = natural / 16, .hi = natural * 16, .speed = natural / 50})) {
    options.sampling_distance = distance;
    is_changed = true;
  }
  int post = static_cast<int>(options.post_convolution);
  if (widgets.choice("quality.post-convolution", "post-convolution",
                     {"off", "bilinear", "gaussian", "cubic", "auto"}, &post)) {
    options.post_convolution = static_cast<PostConvolution>(post);
    is_changed = true;
  }
  int slab = static_cast<int>(options.slab);
  if (widgets.choice("quality.slab", "slab", {"auto", "mid", "mean"}, &slab)) {
    options.slab = static_cast<Slab>(slab);
    is_changed = true;
  }
  int gradient = static_cast<int>(options.gradient);
  if (widgets.choice("quality.gradient", "gradient", {"auto", "corrected", "exact", "central"},
                     &gradient)) {
    options.gradient = static_cast<GradientMethod>(gradient);
    is_changed = true;
  }
  int classification = static_cast<int>(options.classification);
  if (document.view.look.mode == Mode::kComposite &&
      widgets.choice("quality.classification", "classification",
                     {"sampled", "pre-integrated", "refined"}, &classification)) {
    options.classification = static_cast<Classification>(classification);
    is_changed = true;
  }
  int evaluate = static_cast<int>(options.evaluate);
  if (widgets.choice("quality.evaluate", "evaluate", {"auto", "gather", "scatter"}, &evaluate)) {
    options.evaluate = static_cast<Evaluate>(evaluate);
    is_changed = true;
  }
  if (is_changed) document.touch();
}

}  // namespace

std::string quality_name(const Document& document) {
  const std::size_t number = quality_of(document);
  return number < kQualities.size() ? kQualities[number].name : "by number";
}

void quality_panel(Panel& panel) {
  choose_quality(panel);
  edit_numbers(panel);
  ImGui::Separator();
  choose_back_end(panel);
  ImGui::Separator();
  ImGui::TextDisabled("The last picture:");
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
