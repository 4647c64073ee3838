// SPDX-License-Identifier: Apache-2.0
#include "panels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace ovoid::viewer {
namespace {

constexpr std::array<Backend, 4> kBackends = {Backend::kAuto, Backend::kCpu, Backend::kVulkan,
                                              Backend::kReference};

std::string text_of(const ValueRange& range) {
  return range.is_empty() ? "no values" : fmt::format("{:.3g} to {:.3g}", range.lo, range.hi);
}

bool radio(Widgets& widgets, const std::string& name, bool is_on) {
  const bool is_pressed = ImGui::RadioButton(("##" + name).c_str(), is_on);
  widgets.mark(name);
  return is_pressed;
}

void row(const char* label, const std::string& value) {
  ImGui::TextUnformatted(label);
  const float width = ImGui::CalcTextSize(value.c_str()).x;
  ImGui::SameLine(std::max(ImGui::GetContentRegionMax().x - width, 0.0F));
  ImGui::TextUnformatted(value.c_str());
}

void array_table(Panel& panel) {
  Document& document = panel.document;
  const Shown& shown = *document.shown;
  const bool has_colors = document.info->kind != DatasetKind::kLattice;
  ArrayChoice choice{shown.array, shown.color_array, shown.component, shown.is_density};
  // Particles without a density of their own are drawn by their number per volume at first.
  const bool is_of_none = document.array_info(shown.array) == nullptr;
  if (is_of_none) choice.is_density = true;
  const ArrayChoice before = choice;
  if (!ImGui::BeginTable("arrays", has_colors ? 4 : 3,
                         ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingFixedFit))
    return;
  ImGui::TableSetupColumn(has_colors ? "opacity" : "shown");
  if (has_colors) ImGui::TableSetupColumn("colour");
  ImGui::TableSetupColumn("array", ImGuiTableColumnFlags_WidthStretch);
  ImGui::TableSetupColumn("range");
  ImGui::TableHeadersRow();
  for (const ArrayInfo& array : document.info->arrays) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    if (radio(panel.widgets, "data.array." + array.name, array.name == choice.array)) {
      if (choice.color_array == choice.array || is_of_none) choice.color_array = array.name;
      choice.array = array.name;
      choice.is_density = false;
    }
    if (has_colors) {
      ImGui::TableNextColumn();
      if (radio(panel.widgets, "data.color." + array.name, array.name == choice.color_array))
        choice.color_array = array.name;
    }
    ImGui::TableNextColumn();
    const std::string name =
        fmt::format("{}{}{}", array.name, array.is_cell_data ? " (cells)" : "",
                    array.num_components > 1 ? fmt::format(" x{}", array.num_components) : "");
    ImGui::TextUnformatted(name.c_str());
    panel.widgets.tip(name.c_str());
    ImGui::TableNextColumn();
    ImGui::TextUnformatted(
        (text_of(array.range) + (array.unit.empty() ? "" : " " + array.unit)).c_str());
  }
  if (document.info->kind == DatasetKind::kParticles) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    if (radio(panel.widgets, "data.density", choice.is_density) && !before.is_density) {
      choice = {};
      choice.is_density = true;
    }
    ImGui::TableNextColumn();
    ImGui::TableNextColumn();
    ImGui::TextUnformatted("density");
    panel.widgets.tip("The particles' mass per volume, or their number where they have no mass.");
  }
  ImGui::EndTable();
  const ArrayInfo* const chosen = document.array_info(choice.array);
  if (chosen != nullptr && chosen->num_components > 1) {
    int component = choice.component + 1;  // the norm comes first
    std::vector<std::string> names = {"magnitude"};
    static constexpr const char* kAxes[] = {" (x)", " (y)", " (z)"};
    const bool is_vector = chosen->num_components == 3;
    for (int i = 0; i < chosen->num_components; ++i)
      names.push_back(fmt::format("{}{}", i, is_vector ? kAxes[i] : ""));
    std::vector<const char*> options;
    options.reserve(names.size());
    for (const std::string& name : names) options.push_back(name.c_str());
    if (panel.widgets.choice("data.component", "component", options, &component))
      choice.component = component - 1;
  } else {
    choice.component = 0;
  }
  if (!(choice == before)) panel.wishes.array = choice;
}

void files_of_state(Panel& panel) {
  Widgets& widgets = panel.widgets;
  widgets.text("data.state.path", "state file", &panel.state.state_path, -110 * widgets.scale());
  widgets.tip(
      "Everything that is set, as one file; 'ovoid render --state FILE' draws the same "
      "picture.");
  ImGui::SameLine();
  if (widgets.button("data.state.save", "save")) panel.wishes.write_state = panel.state.state_path;
  ImGui::SameLine();
  if (widgets.button("data.state.restore", "restore"))
    panel.wishes.read_state = panel.state.state_path;
}

}  // namespace

