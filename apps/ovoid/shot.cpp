// SPDX-License-Identifier: Apache-2.0
#include "shot.h"

#include "apply_crop.h"
#include "make_camera.h"
#include "make_channels.h"
#include "make_look.h"
#include "make_over.h"
#include "make_trail.h"

namespace ovoid::cli {

Shot make_shot(const Subject& subject, DrawingFlags* drawing, Session& session) {
  const Field& field = subject.field();
  Shot shot;
  shot.described = subject.described;
  shot.described.box = apply_crop(drawing->crop, field, &drawing->options);
  shot.scene = subject.scene;
  Volume& volume = shot.scene.volumes.front();
  volume.look = make_look(drawing->look, field, subject.unit, session, subject.usual_look);
  leave_colors_to_channels(*drawing, &volume.look);
  note_on_marks(drawing->annotation, volume.look, session);
  volume.walls = surface_to_draw(subject, *drawing);
  if (subject.has_points) volume.points = points_to_draw(drawing->points);
  return shot;
}

void aim_camera(Shot* shot, const DrawingFlags& drawing) {
  const RenderOptions& options = drawing.options;
  const double aspect = static_cast<double>(options.width) / options.height;
  Bounds3 bounds = bounds_with(shot->described.box.world_bounds(), shot->scene);
  const Trail* const trail = shot->scene.volumes.front().trail.get();
  if (drawing.camera.fit == Fit::kBox && trail != nullptr) bounds.extend(bounds_of(*trail));
  shot->camera = make_camera(
      drawing.camera, {shot->scene, bounds, shot->described.space, aspect, options.clip_planes});
}

void note_if_empty(const Image& image, const Shot& shot, const ValueRange& values,
                   Session& session) {
  if (is_empty(image)) session.note("nothing shows: " + cause_of_emptiness(shot.look(), values));
}

void color_for_eyes(Image& image, Look& look, const LookFlags& flags, Session& session) {
  if (look.mode != Mode::kXray) return;
  spread_over_integrals(look.transfer_function, image, flags, session);
  color_integrals(image, look.transfer_function);
}

}  // namespace ovoid::cli
