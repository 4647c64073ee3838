// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ovoid/dataset.h"
#include "ovoid/field.h"
#include "ovoid/labels.h"
#include "ovoid/scene.h"
#include "session.h"
#include "settings.h"

namespace ovoid::cli {

// Whether labels that are the data themselves may be drawn by their surfaces: nobody asked for
// another look, or for what has no surfaces in it.
bool may_draw_own_labels(const DrawingFlags& drawing);

// Whether a file says by its name that it holds labels, however few.
bool is_segmentation(const Dataset& dataset);
// A segmentation's layers as one, unless there is one, or `component` asks for it (-1: does not).
std::optional<MergedLayers> merged_layers(const Dataset& dataset, int component);

// The surfaces of data that are labels; the field itself is then not drawn. `source`: the data's
// file. `table`: what it says of them. Throws Error.
LabelSurfaces make_own_labels(const Field& field, const std::string& source,
                              const std::vector<LabelEntry>& table, const DrawingFlags& drawing,
                              Session& session);
// The value of --label-table: a file, or JSON itself. Throws Error.
std::vector<LabelEntry> table_of_flag(const std::string& value);
// What a file says of the labels in one of its layers; nothing, if it is no segmentation.
std::vector<LabelEntry> table_of_file(const std::string& source, int layer);

// Of those that have one.
std::map<int, std::string> names_of(const std::vector<LabelStyle>& styles);

// The same for another step of the data, in the styles of `before`. Labels that are new have their
// own colours.
LabelSurfaces own_labels_of_step(const Field& field, const LabelSurfaces& before, int threads,
                                 const Session& session);

// What slices show of labels from now on.
void show_on_slices(LabelSurfaces& surfaces, SliceLabels what);
SliceLabels shown_on_slices(const LabelSurfaces& surfaces);
// Slices of data that are labels show these instead of their numbers, where they show areas.
void leave_slices_to_labels(const LabelSurfaces& surfaces, std::vector<FieldSlice>& slices);

// The colours and opacities that flags give to labels. Throws Error for a label that nobody knows.
void style_labels(std::vector<LabelStyle>& styles, const LabelFlags& flags);

// The file of --labels, and what is drawn of it. Throw Error.
Dataset read_labels(const std::string& path, Session& session);
LabelSurfaces make_labels_of(const Dataset& dataset, const DrawingFlags& drawing, Session& session);

// Of --labels, within the field; without it none. Throws Error, also for a file that holds no
// labels and for a label that nobody knows.
LabelSurfaces make_labels_beside(const DrawingFlags& drawing, Session& session);

}  // namespace ovoid::cli
