// SPDX-License-Identifier: Apache-2.0
// Flags as data, in process: what was given, sets of flags, and what the command line leaves of a
// state's.
#include "flag_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>

#include "command.h"
#include "ovoid/error.h"
#include "program.h"
#include "session.h"
#include "settings.h"
#include "state_file.h"
#include "state_words.h"
#include "usage.h"

namespace ovoid::cli_tests {
namespace flag_set_test {

using cli::FlagForm;
using cli::FlagKind;
using cli::Flags;
using cli::FlagSet;
using cli::GivenFlag;
using cli::State;
using Json = FlagSet::Json;

// As the flags of a line would be, by the forms of render's.
FlagSet set_of(const Words& words) {
  std::vector<GivenFlag> given;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::size_t equals = words[i].find('=');
    GivenFlag flag{words[i].substr(2, equals - 2), {}, equals != std::string::npos};
    const FlagForm* const form = cli::find_render_flag(flag.name);
    if (form == nullptr) {
      ADD_FAILURE() << words[i];
      continue;
    }
    if (flag.has_value) flag.values = {words[i].substr(equals + 1)};
    if (form->kind == FlagKind::kValue || form->kind == FlagKind::kRepeatable) {
      flag.has_value = true;
      flag.values = {words[++i]};
    }
    given.push_back(flag);
  }
  return FlagSet::of(given);
}

// Settings of every kind.
struct Kinds {
  std::string text;
  std::vector<std::string> texts;
  bool is_set = false;
  std::optional<std::string> profile, title;
  int count = 3;
};

const cli::Table<Kinds>& kinds() {
  const auto optional = [](const char* form, std::optional<std::string> Kinds::*into) {
    return cli::Own<Kinds>{
        form, [into](Kinds& kinds, const std::string& value) { kinds.*into = value; }, {}};
  };
  static const cli::Table<Kinds> all = {
      {"-o,--output", cli::word("OUT"), &Kinds::text, ""},
      {"--size", cli::integer("N", 1, 9), &Kinds::count, "so many (default {})",
       cli::not_with("no-shade", "{2} of {0} '{1}'"), cli::needs("output", "needs -o")},
      {"--clip", cli::word("N"), &Kinds::texts, ""},
      {"--no-shade", cli::Toggle(), &Kinds::is_set, ""},
      {"--profile", optional("[=FILE]", &Kinds::profile), ""},
      {"--colorbar", optional("[=TITLE]", &Kinds::title), ""},
  };
  return all;
}

TEST(GivenFlags, StandInTheOrderOfTheLine) {
  Flags flags("x", "", "");
  Kinds taken;
  std::vector<std::string> inputs;
  flags.positionals("INPUT", "", &inputs);
  flags.add(kinds(), &taken);
  ASSERT_TRUE(flags.parse({"a", "--clip", "-1", "--no-shade", "-o", "x", "--clip=2", "b",
                           "--profile", "--colorbar=T", "--", "--size"}));
  EXPECT_EQ(taken.texts, (Words{"-1", "2"}));
  EXPECT_EQ(taken.profile, "");
  EXPECT_EQ(taken.title, "T");
  const std::vector<GivenFlag> given = flags.given();
  ASSERT_EQ(given.size(), 5U);
  const auto is = [](const GivenFlag& flag, const std::string& name, const Words& values) {
    return flag.name == name && flag.values == values && flag.has_value == !values.empty();
  };
  EXPECT_TRUE(is(given[0], "clip", {"-1", "2"}));
  EXPECT_TRUE(is(given[1], "no-shade", {}));
  EXPECT_TRUE(is(given[2], "output", {"x"}));
  EXPECT_TRUE(is(given[3], "profile", {}));
  EXPECT_TRUE(is(given[4], "colorbar", {"T"}));
  EXPECT_EQ(inputs, (Words{"a", "b", "--size"}));
  const std::vector<FlagForm> forms = flags.forms();
  ASSERT_EQ(forms.size(), 6U);
  EXPECT_EQ(forms[0].short_name, "o");
  EXPECT_EQ(forms[2].kind, FlagKind::kRepeatable);
  EXPECT_EQ(forms[3].kind, FlagKind::kToggle);
  EXPECT_EQ(forms[4].kind, FlagKind::kOptionalValue);
}

TEST(GivenFlags, RulesAndDefaultsComeFromTheRow) {
  const auto refusal = [](const Words& words) -> std::string {
    Flags flags("x", "", "");
    Kinds values;
    flags.add(kinds(), &values);
    try {
      flags.parse(words);
    } catch (const cli::UsageError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal({"--size", "4"}), "--size: needs -o");
  EXPECT_EQ(refusal({"--size", "4", "-ox"}), "");
  EXPECT_EQ(refusal({"--size", "4", "-o", "x", "--no-shade"}), "--size: 4 of --no-shade ''");
  EXPECT_EQ(refusal({"--size", "12"}), "--size '12': expected a whole number from 1 to 9");
  EXPECT_EQ(refusal({"--profile=true", "--", "x"}),
            "'x': unexpected argument (see ovoid x --help)");
  EXPECT_EQ(refusal({"-o"}), "-o: expected a value, OUT");
  EXPECT_EQ(refusal({"-5"}), "-5: unknown flag (see ovoid x --help)");
  EXPECT_EQ(kinds()[1].flag.text, "so many (default 3)");
}

TEST(FlagSets, AreWordsInOrder) {
  FlagSet set;
  set.set("size", "640x480");
  set.set("clip", {"1,0,0,-1", "0,1,0,2"});
  set.set("no-shade", true);
  set.set("colorbar", "A title");
  set.set("tf", Json::parse(R"([{"Name": "it's", "RGBPoints": [0.1, 1, 0, 0, 1e-310, 1, 1, 0]}])"));
  set.set("size", "8x8");
  const Words expected = {
      "--size",     "8x8",
      "--clip",     "1,0,0,-1",
      "--clip",     "0,1,0,2",
      "--no-shade", "--colorbar=A title",
      "--tf",       R"([{"Name":"it's","RGBPoints":[0.1,1,0,0,1e-310,1,1,0]}])"};
  EXPECT_EQ(set.words(), expected);
  EXPECT_EQ(FlagSet::from_json(set.to_json()).words(), expected);
  EXPECT_EQ(cli::quoted({"a b", "it's", "", "x=1"}), R"('a b' 'it'\''s' '' x=1)");
  EXPECT_TRUE(set.erase("clip"));
  EXPECT_FALSE(set.erase("clip"));
  EXPECT_EQ(set.find("clip"), nullptr);
  EXPECT_EQ(*set.find("no-shade"), true);
}

TEST(FlagSets, JsonInAStringBecomesJson) {
  FlagSet set;
  set.set("camera", R"(  {"position": [0, 0, 4]})");
  EXPECT_TRUE(set.find("camera")->is_object());
  set.set("tf", "a{}.json");
  EXPECT_TRUE(set.find("tf")->is_string());
}

// As states held it before the flag could be given twice.
TEST(FlagSets, OneOfAListMayStandAlone) {
  const FlagSet set = FlagSet::from_json(Json::parse(R"({"light": "headlight"})"), "f");
  EXPECT_EQ(set.words(), (Words{"--light", "headlight"}));
}

// Fails for a kind of value that gets through, or a message that does not name the flag.
TEST(FlagSets, ValuesOfAnotherKindAreRefused) {
  const std::pair<const char*, const char*> rows[] = {
      {R"({"sze": "1x1"})", "f.sze: unknown flag; did you mean size?"},
      {R"({"--size": "1x1"})", "f.--size: unknown flag; did you mean size?"},
      {R"({"help": true})", "f.help: unknown flag"},
      {R"({"size": 640})", "f.size = 640: must be a string"},
      {R"({"size": ["1x1"]})", "f.size = [\"1x1\"]: must be a string"},
      {R"({"size": {"a": 1}})", "f.size = {...}: must be a string"},
      {R"({"size": null})", "f.size = null: must be a string"},
      {R"({"size": "1\u0000"})", "f.size = \"1\\u0000\": must be a string"},
      {R"({"no-shade": false})", "f.no-shade = false: must be true, or left out"},
      {R"({"no-shade": "true"})", "f.no-shade = \"true\": must be true, or left out"},
      {R"({"clip": []})", "f.clip = []: must be an array of strings"},
      {R"({"clip": ["1,0,0,0", 3]})", "f.clip = [\"1,0,0,0\",3]: must be an array of strings"},
      {R"({"clip": [1,2,3,4,5]})", "f.clip = [5 elements]: must be an array of strings"},
      {R"({"colorbar": ""})", "f.colorbar = \"\": must be true or a string that is not empty"},
      {R"({"colorbar": false})", "f.colorbar = false: must be true or a string that is not empty"},
      {R"({"camera": [1]})", "f.camera = [1]: must be a string or an object"},
      {R"({"camera": "{"})", "f.camera: begins like JSON and is none"},
      {R"({"tf": 3})", "f.tf = 3: must be a string, an object or an array of objects"},
      {R"({"tf": []})", "f.tf = []: must be a string, an object or an array of objects"},
      {R"({"tf": [{}, 1]})", "f.tf = [{},1]: must be a string, an object or an array of objects"},
      {R"({"output": "x.png"})",
       "f.output: is for the command line alone, a set of flags writes no files"},
      {R"({"profile": true})",
       "f.profile: is for the command line alone, a set of flags writes no files"},
      {R"({"state": "s.json"})",
       "f.state: is for the command line alone, a set of flags writes no files"},
      {R"([])", "f: must be an object of flags and their values"},
  };
  for (const auto& [json, said] : rows) {
    try {
      FlagSet::from_json(Json::parse(json), "f");
      ADD_FAILURE() << "accepted: " << json;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kFileFormat);
      EXPECT_STREQ(error.what(), said);
    }
  }
}

// Each is right by itself; together they hold every flag that a state can.
const std::vector<Words>& samples() {
  static const std::vector<Words> all = {
      {"--block", "b"},
      {"--step", "1"},
      {"--time", "1", "--time-filter", "gaussian", "--memory-limit", "1G"},
      {"--hyperslice", "0,0,0,1,2"},
      {"--hyperslice", "0,1,0,0"},
      {"--hyperslice", "0,0,0,1,2", "--slice-method", "extracted"},
      {"--hyperslice", "0,0,0,1,2", "--slice-lattice", "cc", "--slice-spacing", "2"},
      {"--positions", "/p", "--value", "/a", "--value", "/b"},
      {"--data-folder", "/a", "--data-folder", "/b"},
      {"--dims", "4x4x4", "--type", "uint8", "--spacing", "1,1,1", "--big-endian"},
      {"--axis-order", "czyx"},
      {"--size", "8x8", "--background", "1,1,1"},
      {"--colorbar=T", "--length-unit", "m"},
      {"--axes", "--bounding-box", "--scale-bar"},
      {"--array", "a", "--component", "1"},
      {"--color-array", "a"},
      {"--tf", "a.json", "--tf-name", "b"},
      {"--tf", R"({"Name": "b", "Points": [1, 1, 0.5, 0]})"},
      {"--preset", "ct-bone"},
      {"--colormap", "gray", "--opacity", "-1:0,1:1", "--gradient-opacity", "0:0,1:1"},
      {"--colormap", "-1,0,0,0,2,1,1,1"},
      {"--tf2d", "plane.png", "--tf2d-range", "0,255,0,12.5"},
      {"--range", "-1,1"},
      {"--window", "400,40"},
      {"--log"},
      {"--log", "--range", "1,2", "--opacity", "1:1,2:1"},
      {"--symlog", "1"},
      {"--below-color", "1,0,0", "--above-color", "0,1,0"},
      {"--unit-distance", "1"},
      {"--opaque-at", "0.9"},
      {"--mode", "composite"},
      {"--mode", "xray"},
      {"--mode", "maximum"},
      {"--mode", "minimum"},
      {"--mode", "mean"},
      {"--mode", "isosurface", "--iso", "3"},
      {"--mode", "isosurface", "--iso", "3::0.25,4.5:#ff8000"},
      {"--shade"},
      {"--no-shade"},
      {"--ambient", "1", "--diffuse", "1", "--specular", "1", "--specular-power", "1"},
      {"--light", "1,0,0"},
      {"--light", "headlight", "--flat", "0.1"},
      {"--light", "studio:1,0,0"},
      {"--light", "studio", "--light", "1,0,0@0.5", "--light", "0,1,0"},
      {"--occlusion", "0.5", "--shadows", "0.5", "--scatter", "0.5"},
      {"--volumetric-scattering-blending", "1"},
      {"--fit", "box"},
      {"--shift", "-3"},
      {"--surface=0.5", "--edges"},
      {"--surface"},
      {"--within", "mesh.vtu"},
      {"--add", "a.stl", "--add", "b.ply", "--add-color", "1,0,0", "--add-opacity", "0.5",
       "--add-edges", "--add-array", "speed", "--add-colormap", "hot", "--add-range", "0,2",
       "--add-radius", "0.1"},
      {"--slice", "z", "--slice", "1,0,0,3", "--slice-map", "viridis", "--slice-range", "0,1",
       "--slice-opacity", "0.5", "--slice-empty", "--slice-outline"},
      {"--slice", "y", "--slice-outline=#ff8000"},
      {"--slice", "y", "--labels", "parts.nrrd", "--slice-labels", "both", "--flat-labels"},
      {"--labels", "parts.nrrd", "--label-table", "parts.ctbl", "--label-opacity", "3=0.4,others=0",
       "--label-color", "3=#ff8000", "--inside-labels", "1,left lung"},
      {"--labels", "parts.nrrd", "--outside-labels", "1,2"},
      {"--label-table", R"({"1": "liver"})"},
      {"--label-surfaces", "--colormap", "gray"},
      {"--over", "a.nrrd", "--over", "b.nrrd", "--over-array", "x", "--over-tf", "a.json",
       "--over-colormap", "gray", "--over-range", "0,1", "--over-opacity", "0:0,1:0.5",
       "--over-transform", "m.txt"},
      {"--over", "a.nrrd", "--over-preset", "mr-default"},
      {"--channels", "all", "--channel-color", "1,0,0", "--channel-range", "0,1", "--mixing",
       "averaged"},
      {"--points=2"},
      {"--points"},
      {"--background", "none"},
      {"--camera", R"({"position": [0, 0, 4]})"},
      {"--view", "+x", "--azimuth", "1", "--elevation", "1", "--roll", "1", "--zoom", "2"},
      {"--projection", "parallel", "--view-angle", "20"},
      {"--crop", "1:2,,"},
      {"--crop-world", "1:2,,"},
      {"--motion-blur", "1", "--trail-tf", "a.json"},
      {"--kernel", "gaussian:0.6,4", "--reconstruction", "sum", "--cutoff", "3"},
      {"--prefilter"},
      {"--kernel", "bspline", "--no-prefilter"},
      {"--kernel", "catmull-rom"},
      {"--relevant-above", "1"},
      {"--neighborhood", "edges", "--radius-array", "r", "--neighbors", "8", "--anisotropic"},
      {"--quantity", "density", "--profile-kernel", "gaussian", "--smoothing-ends", "1"},
      {"--mass", "1"},
      {"--mass-array", "m"},
      {"--sampling-distance", "1", "--slab", "mid", "--gradient", "exact"},
      {"--classification", "pre-integrated"},
      {"--evaluate", "gather", "--sheets", "lattice", "--sheet-precision", "fp16"},
      {"--post-convolution", "cubic", "--spread", "bilinear"},
      {"--clip", "1,0,0,0", "--clip", "0,1,0,0"},
      {"--thick-slice", "0,0,1,3,2"},
      {"--value-plane", "1,0,0,0,shown"},
      {"--color-array", "c", "--color-tf", "a.json"},
      {"--backend", "cpu", "--threads", "1", "--device", "0", "--device-memory", "1G"},
      {"--no-skip", "--no-stop", "--no-pack", "--repeat", "2", "--dry-run"},
  };
  return all;
}

TEST(FlagSets, SamplesHoldEveryFlag) {
  std::set<std::string> held;
  for (const Words& sample : samples()) {
    const FlagSet set = set_of(sample);
    for (const FlagSet::Flag& flag : set.flags()) held.insert(flag.name);
    EXPECT_NO_THROW(cli::check_render_flags(sample)) << joined(sample);
    EXPECT_NO_THROW(cli::check_render_flags(set.words())) << joined(sample);
  }
  for (const FlagForm& form : cli::render_flags()) {
    const std::set<std::string> of_line = {"output",  "part",      "pick", "pick-report",
                                           "profile", "save-look", "state"};
    const bool is_of_line = of_line.contains(form.name);
    EXPECT_EQ(held.contains(form.name), !is_of_line) << form.name;
  }
}

// The settings of a drawing and its data as flags.
FlagSet told(const cli::DataFlags& data, const cli::DrawingFlags& drawing) {
  FlagSet set;
  cli::tell(cli::data_settings(), data, &set);
  cli::tell(cli::raw_settings(), data, &set);
  cli::tell(cli::array_settings(), drawing.model, &set);
  cli::tell(cli::kernel_settings(), drawing.model, &set);
  cli::tell(cli::particle_settings(), drawing.model, &set);
  cli::tell(cli::relevant_settings(), drawing.model, &set);
  cli::tell(cli::color_settings(), drawing.look, &set);
  cli::tell(cli::light_settings(), drawing.look, &set);
  cli::tell(cli::camera_settings(), drawing.camera, &set);
  cli::tell(cli::crop_settings(), drawing.crop, &set);
  cli::tell(cli::mark_settings(), drawing.annotation, &set);
  cli::tell(cli::trail_settings(), drawing.trail, &set);
  cli::tell(cli::surface_settings(), drawing.surface, &set);
  cli::tell(cli::point_settings(), drawing.points, &set);
  cli::tell(cli::geometry_settings(), drawing.geometry, &set);
  cli::tell(cli::label_settings(), drawing.labels, &set);
  cli::tell(cli::channel_settings(), drawing.channels, &set);
  cli::tell(cli::over_settings(), drawing.over, &set);
  cli::tell(cli::picture_settings(), drawing, &set);
  cli::tell(cli::number_settings(), drawing.options, &set);
  cli::tell(cli::switch_settings(), drawing.options, &set);
  cli::tell(cli::plane_settings(), drawing, &set);
  cli::tell(cli::run_settings(), drawing.run, &set);
  return set;
}

FlagSet told_of(const Words& words) {
  cli::DataFlags data;
  cli::DrawingFlags drawing;
  Flags flags("x", "", "");
  cli::add_input_flags(flags, &data);
  cli::add_over_flags(flags, &drawing);
  cli::add_drawing_flags(flags, &drawing);
  flags.add(cli::picture_settings(), &drawing);
  flags.add(cli::switch_settings(), &drawing.options);
  EXPECT_TRUE(flags.parse(words));
  return told(data, drawing);
}

// Fails for a row whose value is told otherwise than it is parsed, or not at all.
TEST(FlagSets, WhatIsParsedIsTold) {
  for (Words sample : samples()) {
    std::erase(sample, "--dry-run");
    if (const auto repeat = std::find(sample.begin(), sample.end(), "--repeat");
        repeat != sample.end())
      sample.erase(repeat, repeat + 2);
    const FlagSet once = told_of(sample);
    EXPECT_EQ(told_of(once.words()).words(), once.words()) << joined(sample);
    const FlagSet given = set_of(sample);
    for (const FlagSet::Flag& flag : given.flags()) {
      const bool is_default = flag.value == "composite" || flag.value == "edges" ||
                              flag.value == "gaussian" || flag.value == "1G";
      // A thick slice is told as its two planes.
      const std::string name = flag.name == "thick-slice" ? "clip" : flag.name;
      EXPECT_TRUE(is_default || once.find(name) != nullptr) << flag.name;
    }
  }
}

// Whatever a state says, a line that is right without it is right with it, and has its way. Fails
// if a command checks what no rule of a row says.
TEST(StateWords, TheLineBeatsEveryState) {
  const Folder folder;
  const std::string path = folder / "s.json";
  for (const Words& sample : samples()) {
    State state;
    state.flags = set_of(sample);
    cli::write_state(state, path);
    for (const Words& line : samples()) {
      SCOPED_TRACE(joined(sample) + " then " + joined(line));
      Words words = {"--state", path};
      words.insert(words.end(), line.begin(), line.end());
      const Words all = cli::with_state(words, cli::render_flags());
      EXPECT_EQ(Words(all.end() - static_cast<std::ptrdiff_t>(words.size()), all.end()), words);
      EXPECT_NO_THROW(cli::check_render_flags(all));
    }
  }
}

// All else of a state stays.
TEST(StateWords, WhatDoesNotContradictStays) {
  const Folder folder;
  const std::string path = folder / "s.json";
  const auto expect_kept = [&](const Words& of_state, Words line, const Words& kept) {
    State state;
    state.inputs = {folder / "in.nrrd"};
    state.flags = set_of(of_state);
    cli::write_state(state, path);
    line.insert(line.begin(), {"--state=" + path});
    Words expected = {folder / "in.nrrd"};
    expected.insert(expected.end(), kept.begin(), kept.end());
    expected.insert(expected.end(), line.begin(), line.end());
    EXPECT_EQ(cli::with_state(line, cli::render_flags()), expected);
  };
  const Words turned = {"--view", "+x", "--azimuth", "1", "--no-shade"};
  expect_kept(turned, {"--size", "8x8"}, turned);
  expect_kept(turned, {"--view", "-x"}, {"--azimuth", "1", "--no-shade"});
  expect_kept(turned, {"--camera=c.json", "--shade"}, {"--azimuth", "1"});
  const Words surface = {"--mode", "isosurface", "--iso", "3", "--ambient", "1"};
  expect_kept(surface, {"--iso", "4"}, {"--mode", "isosurface", "--ambient", "1"});
  expect_kept(surface, {"--mode", "composite"}, {"--ambient", "1"});
  expect_kept(surface, {"--mode=xray"}, {});
  expect_kept(surface, {"--opacity", "0:1"}, {"--ambient", "1"});
  expect_kept({"--background", "1,1,1", "--axes"}, {"-o", "x.png"},
              {"--background", "1,1,1", "--axes"});
  expect_kept({"--background", "1,1,1", "--axes", "--length-unit", "m"}, {"-ox.exr"}, {});
  expect_kept({"--clip", "1,0,0,0", "--clip", "0,1,0,0"}, {"--clip", "0,0,1,0"}, {});
}

TEST(StateWords, WordsThatParsingRefusesComeBack) {
  for (const Words& words : {Words{"a", "--size", "1x1"}, Words{"--state", "no.json", "--help"},
                             Words{"--state", "no.json", "--state", "no.json"}, Words{"--state"},
                             Words{"--state="}, Words{"--state", "no.json", "--siez", "1"},
                             Words{"--array", "--state"}, Words{"--", "--state", "no.json"}}) {
    EXPECT_EQ(cli::with_state(words, cli::render_flags()), words) << joined(words);
  }
  EXPECT_THROW(cli::with_state({"--state", "no.json"}, cli::render_flags()), Error);
}

}  // namespace flag_set_test
}  // namespace ovoid::cli_tests
