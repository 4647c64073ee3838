// SPDX-License-Identifier: Apache-2.0
#include "launch.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <tuple>
#include <utility>

#include "state_file.h"
#include "state_words.h"
#include "usage.h"
#include "values.h"

namespace ovoid::viewer {
namespace {

void add_window_flags(cli::Flags& flags, Launch* launch) {
  flags.section("window");
  flags.value("--size", "WIDTHxHEIGHT", "of the picture, pixels (default 1280x720)",
              [launch](const std::string& text) {
                RenderOptions& options = launch->drawing.options;
                std::tie(options.width, options.height) =
                    cli::parse_size(text, RenderOptions::kMaxImageSide);
              });
  flags.value("--background", "R,G,B", "each in [0, 1] (default 0.05,0.055,0.065)",
              [launch](const std::string& text) {
                if (text != "none") launch->drawing.background = cli::parse_rgb(text);
              });
  flags.toggle("--no-marks", "begin without axes and colour bar, which are there otherwise",
               &launch->has_marks, false);
  flags.value("--state", "FILE.json",
              "inputs and flags from a file that was saved; those that stand on the command line "
              "beat it",
              [launch](const std::string& text) { launch->state = text; });
  flags.toggle("--no-panel", "begin with the picture alone (Tab shows the panel)",
               &launch->has_panel, false);
  flags.toggle("--watch", "read the files again when they change", &launch->watches);
  flags.value("--script", "FILE", "replay the input that FILE describes (docs/viewer.md)",
              [launch](const std::string& text) { launch->script = text; });
  flags.value("--record", "FILE", "write the input to FILE, for --script",
              [launch](const std::string& text) { launch->record = text; });
  flags.value("--report", "FILE", "write measured times to FILE (JSON) at the end",
              [launch](const std::string& text) { launch->report = text; });
}

// The window's own flags, and all other words, which are those of `ovoid render`.
std::pair<std::vector<std::string>, std::vector<std::string>> own_and_others(
    const std::vector<std::string>& words) {
  static constexpr std::array<std::string_view, 3> kToggles = {"--no-panel", "--no-marks",
                                                               "--watch"};
  static constexpr std::array<std::string_view, 3> kValues = {"--script", "--record", "--report"};
  const auto is_in = [](const auto& names, std::string_view word) {
    return std::find(names.begin(), names.end(), word) != names.end();
  };
  std::vector<std::string> own;
  std::vector<std::string> others;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string& word = words[i];
    const std::string_view name = std::string_view(word).substr(0, word.find('='));
    if (word == "--") {
      others.insert(others.end(), words.begin() + static_cast<std::ptrdiff_t>(i), words.end());
      break;
    }
    const bool is_own = is_in(kToggles, name) || is_in(kValues, name);
    (is_own ? own : others).push_back(word);
    const bool is_apart = is_in(kValues, word) && i + 1 < words.size();
    if (is_apart) own.push_back(words[++i]);
  }
  return {own, others};
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
  add_window_flags(flags, launch.get());
  cli::add_drawing_flags(flags, &launch->drawing);
  cli::add_switch_flags(flags, &launch->drawing.options);
  flags.footer("Keys and mouse: press ? in the window, or see docs/viewer.md.");
  auto [own, all] = own_and_others(words);
  all = cli::with_state(all);
  own.insert(own.end(), all.begin(), all.end());
  if (!flags.parse(own)) return nullptr;
  // A state says which marks it has.
  if (launch->has_marks && launch->state.empty())
    launch->drawing.annotation.axes = launch->drawing.annotation.color_bar = true;
  if (!launch->state.empty()) launch->window = cli::read_state(launch->state).window;
  if (!launch->data.inputs.empty()) cli::require_inputs(flags, launch->data);
  cli::check_drawing_flags(flags, launch->drawing, "picture.png");
  return launch;
}

}  // namespace ovoid::viewer
