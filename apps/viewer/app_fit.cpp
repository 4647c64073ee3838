// SPDX-License-Identifier: Apache-2.0
// Fewer kernels for what is shown: begun, taken over, saved.
#include <algorithm>
#include <filesystem>
#include <utility>

#include "app.h"
#include "check_files.h"
#include "command.h"
#include "ovoid/io.h"
#include "usage.h"

namespace ovoid::viewer {

void App::grant_fit(const Wishes& wishes) {
  if (wishes.cancels_fit) fitter_->cancel();
  if (wishes.fit && document_.is_open()) {
    panel_state_.fit.error.clear();
    fitter_->start({document_.shown, fit_words(document_, *wishes.fit, panel_state_.fit.path),
                    model_of(document_), document_.setup});
  }
  if (document_.fit == nullptr) return;
  if (wishes.saves_fit) save_fit();
  if (wishes.copies_fit) {
    cli::Words words = {"ovoid", "fit"};
    words.insert(words.end(), document_.fit->words.begin(), document_.fit->words.end());
    words.back() = panel_state_.fit.path;  // of the output
    window_.set_clipboard(cli::quoted(words));
    tell("the command is in the clipboard");
  }
}

void App::take_fit() {
  const FitProgress before = std::exchange(status_.fit, fitter_->progress());
  if (before.is_running != status_.fit.is_running || before.fraction != status_.fit.fraction)
    frames_due_ = std::max(frames_due_, 2);
  std::optional<FitOutcome> outcome = fitter_->take();
  if (!outcome) return;
  panel_state_.fit.error = outcome->error;
  if (outcome->fitted == nullptr) return tell("fit: " + outcome->error, true);
  panel_state_.fit.saved.clear();
  document_.fit = std::move(outcome->fitted);
  const bool is_shown = document_.compare_with == CompareWith::kFit;
  if (!is_shown || document_.compare == CompareMode::kOff)
    document_.compare = CompareMode::kSideBySide;
  document_.compare_with = CompareWith::kFit;
  document_.touch_other();
}

// As `ovoid fit` would write it. Throws Error and cli::UsageError.
void App::save_fit() {
  FitState& fit = panel_state_.fit;
  cli::check_fit_ending(fit.path, *document_.shown->dataset);
  cli::check_files(cli::volume_inputs(document_.launch->data.inputs),
                   cli::volume_outputs("--output", fit.path));
  write_file(fit.path, document_.fit->bytes);
  fit.saved = fit.path;
  tell("fit written to " + std::filesystem::absolute(fit.path).string());
}

}  // namespace ovoid::viewer
