// SPDX-License-Identifier: Apache-2.0
#include "make_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>
#include <utility>

#include "load.h"
#include "make_field.h"
#include "make_look.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/model.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

constexpr const char* kOthers = "others";
constexpr const char* kSegmentation = ".seg.nrrd";

std::optional<int> number_of(const std::string& text) {
  int number = 0;
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, number);
  if (result.ec != std::errc{} || result.ptr != end) return std::nullopt;
  return number;
}

// ASCII letters alone.
std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

// Some of the names that there are, for a message.
std::string some_labels(const std::vector<LabelStyle>& styles) {
  constexpr std::size_t kMost = 12;
  std::string text;
  for (std::size_t i = 0; i < styles.size() && i < kMost; ++i) {
    const LabelStyle& style = styles[i];
    text += fmt::format("{}{}{}", i == 0 ? "" : ", ", style.label,
                        style.name.empty() ? "" : fmt::format(" ({})", style.name));
  }
  return styles.size() > kMost ? text + ", ..." : text;
}

// Whether a flag means the label, by number or name, in capitals or not.
bool means(const std::string& text, const LabelStyle& style) {
  const auto number = number_of(text);
  return number ? style.label == *number : lower(style.name) == lower(text);
}

LabelStyle& named_style(std::vector<LabelStyle>& styles, const std::string& name,
                        const std::string& flag) {
  const auto found = std::find_if(styles.begin(), styles.end(),
                                  [&](const LabelStyle& style) { return means(name, style); });
  if (found == styles.end()) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("{} {}: there is no such label, but {}",
                                                         flag, name, some_labels(styles)));
  }
  return *found;
}

}  // namespace

void show_on_slices(LabelSurfaces& surfaces, SliceLabels what) {
  constexpr double kTint = 0.35;  // under lines
  surfaces.slice_lines = what == SliceLabels::kLines || what == SliceLabels::kBoth ? 1 : 0;
  surfaces.slice_areas = what == SliceLabels::kAreas ? 1 : what == SliceLabels::kBoth ? kTint : 0;
}

SliceLabels shown_on_slices(const LabelSurfaces& surfaces) {
  if (surfaces.slice_lines > 0)
    return surfaces.slice_areas > 0 ? SliceLabels::kBoth : SliceLabels::kLines;
  return surfaces.slice_areas > 0 ? SliceLabels::kAreas : SliceLabels::kNone;
}

void leave_slices_to_labels(const LabelSurfaces& surfaces, std::vector<FieldSlice>& slices) {
  const bool are_the_data = surfaces.map != nullptr && !surfaces.shows_field_elsewhere &&
                            std::none_of(surfaces.styles.begin(), surfaces.styles.end(),
                                         [](const LabelStyle& style) { return style.shows_field; });
  if (!are_the_data || surfaces.slice_areas == 0) return;
  for (FieldSlice& slice : slices) slice.colors.opacities = {{0, 0}};
}

void style_labels(std::vector<LabelStyle>& styles, const LabelFlags& flags) {
  for (const auto& [name, rgb] : flags.colors)
    named_style(styles, name, "--label-color").color = rgb;
  std::set<int> named;
  for (const auto& [name, opacity] : flags.opacities) {
    if (name == kOthers) continue;
    LabelStyle& style = named_style(styles, name, "--label-opacity");
    style.opacity = opacity;
    named.insert(style.label);
  }
  for (const auto& [name, opacity] : flags.opacities) {
    if (name != kOthers) continue;
    for (LabelStyle& style : styles)
      if (!named.contains(style.label) && style.opacity > 0) style.opacity = opacity;
  }
}

namespace {

bool has_own_opacity(const LabelFlags& flags, const LabelStyle& style) {
  return std::any_of(flags.opacities.begin(), flags.opacities.end(),
                     [&](const auto& named) { return means(named.label, style); });
}

// Where the field is drawn.
void set_field(LabelSurfaces& surfaces, const LabelFlags& flags) {
  if (!flags.inside.empty()) {
    surfaces.shows_field_elsewhere = false;
    for (LabelStyle& style : surfaces.styles) style.shows_field = false;
    for (const std::string& name : flags.inside) {
      LabelStyle& style = named_style(surfaces.styles, name, "--inside-labels");
      style.shows_field = true;
      if (!has_own_opacity(flags, style)) style.opacity = 0;
    }
  }
  for (const std::string& name : flags.outside)
    named_style(surfaces.styles, name, "--outside-labels").shows_field = false;
}

// `flag`: that asks for them, for messages. `table`: the file's own, which that of the flags beats.
LabelSurfaces surfaces_for(const std::string& flag, const Field& field, const std::string& source,
                           const std::vector<LabelEntry>& table, const DrawingFlags& drawing,
                           const Session& session) {
  LabelSurfaces surfaces;
  try {
    surfaces.map = make_label_map(*field.lattice(), drawing.run.threads, session.stop());
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kCancelled) throw;
    throw Error(error.code(), fmt::format("{}: '{}': {}", flag, source, error.what()));
  }
  const std::string& own = drawing.labels.table;
  surfaces.styles = label_styles(*surfaces.map, own.empty() ? table : table_of_flag(own));
  style_labels(surfaces.styles, drawing.labels);
  surfaces.shows_surfaces = !drawing.labels.are_flat;
  return surfaces;
}

}  // namespace