void data_panel(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  if (widgets.text("data.open.path", "a file to open, or drop one here", &panel.state.open_path,
                   -60 * widgets.scale()))
    panel.wishes.open = panel.state.open_path;
  ImGui::SameLine();
  if (widgets.button("data.open", "open")) panel.wishes.open = panel.state.open_path;
  if (!document.is_open()) return;
  const Field& field = document.shown->field();
  row("file", document.info->title);
  row("kind", name_of(document.info->kind));
  row("kernels", fmt::format("{}", field.num_kernels()));
  row("memory", fmt::format("{:.1f} MiB", static_cast<double>(field.resident_bytes()) / 1048576));
  row("drawn values", text_of(field.value_range()));
  ImGui::Separator();
  if (document.info->arrays.empty()) {
    ImGui::TextWrapped("No arrays: the field is the particles' number per volume.");
  } else {
    array_table(panel);
  }
  ImGui::Separator();
  if (widgets.button("data.copy", "copy as command")) panel.wishes.copies_command = true;
  widgets.tip(
      "The line of 'ovoid render' that draws this picture, byte for byte on the same back "
      "end (Ctrl+C).");
  ImGui::SameLine();
  if (widgets.button("data.picture", "save the picture")) panel.wishes.saves_picture = true;
  files_of_state(panel);
  if (document.notes.empty()) return;
  ImGui::Separator();
  for (const std::string& note : document.notes) ImGui::TextWrapped("%s", note.c_str());
}

bool step_time(Document& document, int steps) {
  const std::vector<double>& times = document.info->times;
  if (times.size() < 2) return false;
  const auto behind = std::upper_bound(times.begin(), times.end(), document.time.now);
  auto at = std::max<std::ptrdiff_t>(behind - times.begin() - 1, 0);
  const bool is_between = times[static_cast<std::size_t>(at)] < document.time.now;
  if (steps < 0 && is_between) ++at;
  const auto last = static_cast<std::ptrdiff_t>(times.size()) - 1;
  at += steps;
  if (document.time.loops) at = (at % (last + 1) + last + 1) % (last + 1);
  document.time.now = times[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(at, 0, last))];
  return true;
}

std::string step_text(const Document& document) {
  const std::vector<double>& times = document.info->times;
  const auto at = std::find(times.begin(), times.end(), document.shown->time);
  if (at == times.end()) return {};
  return fmt::format(" (step {} of {})", at - times.begin(), times.size());
}

void time_panel(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  if (!document.has_time()) {
    ImGui::TextWrapped(
        "These data have one step. Several files of a series can be opened together.");
    return;
  }
  TimeState& time = document.time;
  const std::vector<double>& times = document.info->times;
  const std::string unit = document.info->time_unit;
  bool is_moved = widgets.slider("time.now", "time", &time.now, times.front(), times.back(),
                                 unit.empty() ? "%.6g" : ("%.6g " + unit).c_str());
  if (widgets.button("time.first", "|<")) {
    time.now = times.front();
    is_moved = true;
  }
  ImGui::SameLine();
  if (widgets.button("time.back", "<")) is_moved |= step_time(document, -1);
  ImGui::SameLine();
  if (widgets.button("time.play", time.is_playing ? "pause" : "play"))
    time.is_playing = !time.is_playing;
  ImGui::SameLine();
  if (widgets.button("time.forward", ">")) is_moved |= step_time(document, 1);
  ImGui::SameLine();
  if (widgets.button("time.last", ">|")) {
    time.now = times.back();
    is_moved = true;
  }
  widgets.checkbox("time.loop", "loop", &time.loops);
  is_moved |= widgets.checkbox("time.interpolate", "between steps, too", &time.is_interpolated);
  widgets.checkbox("time.fastest", "every step, as fast as possible", &time.is_fastest);
  if (!time.is_fastest) {
    const double span = times.back() - times.front();
    widgets.number(
        "time.rate", unit.empty() ? "per second" : (unit + " per s").c_str(), &time.rate,
        {.lo = span * 1e-4, .hi = span * 100, .speed = span / 1000, .is_logarithmic = true});
  }
  if (document.info->kind == DatasetKind::kLattice) {
    bool blurs = time.blur_length > 0;
    if (widgets.checkbox("time.blur", "motion blur", &blurs)) {
      time.blur_length = blurs ? (times.back() - times.front()) / 4 : 0;
      is_moved = true;
    }
    if (blurs) {
      is_moved |=
          widgets.slider("time.blur.length", "length", &time.blur_length,
                         (times.back() - times.front()) / 1000, times.back() - times.front());
      is_moved |= widgets.slider("time.blur.decay", "decay", &time.blur_decay, 0, 10);
    }
  }
  row("shown", fmt::format("{:g} {}{}", document.shown->time, unit, step_text(document)));
  if (panel.status.resident_bytes == 0) {
    if (is_moved) panel.wishes.goes_to_time = true;
    return;
  }
  row("steps in memory",
      fmt::format("{:.1f} MiB", static_cast<double>(panel.status.resident_bytes) / 1048576));
  if (is_moved) panel.wishes.goes_to_time = true;
}

