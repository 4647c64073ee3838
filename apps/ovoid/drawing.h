// SPDX-License-Identifier: Apache-2.0
// What `render` and `animate` share: the steps from a dataset to the file.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "check_files.h"
#include "draw_marks.h"
#include "make_field.h"
#include "make_look.h"
#include "ovoid/renderer.h"
#include "ovoid/scene.h"
#include "settings.h"

namespace ovoid::cli {

// The files that are read: the data's, the look's and the camera's.
std::vector<InputFile> files_to_read(const DataFlags& data, const DrawingFlags& drawing);

// Data made ready to be drawn.
struct Subject {
  Modelled modelled;
  Described described;  // all but the box
  std::string unit;     // of what gives opacity
  UsualLook usual_look;
  // What the picture is of: the field first, which ends at its boundary (a mesh's or boxes', or
  // that of --within), what is drawn with it, and what stands beside it. The field's look is not
  // known yet.
  Scene scene;
  bool has_walls = false;   // the boundary may be seen: a mesh's, that of --within
  bool has_points = false;  // may be drawn as balls: particles and kernels

  const Field& field() const { return modelled.field; }
  const Surface* boundary() const { return scene.volumes.front().boundary.get(); }
};

// Of a mesh or boxes, or of the mesh of --within, with the values of what was modelled. Null if
// there is none. Throws Error where it was asked for and there is none.
std::shared_ptr<const Surface> surface_of(const Dataset& dataset, const DrawingFlags& drawing,
                                          const Modelled& modelled, Session& session);

// The same surface with the values of another field at its places.
std::shared_ptr<const Surface> surface_with_values(const Surface& surface, const Field& field,
                                                   const Session& session);

// What is seen of a mesh's boundary, as Volume::walls has it. Where the flags do not say, and say
// nothing that is about the inside: opaque if its outside shows a quarter of the field's range or
// more, or if there is nothing inside; else see-through if all of it does; else not at all. With
// clip planes what is opaque stays so, and has lids. Of what is no mesh not at all.
SurfaceStyle surface_to_draw(const Subject& subject, const DrawingFlags& drawing);

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

// Whether a mesh's boundary is all that is seen, lids of cuts aside.
bool shows_boundary_alone(const Scene& scene);

// What the flags ask for instead of the field; none: the field. Of particles and kernels.
std::optional<PointStyle> points_to_draw(const PointFlags& points);

bool is_empty(const Image& image);
// Why there may be nothing in it.
std::string cause_of_emptiness(const Look& look, const ValueRange& range);

// The ending of a picture's name; empty if it is none's.
std::string picture_ending(const std::string& path);
inline constexpr const char* kPictureEndings = ".png, .jpg, .exr or .npy";
// Of pictures for people: with a background and marks, x-rays in colours.
bool is_for_eyes(const std::string& path);
// Throws UsageError where the picture can have no transparent background that was asked for.
void check_background(const DrawingFlags& drawing, const std::string& output);

struct PictureFile {
  std::string path;
  std::stop_token stop;  // of its writing
};

// The marks, and the file.
void write_picture(Image& image, const DrawingFlags& drawing, const Described& described,
                   const Camera& camera, const Look& look, const PictureFile& file);

}  // namespace ovoid::cli