bool may_draw_own_labels(const DrawingFlags& drawing) {
  return uses_default_look(drawing.look) && drawing.labels.file.empty() && !drawing.plane &&
         !drawing.trail.length;
}

bool is_segmentation(const Dataset& dataset) {
  return dataset.kind == DatasetKind::kLattice && has_ending(dataset.source, kSegmentation);
}

std::vector<LabelEntry> table_of_file(const std::string& source, int layer) {
  if (!has_ending(source, kSegmentation)) return {};
  return read_label_table(source, layer);
}

std::vector<LabelEntry> table_of_flag(const std::string& value) {
  return is_json(value) ? label_table_from_text(value, "--label-table") : read_label_table(value);
}

std::optional<MergedLayers> merged_layers(const Dataset& dataset, int component) {
  const int num_layers = dataset.arrays.empty() ? 1 : dataset.arrays.front().num_components;
  if (!is_segmentation(dataset) || num_layers < 2 || component != kUsualComponent)
    return std::nullopt;
  std::vector<std::vector<LabelEntry>> tables;
  tables.reserve(static_cast<std::size_t>(num_layers));
  for (int layer = 0; layer < num_layers; ++layer)
    tables.push_back(table_of_file(dataset.source, layer));
  return merge_layers(dataset, tables);
}

LabelSurfaces make_own_labels(const Field& field, const std::string& source,
                              const std::vector<LabelEntry>& table, const DrawingFlags& drawing,
                              Session& session) {
  LabelSurfaces surfaces = surfaces_for("--label-surfaces", field, source, table, drawing, session);
  surfaces.shows_field_elsewhere = false;
  for (LabelStyle& style : surfaces.styles) style.shows_field = false;
  show_on_slices(surfaces, drawing.labels.on_slices.value_or(SliceLabels::kAreas));
  return surfaces;
}

std::map<int, std::string> names_of(const std::vector<LabelStyle>& styles) {
  std::map<int, std::string> names;
  for (const LabelStyle& style : styles)
    if (!style.name.empty()) names.emplace(style.label, style.name);
  return names;
}

LabelSurfaces own_labels_of_step(const Field& field, const LabelSurfaces& before, int threads,
                                 const Session& session) {
  LabelSurfaces surfaces = before;
  surfaces.map = make_label_map(*field.lattice(), threads, session.stop());
  std::set<int> known;
  for (const LabelStyle& style : before.styles) known.insert(style.label);
  for (LabelStyle& style : label_styles(*surfaces.map)) {
    if (known.contains(style.label)) continue;
    style.shows_field = false;
    surfaces.styles.push_back(std::move(style));
  }
  return surfaces;
}

Dataset read_labels(const std::string& path, Session& session) {
  DataFlags data;
  data.inputs = {path};
  const Quiet quiet(session);
  return load(data, session);
}

LabelSurfaces make_labels_of(const Dataset& dataset, const DrawingFlags& drawing,
                             Session& session) {
  if (dataset.kind != DatasetKind::kLattice) refuse_kind("--labels", "lattices", dataset);
  LatticeModelOptions options;
  options.kernel = kLabelKernel;
  options.threads = drawing.run.threads;
  const auto merged = merged_layers(dataset, kUsualComponent);
  const Field field =
      make_lattice_field(merged ? merged->dataset : dataset, options, nullptr, session.stop());
  const auto table = merged ? merged->table : table_of_file(dataset.source, 0);
  LabelSurfaces surfaces = surfaces_for("--labels", field, dataset.source, table, drawing, session);
  set_field(surfaces, drawing.labels);
  show_on_slices(surfaces, drawing.labels.on_slices.value_or(SliceLabels::kLines));
  return surfaces;
}

LabelSurfaces make_labels_beside(const DrawingFlags& drawing, Session& session) {
  if (drawing.labels.file.empty() || drawing.labels.is_read_apart) return {};
  return make_labels_of(read_labels(drawing.labels.file, session), drawing, session);
}

}  // namespace ovoid::cli
