// SPDX-License-Identifier: Apache-2.0
// ovoid animate: data in time, or turned before the camera, to numbered pictures or a film.

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "animation_plan.h"
#include "camera_path.h"
#include "check_files.h"
#include "command.h"
#include "drawing.h"
#include "film.h"
#include "frame_files.h"
#include "load.h"
#include "make_camera.h"
#include "make_channels.h"
#include "make_labels.h"
#include "make_look.h"
#include "make_over.h"
#include "make_trail.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "series_survey.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

namespace fs = std::filesystem;

struct AnimateFlags {
  std::string output;
  double fps = 25;
  DataFlags data;
  AnimationFlags animation;
  DrawingFlags drawing;
};

constexpr double kMaxFps = 1000;

std::optional<std::string> is_no_film(const std::string& output) {
  return is_film(output) ? std::nullopt : std::optional(output);
}

const Table<AnimateFlags>& film_settings() {
  static const Table<AnimateFlags> all = {
      {"--fps", number("N", {.lo = 0, .hi = kMaxFps, .lo_open = true}), &AnimateFlags::fps,
       "frames per second of a film (default {})",
       not_with("output", "is for films (.mp4, .webm, .gif), pictures have no speed", is_no_film)},
  };
  return all;
}

const Table<AnimateFlags>& animate_output_settings() {
  static const Table<AnimateFlags> all = {
      {"-o,--output", word("OUT"), &AnimateFlags::output,
       "a film: .gif, or .mp4 or .webm, which are made by ffmpeg; or pictures with a number in "
       "their name: frames_%04d.png, .jpg, .exr or .npy"},
  };
  return all;
}

void add_flags(Flags& flags, AnimateFlags* animate) {
  add_input_flags(flags, &animate->data);
  flags.section("animation");
  flags.add(animation_settings(), &animate->animation);
  flags.add(film_settings(), animate);
  flags.section("picture");
  flags.add(animate_output_settings(), animate);
  flags.add(picture_settings(), &animate->drawing);
  add_over_flags(flags, &animate->drawing);
  add_drawing_flags(flags, &animate->drawing);
  flags.add(switch_settings(), &animate->drawing.options);
  flags.footer(
      "Frames that the same command has left whole are kept. What holds for all frames, and what "
      "the defaults are: docs/time.md and docs/command-line.md.");
}

// Where the frames of a film lie while it is made, and longer if that is interrupted.
std::string folder_of_film(const std::string& film) { return film + ".frames"; }

// "turn/head.png" -> "turn/head_%04d.png"
std::string with_number(const std::string& path) {
  const fs::path whole(path);
  const std::string ending = picture_ending(path);
  return (whole.parent_path() / whole.stem()).string() + "_%04d" +
         (ending.empty() ? ".png" : ending);
}

// What the frames are called.
std::string pattern_of(const AnimateFlags& animate) {
  if (is_film(animate.output)) return folder_of_film(animate.output) + "/frame_%06d.png";
  return animate.output;
}

void check_output(const Flags& flags, const AnimateFlags& animate) {
  const std::string& output = animate.output;
  if (output.empty())
    throw UsageError(
        "--output: none given, expected -o OUT.mp4, .webm or .gif, or frames_%04d.png");
  if (has_ending(output, ".gif")) {
    if (animate.fps >= kMinGifFps && animate.fps <= kMaxGifFps) return;
    throw UsageError(fmt::format("--fps {}: expected {} to {} for '{}'", animate.fps, kMinGifFps,
                                 kMaxGifFps, output));
  }
  if (is_film(output)) {
    if (flags.is_given("background") && !animate.drawing.background) {
      throw UsageError(
          fmt::format("--background none: '{}' cannot be transparent, a .gif can", output));
    }
    const RenderOptions& options = animate.drawing.options;
    if (options.width % 2 != 0 || options.height % 2 != 0) {
      throw UsageError(fmt::format("--size {}x{}: expected even numbers for '{}'", options.width,
                                   options.height, output));
    }
    return;
  }
  if (!FrameNames::is_pattern(output)) {
    throw UsageError(
        fmt::format("--output '{}': expected a place for the frames' number, as in "
                    "'{}', or a film: .mp4, .webm or .gif",
                    output, with_number(output)));
  }
  const FrameNames checked(output);
  if (picture_ending(output).empty()) {
    throw UsageError(
        fmt::format("--output '{}': expected a name that ends in {}", output, kPictureEndings));
  }
}

