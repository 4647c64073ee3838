// SPDX-License-Identifier: Apache-2.0
// ovoid render: data of any kind to a picture.

#include <fmt/format.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "check_files.h"
#include "command.h"
#include "console.h"
#include "drawing.h"
#include "dry_run.h"
#include "load.h"
#include "make_trail.h"
#include "ovoid/io.h"
#include "ovoid/model.h"
#include "ovoid/output_files.h"
#include "picking.h"
#include "picture_part.h"
#include "profile.h"
#include "shot.h"
#include "state_words.h"
#include "team.h"
#include "team_profile.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

constexpr int kMaxRepeat = 100'000;

struct RenderFlags {
  std::string output;
  std::string look_output;  // empty: not asked for
  std::string state;        // where some of the others come from; empty: the command line alone
  DataFlags data;
  DrawingFlags drawing;
  std::optional<PartChoice> part;  // none: the whole
  std::vector<PickedPixel> picks;
  std::string pick_file;  // empty: the picks on standard output
  int repeat = 0;         // 0: one frame, the one that is written
  bool dry_run = false;
  bool profile = false;
  std::string profile_file;  // empty: a table on standard error
};

const Table<RenderFlags>& state_settings() {
  static const Table<RenderFlags> all = {
      {"--state", word("FILE.json", Content::kOfRun), &RenderFlags::state,
       "inputs and flags from a file that the viewer or a script has saved; those that stand on "
       "the command line beat it"},
  };
  return all;
}

std::optional<std::string> is_lattice(const std::string& sheets) {
  return sheets == "lattice" ? std::optional(sheets) : std::nullopt;
}

const Table<RenderFlags>& output_settings() {
  static const Table<RenderFlags> all = {
      {"-o,--output", word("OUT", Content::kOfRun), &RenderFlags::output,
       fmt::format("the picture: {}", kPictureEndings)},
      {"--save-look", word("FILE.json", Content::kOfRun), &RenderFlags::look_output,
       "the look that the picture has, to be changed and given to --tf",
       not_with("dry-run", "nothing is written")},
      {"--part",
       {"K/N",
        [](RenderFlags& render, const std::string& text) { render.part = parse_part(text); },
        {},
        Content::kOfRun},
       "draw part K of N of the picture, to a deep OpenEXR file; ovoid composite puts all N "
       "together",
       not_with("value-plane motion-blur colorbar axes bounding-box scale-bar",
                "{0} needs a whole picture"),
       not_with("repeat dry-run profile opaque-at", "{0} is for whole pictures"),
       not_with("sheets", "is on image sheets alone", is_lattice)},
  };
  return all;
}

const Table<RenderFlags>& pick_settings() {
  using R = RenderFlags;
  static const Table<R> all = {
      {"--pick",
       {"X,Y",
        [](R& render, const std::string& text) { render.picks.push_back(parse_pixel(text)); },
        {},
        Content::kOfRun,
        true},
       "tell what this pixel shows, row 0 at the top: where in the world, value, gradient, label, "
       "depth (repeatable); needs no -o",
       not_with("part dry-run", "needs a whole picture, which {0} does not draw")},
      {"--pick-report", word("FILE.json", Content::kOfRun), &R::pick_file,
       "tell it there, as JSON, instead of on standard output",
       needs("pick", "has no effect without --pick X,Y")},
  };
  return all;
}

const Table<RenderFlags>& measure_settings() {
  using R = RenderFlags;
  static const Table<R> all = {
      {"--repeat", integer("N", 1, kMaxRepeat), &R::repeat,
       "time N frames after one to warm up, the camera turned by 0.01 degree each"},
      {"--profile",
       {"[=FILE.json]",
        [](R& render, const std::string& text) {
          render.profile = true;
          render.profile_file = text;
        },
        {},
        Content::kOfRun},
       "say where the time went, in a table or as JSON"},
      {"--dry-run", Toggle(), &R::dry_run,
       "read the data, tell what the picture will cost, and write nothing; needs no -o"},
  };
  return all;
}

void check_flags(const Flags& flags, const RenderFlags& render) {
  require_inputs(flags, render.data);
  if (render.output.empty() && !render.dry_run && render.picks.empty())
    throw UsageError(fmt::format("--output: none given, expected -o OUT{}", kPictureEndings));
  if (!render.output.empty() && picture_ending(render.output).empty()) {
    throw UsageError(fmt::format("--output '{}': expected a name that ends in {}", render.output,
                                 kPictureEndings));
  }
  if (render.part && picture_ending(render.output) != ".exr") {
    throw UsageError(fmt::format(
        "--part: '{}' cannot hold a part of a picture, expected -o NAME.exr", render.output));
  }
  check_pixels(render.picks, render.drawing.options);
  check_background(render.drawing, render.output);
  check_json_flags(render.drawing);
  std::vector<OutputFile> outputs;
  if (!render.output.empty()) outputs.push_back({"--output", render.output, render.output});
  if (!render.look_output.empty())
    outputs.push_back({"--save-look", render.look_output, render.look_output});
  if (!render.profile_file.empty())
    outputs.push_back({"--profile", render.profile_file, render.profile_file});
  if (!render.pick_file.empty())
    outputs.push_back({"--pick-report", render.pick_file, render.pick_file});
  std::vector<InputFile> inputs = files_to_read(render.data, render.drawing);
  if (!render.state.empty()) inputs.push_back({render.state, "the state of --state"});
  check_files(inputs, outputs);
}

