// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "handles.h"
#include "panels.h"

namespace ovoid::viewer {
namespace {

// More is a matter of minutes and gigabytes, and of the command.
constexpr int kMostLevelsHere = 4;
constexpr std::array kBases = {SolidBasis::kInterpolating, SolidBasis::kOneGaussian,
                               SolidBasis::kTwoGaussians};

void shape_of_solid(Panel& panel) {
  SolidShape& solid = *panel.document.view.solid;
  Widgets& widgets = panel.widgets;
  bool is_changed = widgets.whole("solid.levels", "levels", &solid.levels, 0, kMostLevelsHere);
  widgets.tip("Steps of subdivision, each of which makes eight cells of one.");
  std::vector<const char*> names;
  names.reserve(kBases.size());
  for (const SolidBasis basis : kBases) names.push_back(name_of(basis));
  int basis =
      static_cast<int>(std::find(kBases.begin(), kBases.end(), solid.basis) - kBases.begin());
  if (widgets.choice("solid.basis", "kernels", names, &basis)) {
    solid.basis = kBases[static_cast<std::size_t>(basis)];
    is_changed = true;
  }
  widgets.tip("Which Gaussians stand for a vertex (--basis).");
  if (is_changed) panel.document.touch();
  widgets.row("cells", fmt::format("{}", solid.control->cells.size()));
  widgets.row("vertices", fmt::format("{}", solid.control->num_vertices()));
}

void vertex_of_solid(Panel& panel) {
  Document& document = panel.document;
  PanelState& state = panel.state;
  Widgets& widgets = panel.widgets;
  const SolidMesh& control = *document.view.solid->control;
  const int last = static_cast<int>(control.num_vertices()) - 1;
  if (control.num_vertices() > Handles::kMostVertices) {
    ImGui::TextWrapped("Too many vertices to be shown; choose one by its number.");
  } else {
    widgets.checkbox("solid.vertices", "vertices in the picture", &state.has_vertices);
  }
  state.vertex = std::min(state.vertex, last);
  widgets.whole("solid.vertex", "vertex", &state.vertex, -1, last);
  if (state.vertex < 0) {
    ImGui::TextWrapped("Drag a vertex in the picture, or click one to see its numbers.");
    return;
  }
  const auto vertex = static_cast<std::size_t>(state.vertex);
  Vec3 place = control.position(vertex);
  double density = control.densities[vertex];
  bool is_changed = widgets.vector("solid.place", "place", &place, document.extent() / 500);
  is_changed |= widgets.number("solid.density", "density", &density, {-1e30, 1e30, 0.01});
  if (is_changed) {
    state.vertex_refusal = document.set_vertex(vertex, place, density);
    if (state.vertex_refusal.empty()) document.touch();
  }
  if (state.vertex_refusal.empty()) return;
  ImGui::PushStyleColor(ImGuiCol_Text, widgets.colors().error);
  ImGui::TextWrapped("The vertex stays: %s", state.vertex_refusal.c_str());
  ImGui::PopStyleColor();
}

void files_of_solid(Panel& panel) {
  PanelState& state = panel.state;
  Widgets& widgets = panel.widgets;
  const auto file = [&](const char* label, const char* name, std::string* path) {
    ImGui::TextUnformatted(label);
    bool saves =
        widgets.text(fmt::format("solid.{}.path", name), "a file", path, -58 * widgets.scale());
    ImGui::SameLine();
    saves |= widgets.button(fmt::format("solid.{}.save", name), "save");
    return saves;
  };
  const bool is_saved = panel.document.control_file() != nullptr;
  if (file(is_saved ? "control mesh (.vtu)" : "control mesh (.vtu), not saved yet", "control",
           &state.control_path))
    panel.wishes.saves_control = true;
  if (file("kernels (.ply)", "kernels", &state.kernels_path)) panel.wishes.saves_kernels = true;
}

}  // namespace

void solid_panel(Panel& panel) {
  ImGui::TextWrapped("Hexahedra with a density at each vertex stand for a smooth solid.");
  bool is_shown = panel.document.view.solid.has_value();
  if (panel.widgets.checkbox("solid.show", "show as a solid", &is_shown))
    panel.wishes.shows_solid = is_shown;
  if (!panel.document.view.solid) return;
  shape_of_solid(panel);
  ImGui::Separator();
  vertex_of_solid(panel);
  ImGui::Separator();
  files_of_solid(panel);
}

}  // namespace ovoid::viewer