std::vector<InputFile> inputs_of(const AnimateFlags& animate) {
  std::vector<InputFile> inputs = files_to_read(animate.data, animate.drawing);
  const std::string& path = animate.animation.camera_path;
  if (!path.empty() && !is_json(path)) inputs.push_back({path, "the keys of --camera-path"});
  return inputs;
}

std::optional<CameraPath> path_of(const AnimationFlags& animation) {
  if (animation.camera_path.empty()) return std::nullopt;
  try {
    return CameraPath::of_flag(animation.camera_path);
  } catch (const Error& error) {
    if (is_json(animation.camera_path)) throw UsageError(error.what());
    throw;
  }
}

void check_flags(const Flags& flags, const AnimateFlags& animate) {
  require_inputs(flags, animate.data);
  check_output(flags, animate);
  check_background(animate.drawing, animate.output);
  check_json_flags(animate.drawing);
  std::vector<OutputFile> outputs;
  if (is_film(animate.output)) {
    outputs.push_back({"--output", animate.output, animate.output});
  } else {
    const FrameNames names(animate.output);
    outputs.push_back({"--output", animate.output, names.path(0)});
    outputs.push_back({"--output", animate.output, names.record_path()});
  }
  check_files(inputs_of(animate), outputs);
}

// Frames must not replace what they are drawn from, whatever their number.
void check_frames_are_no_inputs(const AnimateFlags& animate, const FrameNames& names,
                                std::int64_t num_frames) {
  std::error_code ignored;
  const auto whole = [&](const std::string& path) {
    return fs::weakly_canonical(fs::absolute(path, ignored), ignored);
  };
  const fs::path folder = whole(names.path(0)).parent_path();
  for (const InputFile& input : inputs_of(animate)) {
    const fs::path path = whole(input.path);
    if (path.parent_path() != folder) continue;
    for (std::int64_t i = 0; i < num_frames; ++i) {
      if (fs::path(names.path(i)).filename() != path.filename()) continue;
      throw UsageError(fmt::format("--output '{}': frame {} is {}, expected another file",
                                   animate.output, i, input.what));
    }
  }
}

// Everything that is the same in all frames.
struct AllFrames {
  Described described;
  Scene scene;  // but for what each frame has of its own: the field, its boundary, its trail
  ValueRange values;
  Camera start, camera;              // before it turns: as it comes, and as near as all frames are
  std::optional<CameraTrack> track;  // of --camera-path

  Look& look() { return scene.volumes.front().look; }
  const Look& look() const { return scene.volumes.front().look; }
};

// The moment that `render` would take.
struct Chosen {
  double time = 0;
  bool is_only = false;  // by --step or --time
};

Chosen choose_moment(const DataFlags& data, const Series& series, Session& session) {
  if (data.time) return {*data.time, true};
  if (data.slice.plane) return {series.times()[series.times().size() / 2], false};
  Progress progress("reading");
  ReadOptions options = read_options(data, session);
  options.progress = progress.callback();
  const Dataset dataset = read_dataset(data.inputs, options);
  const std::int64_t step = data.step.value_or(dataset.step);
  return {series.times()[static_cast<std::size_t>(step)], data.step.has_value()};
}

