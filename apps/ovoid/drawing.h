// SPDX-License-Identifier: Apache-2.0
// What `render` and `animate` share: the steps from a dataset to the file.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "check_files.h"
#include "draw_marks.h"
#include "make_field.h"
#include "ovoid/renderer.h"
#include "settings.h"

namespace ovoid::cli {

// The files that are read: the data's, the look's and the camera's.
std::vector<InputFile> files_to_read(const DataFlags& data, const DrawingFlags& drawing);

// Data made ready to be drawn.
struct Subject {
  Modelled modelled;
  Described described;  // all but the box
  std::string unit;     // of what gives opacity
};

// Refuses flags that are for other data, and makes the field: of labels that nobody said anything
// about with narrow kernels, which `drawing` then has. The field keeps what it needs of `dataset`.
// Throws Error.
Subject make_subject(const Dataset& dataset, const Flags& flags, DrawingFlags* drawing,
                     Session& session);

// Of an x-ray's picture, 0 included.
std::pair<double, double> range_of_integrals(const Image& image);
// Spreads the colours of `tf` over the integrals of an x-ray's picture, or over the given range,
// and tells which.
void spread_over_integrals(TransferFunction& tf, const Image& image, const LookFlags& flags,
                           Session& session);
// Turns integrals into colours, which PNG wants.
void color_integrals(Image& image, const TransferFunction& tf);

// The frame that the flags ask for: with a trail (null: none), or with their value plane.
Frame draw_frame(Renderer& renderer, const Field& field, const Camera& camera, const Look& look,
                 const Trail* trail, const DrawingFlags& drawing, const RenderOptions& options,
                 const RenderHooks& hooks);

bool is_empty(const Image& image);
// Why there may be nothing in it.
std::string cause_of_emptiness(const Look& look, const ValueRange& range);

struct PictureFile {
  std::string path;
  std::stop_token stop;  // of its writing
};

// The marks, and the file.
void write_picture(Image& image, const DrawingFlags& drawing, const Described& described,
                   const Camera& camera, const Look& look, const PictureFile& file);

}  // namespace ovoid::cli
