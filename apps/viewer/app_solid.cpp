// SPDX-License-Identifier: Apache-2.0
// A control mesh's solid: shown, made anew where its vertices were moved, saved.
#include <fmt/format.h>

#include <filesystem>

#include "app.h"
#include "check_files.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "usage.h"

namespace ovoid::viewer {

void App::grant_solid(const Wishes& wishes) {
  if (!document_.is_open()) return;
  if (wishes.shows_solid) {
    panel_state_.vertex = -1;
    SolidChoice choice;
    if (*wishes.shows_solid) choice.shape.emplace();
    choice.wants_look = true;
    progress_ = LoadProgress{"choosing kernels", 0};
    loader_->show_solid(choice);
  }
  if (!document_.view.solid) return;
  const auto check = [&](const std::string& path, const char* ending) {
    if (!cli::has_ending(path, ending))
      throw cli::UsageError(fmt::format("'{}': expected a name that ends in {}", path, ending));
    cli::check_files(cli::volume_inputs(document_.launch->data.inputs),
                     cli::volume_outputs("--output", path));
  };
  if (wishes.saves_control) {
    const std::string& path = panel_state_.control_path;
    check(path, ".vtu");
    document_.save_control(path);
    tell("control mesh written to " + std::filesystem::absolute(path).string());
  }
  if (wishes.saves_kernels) {
    const std::string& path = panel_state_.kernels_path;
    check(path, ".ply");
    if (!document_.shown->is_of(document_.view.solid))
      throw Error(ErrorCode::kUnsupported, "the solid is still being made: save it a moment later");
    write_dataset(*document_.shown->dataset, path);
    tell("kernels written to " + std::filesystem::absolute(path).string());
  }
}

// What the view says is shown as soon as the loader has it: while a vertex is held as well as it
// can follow the mouse, and when it is let go once more as it is.
void App::ask_for_solid() {
  if (!document_.is_open()) return;
  const SolidChoice choice{document_.view.solid, false, is_moving_};
  const bool is_there = document_.shown->solid == document_.view.solid;
  const bool is_let_go = asked_solid_ && asked_solid_->is_moving && !is_moving_;
  if (is_there && !is_let_go) {
    if (!is_moving_) asked_solid_.reset();
    return;
  }
  if (asked_solid_ == choice) return;
  asked_solid_ = choice;
  loader_->show_solid(choice);
}

}  // namespace ovoid::viewer