// The last run of digits in a name, and the name without it.
std::pair<std::string, std::int64_t> numbered(const std::string& name) {
  constexpr const char* kDigits = "0123456789";
  constexpr std::size_t kMostDigits = 18;
  const auto last = name.find_last_of(kDigits);
  if (last == std::string::npos) return {name, -1};
  const auto before = name.find_last_not_of(kDigits, last);
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  const std::string digits = name.substr(first, last - first + 1);
  if (digits.size() > kMostDigits) return {name, -1};
  return {name.substr(0, first) + '\n' + name.substr(last + 1), std::stoll(digits)};
}

// A shell puts x10 before x2.
void note_order(const std::vector<std::string>& inputs, Session& session) {
  for (std::size_t i = 1; i < inputs.size(); ++i) {
    const auto [before, lesser] = numbered(inputs[i - 1]);
    const auto [name, number] = numbered(inputs[i]);
    if (before != name || number >= lesser) continue;
    session.note(
        fmt::format("steps are in the order given: '{}' comes before '{}' (ls -v sorts by "
                    "number)",
                    inputs[i - 1], inputs[i]));
    return;
  }
}

// The array that is drawn is the same in all steps; an array that is alone may change its name.
void fix_array(const Dataset& dataset, const Modelled& modelled, ModelFlags* model) {
  const bool is_chosen = !model->array.empty() || model->kernels.is_density;
  if (!is_chosen && draws_density(dataset, model->kernels)) model->kernels.is_density = true;
  if (is_chosen || dataset.arrays.size() < 2 || !find_array(dataset, modelled.array)) return;
  model->array = modelled.array;
}

AllFrames make_scene(const Series& series, const Chosen& chosen, const Flags& flags,
                     AnimateFlags* animate, Session& session) {
  DrawingFlags& drawing = animate->drawing;
  Dataset dataset = data_at(series, chosen.time, drawing, session);
  check_format_flags(animate->data, dataset);
  session.notes(dataset.notes);
  Subject subject = make_subject(dataset, flags, &drawing, session);
  fix_array(dataset, subject.modelled, &drawing.model);
  std::vector<double> times{chosen.time};
  if (!chosen.is_only) {
    times.clear();
    for (const std::int64_t step :
         steps_to_survey(series, series.nearest_step(chosen.time), dataset, drawing.look))
      times.push_back(series.times()[static_cast<std::size_t>(step)]);
  }
  const Survey seen = survey(series, times, drawing, session);
  if (seen.look_time != chosen.time) {
    dataset = data_at(series, seen.look_time, drawing, session);
    subject = make_subject(dataset, flags, &drawing, session);
  }
  if (series.num_steps() > 1 && seen.num_steps > 1) {
    session.note(fmt::format(
        "all frames have the look of step {}; values of {} steps: {:g} to {:g}",
        series.nearest_step(seen.look_time), seen.num_steps, seen.values.lo, seen.values.hi));
  }
  const Field& field = subject.modelled.field;
  AllFrames all;
  all.described = std::move(subject.described);
  all.described.box = box_of_all(seen, drawing.crop, field, &drawing.options);
  all.values = seen.values;
  all.scene = subject.scene;
  Volume& volume = all.scene.volumes.front();
  const LookFlags look = with_range_of(seen, drawing.look, field);
  volume.look = make_look(look, field, subject.unit, session, subject.usual_look);
  leave_colors_to_channels(drawing, &volume.look);
  note_on_marks(drawing.annotation, volume.look, session);
  if (field.kernels() != nullptr && series.num_steps() > 1) {
    // Else every step would have its own.
    drawing.options.sampling_distance = sheet_distance(field, volume.look, drawing.options);
    volume.look.unit_distance = unit_distance_of(volume.look, field);
  }
  volume.walls = surface_to_draw(subject, drawing);
  if (subject.has_points) volume.points = points_to_draw(drawing.points);
  CameraFlags camera = drawing.camera;
  if (seen.num_steps > 1) camera.fit = Fit::kBox;  // what shows of one may grow in the next
  if (chosen.is_only && drawing.trail.length) {
    volume.trail = std::make_shared<Trail>(
        make_trail(drawing.trail, series, chosen.time, drawing.model, drawing.run.threads,
                   {field, volume.look, all.values, animate->data.memory_limit}, session));
  }
  const RenderOptions& options = drawing.options;
  const CameraSubject seen_subject{
      all.scene,           bounds_with(all.described.box.world_bounds(), all.scene),
      all.described.space, static_cast<double>(options.width) / options.height,
      options.clip_planes, true};
  all.start = start_camera(camera, seen_subject);
  all.camera = make_camera(camera, seen_subject);
  volume.field = {};  // each frame has its own; two of them need not be in memory
  volume.boundary.reset();
  volume.trail.reset();
  return all;
}

