// SPDX-License-Identifier: Apache-2.0
// ovoid composite: parts of a picture to the picture.

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "check_files.h"
#include "command.h"
#include "ovoid/error.h"
#include "picture_part.h"
#include "usage.h"
#include "values.h"

namespace ovoid::cli {
namespace {

struct CompositeFlags {
  std::vector<std::string> parts;
  std::string output;
  DrawingFlags drawing;  // of which the background and the range of integrals count
};

const Table<CompositeFlags>& composite_settings() {
  using C = CompositeFlags;
  static const Table<C> all = {
      {"-o,--output", word("OUT", Content::kOfRun), &C::output,
       fmt::format("the picture: {}", kPictureEndings)},
      {"--background",
       {"COLOR|none",
        [](C& composite, const std::string& text) {
          composite.drawing.background.reset();
          if (text != "none" && text != "transparent")
            composite.drawing.background = parse_rgb(text);
        },
        {}},
       "colour behind a PNG or JPEG, as of ovoid render"},
      {"--range",
       {"LO,HI",
        [](C& composite, const std::string& text) {
          composite.drawing.look.range = parse_range(text);
        },
        {}},
       "of an x-ray picture: the integrals that its colours span (default: all that there are)"},
  };
  return all;
}

void check_flags(const CompositeFlags& composite) {
  if (composite.parts.empty())
    throw UsageError(
        "no parts given, expected what ovoid render --part wrote (see ovoid composite "
        "--help)");
  if (composite.output.empty())
    throw UsageError(fmt::format("--output: none given, expected -o OUT{}", kPictureEndings));
  if (picture_ending(composite.output).empty()) {
    throw UsageError(fmt::format("--output '{}': expected a name that ends in {}", composite.output,
                                 kPictureEndings));
  }
  check_background(composite.drawing, composite.output);
  std::vector<InputFile> inputs;
  for (const std::string& part : composite.parts) inputs.push_back({part, "a part"});
  check_files(inputs, {{"--output", composite.output, composite.output}});
}

// Throws Error unless the part may stand beside those that were read before it.
void require_fitting(const PicturePart& part, const std::string& path, const PicturePart& first,
                     const std::string& first_path,
                     const std::vector<std::string>& path_of_number) {
  const auto refuse = [&](const std::string& why) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("{}: {}", path, why));
  };
  if (part.count != first.count)
    refuse(fmt::format("is one of {} parts, {} one of {}", part.count, first_path, first.count));
  if (const std::string line = differing_line(part.picture, first.picture); !line.empty())
    refuse(
        fmt::format("is a part of another picture than {}: they differ in '{}'", first_path, line));
  const std::string& before = path_of_number[static_cast<std::size_t>(part.number)];
  if (!before.empty())
    refuse(fmt::format("is part {} of {}, and so is {}", part.number, part.count, before));
}

std::string missing_parts(const std::vector<std::string>& path_of_number) {
  std::string missing;
  for (std::size_t number = 1; number < path_of_number.size(); ++number) {
    if (path_of_number[number].empty())
      missing += (missing.empty() ? "" : ", ") + std::to_string(number);
  }
  return missing;
}

}  // namespace

void run_composite(const Words& words, Session& session) {
  CompositeFlags composite;
  Flags flags("composite", "PART... -o OUT [FLAG...]",
              "Puts a picture together of the parts that ovoid render --part K/N has drawn, all N "
              "of them, in any order.");
  flags.positionals("PART...", "deep OpenEXR files of one picture's parts", &composite.parts);
  flags.add(composite_settings(), &composite);
  if (!flags.parse(words)) return;
  check_flags(composite);

  std::vector<DeepImage> seen;
  std::vector<std::string> path_of_number;
  PicturePart first;
  Progress progress("reading parts");
  for (const std::string& path : composite.parts) {
    PicturePart part = read_picture_part(path, session.stop());
    if (seen.empty()) path_of_number.resize(static_cast<std::size_t>(part.count) + 1);
    const PicturePart& before = seen.empty() ? part : first;
    require_fitting(part, path, before, composite.parts.front(), path_of_number);
    path_of_number[static_cast<std::size_t>(part.number)] = path;
    seen.push_back(std::exchange(part.seen, {}));
    if (seen.size() == 1) first = std::move(part);
    progress.show(static_cast<double>(seen.size()) / static_cast<double>(composite.parts.size()));
  }
  if (const std::string missing = missing_parts(path_of_number); !missing.empty())
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("of {} parts these are not given: {}", first.count, missing));
  const bool has_integrals = seen.front().mode == Mode::kXray && is_for_eyes(composite.output);
  if (composite.drawing.look.range && !has_integrals)
    throw UsageError("--range: is for x-ray pictures with colours, .png or .jpg");
  const Image image = picture_of(merged(seen), first.look, composite.drawing.look,
                                 is_for_eyes(composite.output), session);
  session.check_stop();
  write_image(image, composite.output, composite.drawing.background, {session.stop()});
}

}  // namespace ovoid::cli