void compare_panel(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  ImGui::TextWrapped("Keep how the picture looks as A, change anything, and see both.");
  if (widgets.button("compare.keep", "keep this as A")) {
    document.other = Setting{document.view, document.setup};
    document.compare = CompareMode::kSideBySide;
    document.touch();
  }
  ImGui::SameLine();
  if (widgets.button("compare.swap", "swap A and B", document.other.has_value())) {
    std::swap(document.other->view, document.view);
    std::swap(document.other->setup, document.setup);
    document.touch();
  }
  if (!document.other) return;
  ImGui::SameLine();
  if (widgets.button("compare.drop", "drop A")) {
    document.other.reset();
    document.compare = CompareMode::kOff;
    document.touch();
    return;
  }
  int mode = static_cast<int>(document.compare);
  if (widgets.choice("compare.mode", "show", {"B alone", "A and B side by side", "difference"},
                     &mode)) {
    document.compare = static_cast<CompareMode>(mode);
    document.touch();
  }
  if (document.compare == CompareMode::kOff) return;
  if (document.compare == CompareMode::kDifference)
    ImGui::TextWrapped("Distances of colour, %.0f times as bright.", kDifferenceGain);
  if (!panel.status.is_final) {
    row("PSNR", "...");
  } else {
    row("PSNR",
        std::isinf(panel.status.psnr) ? "equal" : fmt::format("{:.2f} dB", panel.status.psnr));
  }
}

namespace {

void engine_settings(Panel& panel) {
  Document& document = panel.document;
  Widgets& widgets = panel.widgets;
  RenderOptions& options = document.view.options;
  int backend = static_cast<int>(
      std::find(kBackends.begin(), kBackends.end(), document.setup.backend) - kBackends.begin());
  bool is_changed = widgets.choice("profile.backend", "back end",
                                   {"auto", "cpu", "vulkan", "reference"}, &backend);
  if (is_changed) document.setup.backend = kBackends[static_cast<std::size_t>(backend)];
  is_changed |=
      widgets.whole("profile.threads", "threads (0: all)", &document.setup.threads, 0, 64);
  double distance = options.sampling_distance;
  if (distance == 0) distance = document.shown->field().default_sampling_distance();
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
      widgets.choice("profile.classification", "classification", {"sampled", "pre-integrated"},
                     &classification)) {
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
  row("back end", profile.device.empty()
                      ? fmt::format("{} {}", profile.backend, profile.simd_target)
                      : fmt::format("{}: {}", profile.backend, profile.device));
  row("threads", fmt::format("{}", profile.threads));
  row("picture", fmt::format("{:.1f} ms", status.picture_ms));
  row("pictures per second", fmt::format("{:.1f}", status.pictures_per_second));
  row("interface", fmt::format("{:.1f} ms", status.interface_ms));
  ImGui::TextDisabled("stages, summed over threads:");
  for (const auto& [stage, ms] : profile.stages_ms)
    row(("  " + stage).c_str(), fmt::format("{:.2f} ms", ms));
  row("kernels", fmt::format("{} of {}", profile.kernels_drawn, profile.kernels_total));
  row("samples", fmt::format("{}", profile.samples_reconstructed));
  row("  shaded", fmt::format("{}", profile.samples_shaded));
  row("blocks", fmt::format("{} of {}", profile.blocks_drawn, profile.blocks_total));
  row("  empty", fmt::format("{}", profile.blocks_skipped_empty));
  row("  irrelevant", fmt::format("{}", profile.blocks_skipped_irrelevant));
  row("  opaque", fmt::format("{}", profile.blocks_skipped_opaque));
  row("memory of the data",
      fmt::format("{:.1f} MiB",
                  static_cast<double>(panel.document.shown->field().resident_bytes()) / 1048576));
  if (!profile.notice.empty()) ImGui::TextWrapped("%s", profile.notice.c_str());
}

}  // namespace ovoid::viewer
