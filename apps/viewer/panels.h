// SPDX-License-Identifier: Apache-2.0
// The tabs beside the picture. Each edits the document at once, and asks for what it cannot do by
// itself.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "curve_editor.h"
#include "document.h"
#include "memory.h"
#include "region_editor.h"
#include "widgets.h"

namespace ovoid::viewer {

// What the desktop's dialog is asked for.
enum class Browsing { kNothing, kInput, kLook, kState, kBeside };

// What a person asked for with a button or a key, to be done after the frame.
struct Wishes {
  std::optional<ArrayChoice> array;
  bool goes_to_time = false;  // the document's time has changed
  bool counts_2d = false;     // values and gradients of what is shown
  std::optional<Theme> theme;
  std::optional<std::size_t> open_recent;  // its number in the list
  bool forgets_recent = false;
  Browsing browses = Browsing::kNothing;
  std::optional<cli::Words> fit;  // is begun, with this goal
  bool cancels_fit = false;
  bool copies_fit = false;  // its command
  bool saves_fit = false;
  std::optional<bool> shows_solid;
  bool saves_control = false, saves_kernels = false;  // of the solid
  bool copies_command = false;
  bool saves_picture = false;
  std::string open;                     // a file of data
  std::string add_labels;               // a file that is to be taken for them
  std::string add_beside;               // a file
  std::string read_look, write_look;    // paths
  std::string read_state, write_state;  // paths
};

// The goals of a fit, in the order of their list.
enum class FitGoal { kPsnr, kTolerance, kKernels, kBytes, kSmooth };

struct FitState {
  FitGoal goal = FitGoal::kPsnr;
  double psnr = 45;       // dB
  double tolerance = 1;   // % of the range
  double kernels = 5000;  // whole
  double kib = 500;       // whole
  std::string path;       // where it is saved; empty: usual_fit_path()
  std::string error;      // why there is none
  std::string saved;      // where the last one was
};

// Of looks by value and gradient.
struct RegionsState {
  RegionEditing editing;
  bool awaits_first = false;  // the first region, until what it is made from is counted
  // What was left for curves, for the way back.
  std::optional<TransferFunction2D> left;
  std::string left_array;
  int left_component = 0;
  bool is_left_by_mode = false;
  double occlusion = 0, shadows = 0;  // of the curves: beside such a look they must be 0

  bool has_left(const Shown& shown) const;
};

// What the interface remembers that is no property of the picture.
struct PanelState {
  CurveEditing opacity, gradient, colors;
  RegionsState regions;
  bool is_log_count = true;
  bool is_magnified = true;
  std::string look_path = "look.json";
  std::string state_path = "state.json";
  std::string open_path;
  std::string color_map;              // that was chosen last; empty: none
  std::vector<OpacityPoint> layered;  // opacities before a mode in which one sample makes the pixel
  bool has_handles = true;            // of crop, planes and slices, in the picture
  std::string beside_path;
  std::string label_filter;
  std::array<CurveEditing, cli::kMostOver> volume_opacities;
  std::array<std::string, cli::kMostOver> volume_maps;  // chosen last; empty: none
  std::string beside_error;                             // why the last one could not be read
  FitState fit;
  // Of a solid.
  bool has_vertices = true;    // in the picture
  int vertex = -1;             // the chosen one; -1: none
  std::string vertex_refusal;  // why it was not moved on
  std::string control_path = "control.vtu";
  std::string kernels_path = "solid.ply";
};

// What the program tells of the picture that is shown.
struct Status {
  FrameProfile profile;
  Level level;
  double picture_ms = 0;
  double pictures_per_second = 0;
  double interface_ms = 0;
  bool is_final = false;
  double psnr = 0;  // of a comparison
  std::size_t resident_bytes = 0;
  Size picture;
  Theme theme = Theme::kDark;
  bool is_browsing = false;
  FitProgress fit;
};

struct Panel {
  Document& document;
  Widgets& widgets;
  PanelState& state;
  Wishes& wishes;
  const Status& status;
  const Memory& memory;
};

void data_panel(Panel& panel);
void look_panel(Panel& panel);
void space_panel(Panel& panel);
void scene_panel(Panel& panel);
// Of the scene.
void labels_editor(Panel& panel);
void channels_editor(Panel& panel);
void volumes_editor(Panel& panel);
void time_panel(Panel& panel);
void compare_panel(Panel& panel);
void quality_panel(Panel& panel);
void fit_panel(Panel& panel);
void solid_panel(Panel& panel);

// NAME-fit.ply, or of a lattice NAME-fit.h5, by the name of the data.
std::string usual_fit_path(const Document& document);

// Looks by value and gradient. Why what is shown cannot have one; empty: it can.
std::string why_not_2d(const Document& document);
// The button that makes one of curves, and the editor that stands in the place of the curves';
// whether the look changed.
bool way_to_regions(Panel& panel);
bool regions_editor(Panel& panel);
// Takes the function away, and remembers it for the way back.
void leave_2d(Panel& panel);
// Other modes know no gradients: curves are drawn in them, and the function comes back after them.
void change_mode_2d(Panel& panel, Mode mode);

// The span and scale of curves by numbers; colours by a map's name, over the span that they have.
bool range_editor(Panel& panel, const std::string& name, TransferFunction& tf);
void take_color_map(TransferFunction& tf, const std::string& name);
// From the least to the greatest of the values that are there and those that the curve names.
ValueAxis axis_of(const TransferFunction& tf, const ValueRange& range);

Rgb in_bytes(const Rgb& rgb);  // as #rrggbb has it

// One of the built-in colour maps, each of which has a strip of its colours in the list; true where
// `map` changed. A `map` that has no name of theirs is none of the list's.
bool choose_color_map(Widgets& widgets, const std::string& name, const char* label,
                      std::string* map);

// Which of two pictures is shown, and how: a list of four by the name, none of them with `with`
// where something else is compared; then what can be done, and how far apart the pictures are.
void compare_choice(Panel& panel, const std::string& name, CompareWith with,
                    const std::vector<const char*>& options);

// "fast", "normal", "fine", "finest", or "by number" where the sampling distance is another one.
std::string quality_name(const Document& document);

// The transport of the time, also under the picture; whether it is to be gone to.
bool step_time(Document& document, int steps);

// What stands around the number of a time: its unit and, at a step, which one it is. Steps count
// from 0, as for --step. Where times are but the steps' numbers, the number stands once: "2.5 s
// (step 3 of 0 to 3)", "step 3 of 0 to 3", "2.5".
struct TimeLabel {
  std::string before, after;
  std::string format() const;  // printf's, of the number
};
TimeLabel time_label(const std::vector<double>& times, const std::string& unit, double time);

}  // namespace ovoid::viewer