class Animator {
 public:
  Animator(const Series& series, const AnimateFlags& animate, const ValueRange& values,
           Session& session)
      : series_(series),
        animate_(animate),
        session_(session),
        renderer_(animate.drawing.run),
        values_(values) {}

  // Draws the frame and writes it.
  void draw(const PlannedFrame& frame, const AllFrames& all, const std::string& path,
            const RenderHooks& hooks) {
    const Camera camera = camera_of(frame, all);
    Image image = render(frame, camera, all, hooks);
    if (is_empty(image)) ++num_empty_;
    if (all.look().mode == Mode::kXray && is_for_eyes(path))
      color_integrals(image, all.look().transfer_function);
    session_.check_stop();
    write_picture(image, animate_.drawing, all.described, camera, all.look(),
                  {path, session_.stop()});
  }

  // The integrals over which an x-ray's colours are spread in all frames.
  void measure_integrals(const PlannedFrame& frame, AllFrames& all) {
    RenderHooks hooks;
    hooks.stop = session_.stop();
    const Image image = render(frame, camera_of(frame, all), all, hooks);
    spread_over_integrals(all.look().transfer_function, image, animate_.drawing.look, session_);
  }

  std::int64_t num_empty() const noexcept { return num_empty_; }

 private:
  Camera camera_of(const PlannedFrame& frame, const AllFrames& all) const {
    if (all.track) return all.track->at(frame.place);
    CameraFlags turned = animate_.drawing.camera;
    turned.azimuth += frame.turn;
    return turned_camera(turned, all.start, all.camera);
  }

  // What of the scene moves. Looks, walls and what stands beside are those of all frames.
  void go_to(double time, const AllFrames& all) {
    scene_ = {};  // two of them need not be in memory
    const DrawingFlags& drawing = animate_.drawing;
    const Quiet quiet(session_);
    const bool are_own_labels = all.scene.labels.map != nullptr && drawing.labels.file.empty();
    // Between two labels there is no third.
    const double time_of_data =
        are_own_labels ? series_.times()[static_cast<std::size_t>(series_.nearest_step(time))]
                       : time;
    Dataset dataset = data_at(series_, time_of_data, drawing, session_);
    const bool has_channels = !drawing.channels.names.empty();
    if (!has_channels) {
      if (auto merged = merged_layers(dataset, drawing.model.component))
        dataset = std::move(merged->dataset);
    }
    const Modelled modelled = make_field(dataset, drawing.model, drawing.run.threads, session_);
    scene_ = all.scene;
    Volume& volume = scene_.volumes.front();
    volume.field = modelled.field;
    volume.boundary = surface_of(dataset, drawing, modelled, session_);
    if (has_channels) {
      const std::vector<Volume> channels = make_channels(dataset, drawing, session_);
      for (std::size_t i = 0; i < channels.size(); ++i)
        scene_.volumes.at(i + 1).field = channels[i].field;
    }
    if (drawing.trail.length) {
      volume.trail = std::make_shared<Trail>(
          make_trail(drawing.trail, series_, time, drawing.model, drawing.run.threads,
                     {volume.field, volume.look, values_, animate_.data.memory_limit}, session_));
    }
    if (are_own_labels && series_.num_steps() > 1)
      scene_.labels =
          own_labels_of_step(volume.field, all.scene.labels, drawing.run.threads, session_);
    time_ = time;
  }

