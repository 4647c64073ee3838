// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "panels.h"

namespace ovoid::viewer {
namespace {

constexpr double kMostOfCount = 1e12;

// The flag that says the goal, with its value; a number that was dragged is rounded.
cli::Words goal_words(const FitState& fit) {
  switch (fit.goal) {
    case FitGoal::kPsnr:
      return {"--psnr", fmt::format("{:.6g}", fit.psnr)};
    case FitGoal::kTolerance:
      return {"--tolerance", fmt::format("{:.6g}%", fit.tolerance)};
    case FitGoal::kKernels:
      return {"--kernels", fmt::format("{:.0f}", fit.kernels)};
    case FitGoal::kBytes:
      return {"--bytes", fmt::format("{:.0f}K", fit.kib)};
    case FitGoal::kSmooth:
      break;
  }
  return {"--smooth"};
}

void choose_fit_goal(Panel& panel) {
  FitState& fit = panel.state.fit;
  Widgets& widgets = panel.widgets;
  std::vector<const char*> goals = {"PSNR", "greatest error", "number of kernels",
                                    "size of the file"};
  if (panel.document.info->kind == DatasetKind::kLattice) goals.push_back("the scan's own noise");
  int goal = static_cast<int>(fit.goal);
  if (widgets.choice("fit.goal", "goal", goals, &goal)) fit.goal = static_cast<FitGoal>(goal);
  switch (fit.goal) {
    case FitGoal::kPsnr:
      widgets.number("fit.psnr", "as few as reach", &fit.psnr, {1, 200, 0.1, "%.4g dB"});
      widgets.tip("20 log10(range / rms error), over the volume (--psnr).");
      break;
    case FitGoal::kTolerance:
      widgets.number("fit.tolerance", "as few as leave", &fit.tolerance,
                     {1e-4, 100, 0.02, "%.4g %% of the range"});
      widgets.tip("No value errs by more than this share of the values' range (--tolerance).");
      break;
    case FitGoal::kKernels:
      widgets.number("fit.kernels", "so many", &fit.kernels, {1, kMostOfCount, 20, "%.0f kernels"});
      widgets.tip("Those that err least (--kernels).");
      break;
    case FitGoal::kBytes:
      widgets.number("fit.kib", "as many as fit in", &fit.kib, {1, kMostOfCount, 5, "%.0f KiB"});
      widgets.tip("In a file of that size (--bytes).");
      break;
    case FitGoal::kSmooth:
      ImGui::TextWrapped("As few kernels as leave the scan's own noise as the error.");
      break;
  }
}

void run_of_fit(Panel& panel) {
  FitState& fit = panel.state.fit;
  Widgets& widgets = panel.widgets;
  const FitProgress& progress = panel.status.fit;
  if (progress.is_running) {
    if (widgets.button("fit.cancel", "cancel")) panel.wishes.cancels_fit = true;
    ImGui::SameLine();
    const std::string done = fmt::format("{:.0f} %", 100 * progress.fraction);
    ImGui::ProgressBar(static_cast<float>(progress.fraction), ImVec2(-FLT_MIN, 0), done.c_str());
  } else if (widgets.button("fit.start", "fit")) {
    panel.wishes.fit = goal_words(fit);
  }
  if (fit.error.empty()) return;
  ImGui::PushStyleColor(ImGuiCol_Text, widgets.colors().error);
  ImGui::TextWrapped("%s", fit.error.c_str());
  ImGui::PopStyleColor();
}

void figures_of_fit(const Panel& panel) {
  const Fitted& fit = *panel.document.fit;
  for (const auto& [name, text] : fit.rows) {
    ImGui::TextUnformatted(name.c_str());
    ImGui::SameLine(panel.widgets.width_of_label());
    ImGui::TextWrapped("%s", text.c_str());
  }
  const std::vector<std::string>& known = panel.document.notes;
  for (const std::string& note : fit.notes) {
    if (std::find(known.begin(), known.end(), note) == known.end())
      ImGui::TextWrapped("%s", note.c_str());
  }
}

void pictures_of_fit(Panel& panel) {
  Document& document = panel.document;
  if (!document.has_fit_of_shown()) {
    ImGui::TextWrapped("Of %s, which is not shown now.", document.fit->choice.array.c_str());
    return;
  }
  compare_choice(panel, "fit.show", CompareWith::kFit,
                 {"the data alone", "data left, fit right of a line", "data and fit side by side",
                  "difference"});
  if (document.fit->within == nullptr) return;
  if (panel.widgets.checkbox("fit.surface", "ends at the mesh's surface",
                             &document.fit_has_surface))
    document.touch_other();
  panel.widgets.tip("As 'ovoid render FIT --within MESH' draws it; else its kernels alone.");
}

void file_of_fit(Panel& panel) {
  FitState& fit = panel.state.fit;
  Widgets& widgets = panel.widgets;
  const std::string usual = usual_fit_path(panel.document);
  bool saves = widgets.text("fit.path", usual.c_str(), &fit.path, -58 * widgets.scale());
  ImGui::SameLine();
  saves |= widgets.button("fit.save", "save");
  if (saves) panel.wishes.saves_fit = true;
  if (widgets.button("fit.copy", "copy as command")) panel.wishes.copies_fit = true;
  widgets.tip("The line of 'ovoid fit' that writes this file, byte for byte.");
  if (fit.saved.empty()) return;
  ImGui::SameLine();
  if (widgets.button("fit.open", "open it")) panel.wishes.open = fit.saved;
  widgets.tip("What was saved, in the place of the data.");
}

}  // namespace

std::string usual_fit_path(const Document& document) {
  const std::string name =
      std::filesystem::path(document.launch->data.inputs.front()).filename().string();
  const std::string stem = name.substr(0, name.find('.', 1));
  const bool is_lattice = document.info->kind == DatasetKind::kLattice;
  return (stem.empty() ? "data" : stem) + (is_lattice ? "-fit.h5" : "-fit.ply");
}

void fit_panel(Panel& panel) {
  if (panel.document.view.solid) {
    ImGui::TextWrapped("Of a solid: save its kernels, and open them.");
    return;
  }
  ImGui::TextWrapped("Fewer kernels for the same field, with an error that is told.");
  choose_fit_goal(panel);
  run_of_fit(panel);
  if (panel.document.fit == nullptr) return;
  ImGui::Separator();
  figures_of_fit(panel);
  ImGui::Separator();
  pictures_of_fit(panel);
  ImGui::Separator();
  file_of_fit(panel);
}

}  // namespace ovoid::viewer
