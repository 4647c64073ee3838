// SPDX-License-Identifier: Apache-2.0
// What `render` and `animate` share: the flags that make a picture of data, and the steps from a
// dataset to the file.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "annotation_flags.h"
#include "camera_flags.h"
#include "check_files.h"
#include "crop_flags.h"
#include "data_flags.h"
#include "environment.h"
#include "look_flags.h"
#include "model_flags.h"
#include "ovoid/renderer.h"
#include "render_flags.h"
#include "trail_flags.h"

namespace ovoid::cli {

struct DrawingFlags {
  std::optional<std::array<double, 3>> background;
  ModelFlags model;
  LookFlags look;
  CameraFlags camera;
  CropFlags crop;
  AnnotationFlags annotation;
  RenderOptions options;
  TrailFlags trail;
  std::optional<ValuePlane> plane;
  RendererSetup run = setup_of_environment();
  TimeFilter time_filter = TimeFilter::kTwoSteps;  // as DataFlags has it
};

// --size and --background, in the section that is open.
void add_size_flags(Flags& flags, DrawingFlags* drawing);
// All others, section by section, from the marks to section "running", which stays open.
void add_drawing_flags(Flags& flags, DrawingFlags* drawing);

// Throws UsageError for contradictions. `output`: the name of a picture; empty if none is written.
void check_drawing_flags(const Flags& flags, const DrawingFlags& drawing,
                         const std::string& output);

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