  Image render(const PlannedFrame& frame, const Camera& camera, const AllFrames& all,
               const RenderHooks& hooks) {
    if (!time_ || *time_ != frame.time) {
      time_.reset();
      go_to(frame.time, all);
    }
    scene_.volumes.front().look = all.look();  // an x-ray's is spread over the first frame
    Frame drawn = renderer_.render(scene_, camera, animate_.drawing.options, hooks);
    if (!drawn.profile.notice.empty()) session_.note(drawn.profile.notice);
    return std::move(drawn.image);
  }

  const Series& series_;
  const AnimateFlags& animate_;
  Session& session_;
  Renderer renderer_;
  const ValueRange values_;  // of all frames
  Scene scene_;
  std::optional<double> time_;  // that it is of
  std::int64_t num_empty_ = 0;
};

std::uint64_t key_of(const PlannedFrame& frame, std::uint64_t settings) {
  return hash_of(fmt::format("{:a} {:a} {:a}", frame.time, frame.turn, frame.place), settings);
}

// The numbers of those that no earlier run has left whole.
std::vector<std::int64_t> missing_frames(const std::vector<PlannedFrame>& plan,
                                         const FrameRecord& record, std::uint64_t settings,
                                         Session& session) {
  std::vector<std::int64_t> missing;
  for (std::size_t i = 0; i < plan.size(); ++i) {
    const auto number = static_cast<std::int64_t>(i);
    if (!record.is_whole(number, key_of(plan[i], settings))) missing.push_back(number);
  }
  if (missing.size() < plan.size()) {
    session.note(fmt::format("{} of {} frames are there already and are kept",
                             plan.size() - missing.size(), plan.size()));
  }
  return missing;
}

void draw_frames(const std::vector<PlannedFrame>& plan, const std::vector<std::int64_t>& missing,
                 const AllFrames& all, const FrameNames& names, FrameRecord& record,
                 std::uint64_t settings, Animator& animator, Session& session) {
  Progress progress("drawing");
  std::size_t done = 0;
  RenderHooks hooks;
  hooks.stop = session.stop();
  hooks.progress = [&](double part) {
    progress.show((static_cast<double>(done) + part) / static_cast<double>(missing.size()));
  };
  try {
    for (const std::int64_t number : missing) {
      progress.rename(fmt::format("frame {} of {}", number + 1, plan.size()));
      const PlannedFrame& frame = plan[static_cast<std::size_t>(number)];
      animator.draw(frame, all, names.path(number), hooks);
      record.add(number, key_of(frame, settings));
      ++done;
    }
  } catch (const Error&) {
    if (const std::size_t num_whole = plan.size() - missing.size() + done; num_whole > 0) {
      session.note(fmt::format("{} of {} frames are there; the same command goes on from them",
                               num_whole, plan.size()));
    }
    throw;
  }
}

// What was made on the way to a film.
void remove_frames(const std::string& folder) {
  std::error_code ignored;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    const bool is_ours = (name.rfind("frame_", 0) == 0 && has_ending(name, ".png")) ||
                         name == "frame.ovoid" || name == kFilmLog || name == kFilmPart;
    if (is_ours) files.push_back(entry.path());
  }
  for (const fs::path& file : files) fs::remove(file, ignored);
  fs::remove(folder, ignored);
}

// The caller's own, so that nobody else can put links in the frames' place. False: it is there.
bool make_folder(const std::string& folder) {
  std::error_code error;
  const bool is_made = fs::create_directory(folder, error);
  if (error) {
    throw Error(ErrorCode::kFileWrite,
                fmt::format("{}: cannot be made: {}", folder, error.message()));
  }
  struct stat info {};
  if (lstat(folder.c_str(), &info) == 0 && S_ISDIR(info.st_mode) && info.st_uid == geteuid())
    return is_made;
  throw Error(ErrorCode::kFileWrite,
              fmt::format("{}: is a link or another user's: remove it, or choose another name for "
                          "the film",
                          folder));
}

