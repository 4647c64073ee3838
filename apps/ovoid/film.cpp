// SPDX-License-Identifier: Apache-2.0
#include "film.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <thread>
#include <vector>

#include "child_process.h"
#include "frame_files.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "values.h"

namespace ovoid::cli {
namespace {

namespace fs = std::filesystem;

using Arguments = std::vector<std::string>;

// In sRGB's own primaries, and said so: players guess otherwise, by the size of the picture.
constexpr const char* kColors =
    "scale=in_range=pc:out_range=tv:out_color_matrix=bt709,format=yuv420p";

Arguments encoding_of(const std::string& path) {
  const Arguments tags{"-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709"};
  Arguments all{"-vf", kColors};
  all.insert(all.end(), tags.begin(), tags.end());
  const Arguments rest =
      has_ending(path, ".webm")
          ? Arguments{"-c:v", "libvpx-vp9", "-b:v", "0", "-crf", "24", "-f", "webm"}
          : Arguments{"-c:v", "libx264", "-crf", "18", "-movflags", "+faststart", "-f", "mp4"};
  all.insert(all.end(), rest.begin(), rest.end());
  return all;
}

// ffmpeg takes the names of files for patterns and for addresses; neither is meant here.
std::string file_argument(const std::string& path) {
  std::error_code ignored;
  return "file:" + fs::absolute(path, ignored).string();
}

std::string pattern_argument(const std::string& pattern) {
  const auto name = file_argument(pattern);
  const auto begin = name.rfind('/') + 1;
  std::string argument;
  for (const char c : name.substr(0, begin)) argument += c == '%' ? "%%" : std::string(1, c);
  return argument + name.substr(begin);
}

// The last line that it wrote.
std::string last_words(const std::string& path) {
  std::ifstream file(path);
  std::string line, last;
  while (std::getline(file, line)) {
    if (!line.empty()) last = line;
  }
  return last.empty() ? "it said nothing" : last.substr(0, 300);
}

// Its exit status; ends it when the person wants to.
int wait_for(pid_t child, const Session& session) {
  constexpr std::chrono::milliseconds kLook{20};
  bool is_asked_to_end = false;
  int status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (session.stop().stop_requested() && !is_asked_to_end) {
      kill(child, SIGTERM);
      is_asked_to_end = true;
    }
    std::this_thread::sleep_for(kLook);
  }
  return status;
}

void make_gif(const Film& film, const Session& session) {
  const FrameNames names(film.frames);
  std::vector<std::string> pictures;
  for (std::int64_t i = 0; i < film.num_frames; ++i) pictures.push_back(names.path(i));
  Progress progress("writing the film");
  write_gif(pictures, film.path, film.fps, {session.stop(), progress.callback()});
}

}  // namespace

bool is_film(const std::string& path) {
  return has_ending(path, ".mp4") || has_ending(path, ".webm") || has_ending(path, ".gif");
}

bool needs_ffmpeg(const std::string& film_path) { return !has_ending(film_path, ".gif"); }

std::string find_ffmpeg(const std::string& film_path) {
  if (std::string found = find_program("ffmpeg"); !found.empty()) return found;
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("{}: such films are made by the program ffmpeg, which is not on PATH: install it "
                  "(apt install ffmpeg), or write a film that needs none: -o {}, or pictures: -o "
                  "frames_%04d.png",
                  film_path, fs::path(film_path).replace_extension(".gif").string()));
}

void make_film(const Film& film, const std::string& ffmpeg, const Session& session) {
  if (!needs_ffmpeg(film.path)) return make_gif(film, session);
  // Both among the frames, where nobody else writes: ffmpeg takes any file of the name.
  const fs::path folder = fs::path(film.frames).parent_path();
  const std::string part = (folder / kFilmPart).string();
  const std::string log = (folder / kFilmLog).string();
  Arguments arguments{ffmpeg,
                      "-nostdin",
                      "-loglevel",
                      "error",
                      "-y",
                      "-framerate",
                      fmt::format("{}", film.fps),
                      "-start_number",
                      "0",
                      "-f",
                      "image2",
                      "-i",
                      pattern_argument(film.frames),
                      "-frames:v",
                      std::to_string(film.num_frames)};
  const Arguments encoding = encoding_of(film.path);
  arguments.insert(arguments.end(), encoding.begin(), encoding.end());
  arguments.push_back(file_argument(part));
  const int status = wait_for(start_program(ffmpeg, arguments, {.err = log}), session);
  std::error_code error;
  try {
    session.check_stop();
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
      throw Error(ErrorCode::kFileWrite,
                  fmt::format("{}: ffmpeg failed: {}", film.path, last_words(log)));
    }
    replace_file(part, film.path);
  } catch (...) {
    fs::remove(part, error);
    throw;
  }
}

}  // namespace ovoid::cli
