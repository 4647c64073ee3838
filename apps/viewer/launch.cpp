// SPDX-License-Identifier: Apache-2.0
#include "launch.h"

#include <utility>

#include "state_file.h"
#include "state_words.h"
#include "usage.h"

namespace ovoid::viewer {
namespace {

const cli::Table<Launch>& window_settings() {
  using cli::Toggle, cli::word;
  static const cli::Table<Launch> all = {
      {"--no-marks", Toggle{false}, &Launch::has_marks,
       "begin without axes and colour bar, which are there otherwise"},
      {"--state", word("FILE.json", cli::Content::kOfRun), &Launch::state,
       "inputs and flags from a file that was saved; those that stand on the command line beat it"},
      {"--no-panel", Toggle{false}, &Launch::has_panel,
       "begin with the picture alone (Tab shows the panel)"},
      {"--theme", cli::choice(theme_names()), &Launch::theme,
       "colours of the panel and of what is written over the picture (default: the one chosen last "
       "in the window, at first dark)"},
      {"--remember", word("FILE|none"), &Launch::remember,
       "where the theme, and what was opened last, are kept from one run to the next (default: "
       "ovoid/window.json in $XDG_STATE_HOME or ~/.local/state; with --script none)"},
      {"--watch", Toggle(), &Launch::watches, "read the files again when they change"},
      {"--script", word("FILE"), &Launch::script,
       "replay the input that FILE describes (docs/viewer.md)"},
      {"--record", word("FILE"), &Launch::record, "write the input to FILE, for --script"},
      {"--save-state", word("FILE.json"), &Launch::save_state,
       "write what is shown to FILE.json when the window is closed, for --state"},
      {"--report", word("FILE"), &Launch::report, "write measured times to FILE (JSON) at the end"},
  };
  return all;
}

cli::Table<cli::DrawingFlags> picture_settings() {
  cli::Table<cli::DrawingFlags> table = cli::picture_settings();
  table[0].flag.text = "of the picture, pixels (default 1280x720)";
  table[1].flag.form = "R,G,B";
  table[1].flag.text = "each in [0, 1] (default 0.05,0.055,0.065)";
  return table;
}

}  // namespace

std::shared_ptr<Launch> parse_launch(const std::vector<std::string>& words) {
  auto launch = std::make_shared<Launch>();
  launch->drawing.options.width = 1280;
  launch->drawing.options.height = 720;
  launch->flags = std::make_unique<cli::Flags>(
      "view", "[INPUT...] [FLAG...]",
      "Shows a volume, mesh, particles or kernels in a window, to look around in.");
  cli::Flags& flags = *launch->flags;
  cli::add_input_flags(flags, &launch->data);
  flags.section("window");
  flags.add(picture_settings(), &launch->drawing);
  flags.add(window_settings(), launch.get());
  cli::add_over_flags(flags, &launch->drawing);
  cli::add_drawing_flags(flags, &launch->drawing);
  flags.add(cli::switch_settings(), &launch->drawing.options);
  flags.footer("Keys and mouse: press ? in the window, or see docs/viewer.md.");
  if (!flags.parse(cli::with_state(words, flags.forms()))) return nullptr;
  // A state says which marks it has.
  if (launch->has_marks && launch->state.empty())
    launch->drawing.annotation.axes = launch->drawing.annotation.color_bar = true;
  if (!launch->state.empty()) launch->window = cli::read_state(launch->state).window;
  if (!launch->data.inputs.empty()) cli::require_inputs(flags, launch->data);
  cli::check_json_flags(launch->drawing);
  return launch;
}

}  // namespace ovoid::viewer
