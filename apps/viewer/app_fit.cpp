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
  if (!document_.is_open()) return;
  const std::string& named = panel_state_.fit.path;
  const std::string path = named.empty() ? usual_fit_path(document_) : named;
  if (wishes.fit) {
    panel_state_.fit.error.clear();
    fitter_->start({document_.shown, fit_words(document_, *wishes.fit, path), model_of(document_),
                    document_.setup});
  }
  if (document_.fit == nullptr) return;
  if (wishes.saves_fit) save_fit(path);
  if (wishes.copies_fit) {
    cli::Words words = {"ovoid", "fit"};
    words.insert(words.end(), document_.fit->words.begin(), document_.fit->words.end());
    words.back() = path;  // of the output
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
void App::save_fit(const std::string& path) {
  cli::check_fit_ending(path, *document_.shown->dataset);
  cli::check_files(cli::volume_inputs(document_.launch->data.inputs),
                   cli::volume_outputs("--output", path));
  write_file(path, document_.fit->bytes);
  panel_state_.fit.saved = path;
  tell("fit written to " + std::filesystem::absolute(path).string());
}

}  // namespace ovoid::viewer
