// SPDX-License-Identifier: Apache-2.0
// A film of frames: by ffmpeg, which is run as a program, or a GIF, by the library.
#pragma once

#include <cstdint>
#include <string>

#include "session.h"

namespace ovoid::cli {

bool is_film(const std::string& path);  // .mp4, .webm, .gif

struct Film {
  std::string path;
  std::string frames;  // as FrameNames::path() without the number: "x/frame_%06d.png"
  std::int64_t num_frames = 0;
  double fps = 25;
};

// What make_film() leaves in the frames' folder.
inline constexpr const char* kFilmPart = "film.part";
inline constexpr const char* kFilmLog = "ffmpeg.log";

// Whether ffmpeg makes the film; .gif needs none.
bool needs_ffmpeg(const std::string& film_path);

// The ffmpeg that is first on PATH. Throws Error(kUnsupported) that says how to go on without one.
std::string find_ffmpeg(const std::string& film_path);

// Makes the film and puts it in its place; ffmpeg works in the folder of the frames. But for .gif
// these are without transparency and of even size. Throws Error(kFileWrite) with ffmpeg's own last
// words, kUnsupported if it cannot be run, kCancelled; of a .gif what write_gif() throws.
void make_film(const Film& film, const std::string& ffmpeg, const Session& session);

}  // namespace ovoid::cli
