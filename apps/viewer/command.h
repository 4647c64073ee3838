// SPDX-License-Identifier: Apache-2.0
// From the window to a script: the flags of `ovoid render` that draw what is shown.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "document.h"
#include "flag_set.h"

namespace ovoid::viewer {

// A state has hidden surfaces, too, for the window to show again.
enum class FlagsFor { kCommand, kState };

// The flags that draw the document's picture in that size, byte for byte on the same back end:
// those that it was opened with, but for what has been changed since.
cli::FlagSet flags_of(const Document& document, Size size, FlagsFor use = FlagsFor::kCommand);

// A line for a shell, with the flags and -o picture.png; of a solid it makes that first. Of a
// control mesh that no file holds a comment that says so.
std::string command_of(const Document& document, Size size);
bool has_command(const Document& document);
inline constexpr const char* kNoCommand =
    "the control mesh was changed and is not saved: save it (tab solid), then copy the command";

// The words behind `ovoid fit` that make a fit of what is shown; `goal` is a flag with its value.
cli::Words fit_words(const Document& document, const cli::Words& goal, const std::string& output);

// The model flags of what is shown.
cli::ModelFlags model_of(const Document& document);

// What a state keeps beside them: how time runs, and how opaque hidden surfaces will be.
nlohmann::ordered_json window_state(const Document& document);
// Takes what is there and makes sense, and leaves the rest as it is.
void take_window_state(const nlohmann::ordered_json& window, Document& document);

// The crop as flags have it: the view's, or else the one that the data were opened with.
cli::CropFlags crop_of(const Document& document);

}  // namespace ovoid::viewer