// One frame for the picture, and with --repeat N more for the clock.
Image draw(const RenderFlags& render, const Scene& scene, const Camera& camera, RunProfile* profile,
           Session& session) {
  Renderer renderer(render.drawing.run);
  RenderOptions options = render.drawing.options;
  RenderHooks hooks;
  hooks.stop = session.stop();
  // Stage timers only where they disturb no measured time.
  options.collect_profile = render.profile && render.repeat == 0;
  Frame first = [&] {
    Progress progress("drawing");
    hooks.progress = progress.callback();
    return renderer.render(scene, camera, options, hooks);
  }();
  hooks.progress = nullptr;
  if (!first.profile.notice.empty()) session.note(first.profile.notice);
  profile->frame = first.profile;
  if (render.repeat == 0) {
    profile->frames_ms = {first.profile.frame_ms};
    return std::move(first.image);
  }
  Progress progress("timing");
  for (int i = 0; i < render.repeat; ++i) {
    Camera turned = camera;
    turned.azimuth(kTurnDegrees * i);
    profile->frames_ms.push_back(renderer.render(scene, turned, options, hooks).profile.frame_ms);
    progress.show((i + 1.0) / render.repeat);
  }
  if (render.profile) {
    options.collect_profile = true;
    profile->frame = renderer.render(scene, camera, options, hooks).profile;
  }
  return std::move(first.image);
}

// The one part of the picture that was asked for, as a file.
void write_part(const RenderFlags& render, const Scene& scene, const Camera& camera,
                Session& session) {
  Renderer renderer(render.drawing.run);
  Progress progress("drawing");
  RenderHooks hooks;
  hooks.stop = session.stop();
  hooks.progress = progress.callback();
  const PicturePart part =
      draw_part(renderer, scene, camera, render.drawing.options, *render.part, hooks, session);
  write_picture_part(part, render.output, {session.stop()});
}

// With other processes; none of what they have drawn but at the first.
std::optional<Image> draw_in_team(Team& team, const RenderFlags& render, const Scene& scene,
                                  const Camera& camera, const RunProfile& profile,
                                  Session& session) {
  team.agree(picture_lines(scene, camera, render.drawing.options) +
             fmt::format("profile {}\n", render.profile));
  RendererSetup run = render.drawing.run;
  if (run.threads == 0) run.threads = team.threads();
  const bool may_take_device = run.backend == Backend::kAuto || run.backend == Backend::kVulkan;
  if (may_take_device && run.device < 0 && team.beside() > 1)
    run.device = device_at_place(list_devices(run.vulkan), team.place());
  Renderer renderer(run);
  RenderHooks hooks;
  hooks.stop = session.stop();
  hooks.team = team.kernels();
  const Stopwatch drawing;
  const PicturePart part = draw_part(renderer, scene, camera, render.drawing.options,
                                     {team.number() + 1, team.count()}, hooks, session);
  const double draw_ms = drawing.ms();
  team.meet();
  std::optional<Team::Picture> picture = team.put_together(part.seen, part.look);
  if (render.profile)
    tell_stages(team, {profile.load_ms, profile.model_ms, draw_ms}, picture, render.profile_file);
  if (!picture) return std::nullopt;
  return std::move(picture->image);
}

// All that the picture is of.
std::vector<std::string> files_of(const RenderFlags& render) {
  std::vector<std::string> files = render.data.inputs;
  const DrawingFlags& drawing = render.drawing;
  for (const auto& more : {drawing.over.files, drawing.geometry.files})
    files.insert(files.end(), more.begin(), more.end());
  if (!drawing.labels.file.empty()) files.push_back(drawing.labels.file);
  return files;
}

// What can be drawn together.
void check_for_team(const Flags& flags, const RenderFlags& render) {
  if (render.part)
    throw UsageError("--part: was started by MPI, where each process has a part already");
  for (const char* const name :
       {"value-plane", "motion-blur", "repeat", "dry-run", "opaque-at", "pick"}) {
    if (flags.is_given(name))
      throw UsageError(
          fmt::format("--{}: is not for pictures by several processes, as MPI starts them", name));
  }
  if (render.drawing.options.sheets == Sheets::kLattice)
    throw UsageError("--sheets lattice: several processes draw on image sheets alone");
}