// The folder of a film's frames: gone with the frames when the film is made, and when the command
// fails before a frame is there from which it can go on.
class FilmFolder {
 public:
  // `path`: empty for pictures, which need none. The record is that of the frames in it.
  FilmFolder(std::string path, const FrameRecord& record)
      : path_(std::move(path)), record_(record), is_new_(!path_.empty() && make_folder(path_)) {}
  ~FilmFolder() {
    if (is_done_ || (is_new_ && record_.is_empty())) remove_frames(path_);
  }
  FilmFolder(const FilmFolder&) = delete;
  FilmFolder& operator=(const FilmFolder&) = delete;

  void set_done() noexcept { is_done_ = !path_.empty(); }

 private:
  std::string path_;
  const FrameRecord& record_;
  bool is_new_;
  bool is_done_ = false;
};

std::vector<std::string> paths_of(const std::vector<InputFile>& files) {
  std::vector<std::string> paths;
  paths.reserve(files.size());
  for (const InputFile& file : files) paths.push_back(file.path);
  return paths;
}

}  // namespace

void run_animate(const Words& words, Session& session) {
  AnimateFlags animate;
  Flags flags("animate", "INPUT... -o OUT [FLAG...]",
              "Draws the steps of data in time, or a turn around them, to a film or to numbered "
              "pictures, and exits.");
  add_flags(flags, &animate);
  if (!flags.parse(words)) return;
  check_flags(flags, animate);
  const std::optional<CameraPath> path = path_of(animate.animation);
  const bool makes_film = is_film(animate.output);
  const std::string ffmpeg =
      makes_film && needs_ffmpeg(animate.output) ? find_ffmpeg(animate.output) : "";

  take_from_model(&animate.data, &animate.drawing.model);
  animate.drawing.time_filter = animate.data.time_filter;
  const auto& plane = animate.data.slice.plane;
  if (plane && !std::isnan(plane->offset)) animate.data.time = plane->offset;  // of the slices
  const Series series = open_shown_series(animate.data, session);
  const Chosen chosen = choose_moment(animate.data, series, session);
  if (!series.source().has_times()) note_order(animate.data.inputs, session);
  const auto plan = plan_frames(animate.animation, series.source(),
                                chosen.is_only ? std::optional(chosen.time) : std::nullopt,
                                path ? &*path : nullptr);
  const FrameNames names(pattern_of(animate));
  if (!makes_film)
    check_frames_are_no_inputs(animate, names, static_cast<std::int64_t>(plan.size()));
  const std::uint64_t settings = settings_key(session.command_line(), paths_of(inputs_of(animate)));
  FrameRecord record(names);
  FilmFolder folder(makes_film ? folder_of_film(animate.output) : "", record);
  const auto missing = missing_frames(plan, record, settings, session);
  if (!missing.empty()) {
    AllFrames all = make_scene(series, chosen, flags, &animate, session);
    if (path) {
      const CameraFlags& turns = animate.drawing.camera;
      const Camera unturned = unturned_camera(turns, all.start, all.camera);
      all.track.emplace(*path, unturned, turns);
    }
    Animator animator(series, animate, all.values, session);
    const bool is_xray = animate.drawing.look.mode == Mode::kXray;
    if (is_xray && is_for_eyes(names.path(0))) animator.measure_integrals(plan[0], all);
    draw_frames(plan, missing, all, names, record, settings, animator, session);
    if (animator.num_empty() > 0) {
      session.note(fmt::format("nothing shows in {} of {} frames: {}", animator.num_empty(),
                               missing.size(), cause_of_emptiness(all.look(), all.values)));
    }
  }
  if (!makes_film) return;
  make_film(
      {animate.output, pattern_of(animate), static_cast<std::int64_t>(plan.size()), animate.fps},
      ffmpeg, session);
  folder.set_done();
}

}  // namespace ovoid::cli