void tell_picks(const RenderFlags& render, const Subject& subject, const Shot& shot,
                const Image& image, Session& session) {
  if (render.picks.empty()) return;
  const Picker picker(shot, render.drawing.options);
  const PickWords words = pick_words(subject, shot, render.drawing.annotation);
  std::vector<Pick> picks;
  for (const auto& [x, y] : render.picks) picks.push_back(picker.at(image, x, y));
  if (!render.pick_file.empty()) {
    write_file(render.pick_file, picks_json(picker, picks, words, session.command_line()));
    return;
  }
  for (const Pick& pick : picks) write_out(pick_text(picker, pick, words));
}

void tell_times(const RenderFlags& render, const RunProfile& profile, Session& session) {
  if (render.profile && render.profile_file.empty()) tell(to_table(profile));
  if (!render.profile_file.empty()) write_file(render.profile_file, to_json(profile));
  if (render.repeat > 0 && !render.profile) {
    const Quartiles time = quartiles(profile.frames_ms);
    session.note(fmt::format("frame: {:.2f} ms median of {}, {:.2f} to {:.2f}", time.median,
                             render.repeat, time.min, time.max));
  }
}

class Declared : public Flags {
 public:
  explicit Declared(RenderFlags* render)
      : Flags("render", "INPUT... -o OUT [FLAG...]",
              "Draws a volume, mesh, particles or kernels to a picture and exits; never opens a "
              "window.") {
    section("state");
    add(state_settings(), render);
    add_input_flags(*this, &render->data);
    section("picture");
    add(output_settings(), render);
    add(pick_settings(), render);
    add(picture_settings(), &render->drawing);
    add_over_flags(*this, &render->drawing);
    add_drawing_flags(*this, &render->drawing);
    add(measure_settings(), render);
    add(switch_settings(), &render->drawing.options);
    footer("Which flag wins over another, and what the defaults are: docs/command-line.md.");
  }
};

}  // namespace

const std::vector<FlagForm>& render_flags() {
  static const std::vector<FlagForm> forms = [] {
    RenderFlags render;
    return Declared(&render).forms();
  }();
  return forms;
}

void check_render_flags(const Words& flag_words) {
  RenderFlags render;
  Declared flags(&render);
  if (!flags.parse(flag_words)) return;
  check_json_flags(render.drawing);
}

void run_render(const Words& words, Session& session) {
  RenderFlags render;
  Declared flags(&render);
  if (!flags.parse(with_state(words, flags.forms()))) return;
  check_flags(flags, render);
  if (session.team() != nullptr) check_for_team(flags, render);

  DrawingFlags& drawing = render.drawing;
  RunProfile profile;
  profile.command = session.command_line();
  profile.width = drawing.options.width;
  profile.height = drawing.options.height;
  take_from_model(&render.data, &drawing.model);
  const Stopwatch loading;
  render.data.may_stay_in_file = true;
  drawing.model.kept_bytes = static_cast<std::int64_t>(render.data.memory_limit.value_or(0));
  render.data.may_be_shared = can_be_shared(drawing.model.kernels);
  if (Team* const team = session.team()) team->agree(data_lines(files_of(render)));
  Dataset dataset = load(render.data, session);
  profile.load_ms = loading.ms();
  const Stopwatch modelling;
  const Subject subject = make_subject(dataset, flags, &drawing, session);
  profile.model_ms = modelling.ms();
  const std::int64_t step = dataset.step;
  dataset = {};  // the field keeps what it borrows; the rest is memory that the frame can use

  Shot shot = make_shot(subject, &drawing, session);
  const Look saved_look = shot.look();  // an x-ray's is spread anew below
  shot.scene.volumes.front().trail =
      trail_of(render.data, drawing, subject.modelled, step, saved_look, session);
  aim_camera(&shot, drawing);
  const Camera& camera = shot.camera;
  if (render.dry_run) {
    write_out(predict({shot.scene, camera, drawing.options, drawing.run, render.output}, session));
    return;
  }
  FilesTogether files;
  if (render.part) {
    write_part(render, shot.scene, camera, session);
    if (!render.look_output.empty()) write_look(saved_look, render.look_output);
    session.check_stop();
    files.commit();
    return;
  }
  Image image;
  if (Team* const team = session.team()) {
    std::optional<Image> all = draw_in_team(*team, render, shot.scene, camera, profile, session);
    if (!all) return;
    image = std::move(*all);
  } else {
    image = draw(render, shot.scene, camera, &profile, session);
  }
  note_if_empty(image, shot, subject.field().value_range(), session);
  tell_picks(render, subject, shot, image, session);
  if (is_for_eyes(render.output)) color_for_eyes(image, shot.look(), drawing.look, session);
  session.check_stop();
  if (!render.output.empty()) {
    write_picture(image, drawing, shot.described, camera, shot.look(),
                  {render.output, session.stop()});
  }
  if (!render.look_output.empty()) write_look(saved_look, render.look_output);
  if (session.team() == nullptr) tell_times(render, profile, session);
  flush_out();
  session.check_stop();
  files.commit();
}

}  // namespace ovoid::cli
