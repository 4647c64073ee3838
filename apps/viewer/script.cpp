// SPDX-License-Identifier: Apache-2.0
#include "script.h"

#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <sstream>
#include <utility>

#include "console.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "session.h"

namespace ovoid::viewer {
namespace {

constexpr double kPatienceMs = 60'000;
constexpr int kMostSearches = 10;
constexpr std::size_t kFramesToSettle = 2;
constexpr std::size_t kMostBytes = 16U << 20;

struct NamedKey {
  const char* name;
  int key;
};
constexpr std::array kNamedKeys = {NamedKey{"ctrl", GLFW_KEY_LEFT_CONTROL},
                                   NamedKey{"shift", GLFW_KEY_LEFT_SHIFT},
                                   NamedKey{"alt", GLFW_KEY_LEFT_ALT},
                                   NamedKey{"left", GLFW_KEY_LEFT},
                                   NamedKey{"right", GLFW_KEY_RIGHT},
                                   NamedKey{"up", GLFW_KEY_UP},
                                   NamedKey{"down", GLFW_KEY_DOWN},
                                   NamedKey{"space", GLFW_KEY_SPACE},
                                   NamedKey{"tab", GLFW_KEY_TAB},
                                   NamedKey{"enter", GLFW_KEY_ENTER},
                                   NamedKey{"escape", GLFW_KEY_ESCAPE},
                                   NamedKey{"delete", GLFW_KEY_DELETE},
                                   NamedKey{"backspace", GLFW_KEY_BACKSPACE},
                                   NamedKey{"home", GLFW_KEY_HOME},
                                   NamedKey{"end", GLFW_KEY_END},
                                   NamedKey{"?", GLFW_KEY_SLASH},
                                   NamedKey{"[", GLFW_KEY_LEFT_BRACKET},
                                   NamedKey{"]", GLFW_KEY_RIGHT_BRACKET}};

// A command, and how many words follow it.
struct Form {
  const char* command;
  std::size_t least, most;
  const char* form;
};
constexpr std::array kForms = {
    Form{"wait", 1, 2, "wait loaded|full|idle, wait N frames|ms"},
    Form{"move", 1, 1, "move TARGET"},
    Form{"press", 1, 1, "press left|middle|right"},
    Form{"release", 1, 1, "release left|middle|right"},
    Form{"click", 1, 2, "click TARGET [left|right|double]"},
    Form{"drag", 3, 4, "drag BUTTON TARGET DX,DY [FRAMES]"},
    Form{"wheel", 1, 2, "wheel NOTCHES [TARGET]"},
    Form{"key", 1, 2, "key CHORD, key down|up KEY"},
    Form{"type", 1, 1000, "type TEXT..."},
    Form{"drop", 1, 1000, "drop FILE..."},
    Form{"resize", 1, 1, "resize WIDTHxHEIGHT"},
    Form{"screenshot", 1, 1, "screenshot FILE"},
    Form{"picture", 1, 1, "picture FILE"},
    Form{"state", 1, 1, "state FILE"},
    Form{"expect", 3, 3, "expect KEY ==|!=|<|<=|>|>=|contains VALUE"},
    Form{"print", 1, 1, "print KEY"},
    Form{"measure", 1, 1, "measure NAME"},
    Form{"pace", 1, 1, "pace FRAMES_PER_SECOND (0: as fast as possible)"},
    Form{"repeat", 1, 1, "repeat N"},
    Form{"end", 0, 0, "end"},
    Form{"close", 0, 0, "close"}};
constexpr std::array kComparisons = {"==", "!=", "<", "<=", ">", ">=", "contains"};
constexpr double kMostTimes = 1e9;    // of a repeat, and of frames and milliseconds to wait
constexpr double kLargestSide = 1e5;  // of a window

double now_ms() {
  return std::chrono::duration<double, std::milli>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

std::optional<double> number_in(const std::string& text) {
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc() || stopped != end || !std::isfinite(number)) return std::nullopt;
  return number;
}

std::optional<std::pair<double, double>> pair_in(const std::string& text, char separator = ',') {
  const std::size_t comma = text.find(separator);
  if (comma == std::string::npos) return std::nullopt;
  const auto first = number_in(text.substr(0, comma));
  const auto second = number_in(text.substr(comma + 1));
  if (!first || !second) return std::nullopt;
  return std::pair(*first, *second);
}

// Words between blanks, or between double quotes with the blanks in them.
std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  std::string word;
  bool is_quoted = false;
  bool has_word = false;
  for (const char c : line) {
    if (c == '"') {
      is_quoted = !is_quoted;
      has_word = true;
    } else if (!is_quoted && (c == ' ' || c == '\t' || c == '\r')) {
      if (has_word) words.push_back(std::exchange(word, {}));
      has_word = false;
    } else if (!is_quoted && !has_word && c == '#') {
      break;
    } else {
      word += c;
      has_word = true;
    }
  }
  if (has_word) words.push_back(word);
  return words;
}

std::optional<int> button_by_name(const std::string& name) {
  if (name == "left") return GLFW_MOUSE_BUTTON_LEFT;
  if (name == "right") return GLFW_MOUSE_BUTTON_RIGHT;
  if (name == "middle") return GLFW_MOUSE_BUTTON_MIDDLE;
  return std::nullopt;
}

// A whole number from 1.
std::optional<long> times_in(const std::string& text) {
  const auto number = number_in(text);
  if (!number || !(*number >= 1 && *number <= kMostTimes) || *number != std::floor(*number))
    return std::nullopt;
  return static_cast<long>(*number);
}

std::optional<std::pair<int, int>> size_in(const std::string& text) {
  const auto sides = pair_in(text, 'x');
  const auto is_side = [](double side) { return side >= 1 && side <= kLargestSide; };
  if (!sides || !is_side(sides->first) || !is_side(sides->second)) return std::nullopt;
  return std::pair(static_cast<int>(sides->first), static_cast<int>(sides->second));
}

bool is_one_of(const std::string& word, std::initializer_list<const char*> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

using Words = std::vector<std::string>;

// What is wrong with the words behind a command of the mouse or the keys; empty: nothing.
std::string fault_of_input(const Words& words) {
  const std::string& command = words.front();
  if (is_one_of(command, {"press", "release", "drag"}) && !button_by_name(words[1]))
    return fmt::format("'{}' is no button", words[1]);
  if (command == "click" && words.size() == 3 && !is_one_of(words[2], {"left", "right", "double"}))
    return fmt::format("'{}' is no kind of click", words[2]);
  if (command == "drag" && !pair_in(words[3])) return fmt::format("'{}': expected DX,DY", words[3]);
  if (command == "drag" && words.size() == 5 && !times_in(words[4]))
    return fmt::format("'{}': expected a number of frames", words[4]);
  if (command == "wheel" && !number_in(words[1]))
    return fmt::format("'{}': expected a number", words[1]);
  if (command != "key") return {};
  if (words.size() == 3 && !is_one_of(words[1], {"down", "up"}))
    return fmt::format("'{}': expected down or up", words[1]);
  std::stringstream parts(words.back());
  for (std::string part; std::getline(parts, part, '+');) {
    if (key_by_name(part) < 0) return fmt::format("'{}' is no key", part);
  }
  if (words.size() == 3 && key_by_name(words[2]) < 0)
    return fmt::format("'{}' is no key", words[2]);
  return {};
}

// The same for all others; "?" stands for the command's form.
std::string fault_of_others(const Words& words) {
  const std::string& command = words.front();
  if (command == "wait" && words.size() == 2 && !is_one_of(words[1], {"loaded", "full", "idle"}))
    return "?";
  if (command == "wait" && words.size() == 3) {
    const auto number = number_in(words[1]);
    const bool is_number = number && *number >= 0 && *number <= kMostTimes;
    if (!is_number || !is_one_of(words[2], {"frames", "ms"})) return "expected: wait N frames|ms";
  }
  if (command == "resize" && !size_in(words[1])) return "?";
  if (command == "expect" &&
      std::find(kComparisons.begin(), kComparisons.end(), words[2]) == kComparisons.end())
    return fmt::format("'{}' is no comparison", words[2]);
  if (command == "pace") {
    const auto rate = number_in(words[1]);
    if (!rate || *rate < 0) return "?";
  }
  if (command == "repeat" && !times_in(words[1]))
    return fmt::format("'{}': expected a whole number, from 1", words[1]);
  return {};
}

int modifier_of(int key) {
  if (key == GLFW_KEY_LEFT_CONTROL) return GLFW_MOD_CONTROL;
  if (key == GLFW_KEY_LEFT_SHIFT) return GLFW_MOD_SHIFT;
  return key == GLFW_KEY_LEFT_ALT ? GLFW_MOD_ALT : 0;
}

}  // namespace

int key_by_name(const std::string& name) {
  for (const NamedKey& key : kNamedKeys) {
    if (name == key.name) return key.key;
  }
  if (name.size() != 1) return -1;
  const char c = name.front();
  if (c >= 'a' && c <= 'z') return GLFW_KEY_A + (c - 'a');
  return c >= '0' && c <= '9' ? GLFW_KEY_0 + (c - '0') : -1;
}

std::string name_of_key(int key) {
  // Those on the right do the same.
  if (key == GLFW_KEY_RIGHT_CONTROL) key = GLFW_KEY_LEFT_CONTROL;
  if (key == GLFW_KEY_RIGHT_SHIFT) key = GLFW_KEY_LEFT_SHIFT;
  if (key == GLFW_KEY_RIGHT_ALT) key = GLFW_KEY_LEFT_ALT;
  for (const NamedKey& named : kNamedKeys) {
    if (key == named.key) return named.name;
  }
  if (key >= GLFW_KEY_A && key <= GLFW_KEY_Z)
    return std::string(1, static_cast<char>('a' + key - GLFW_KEY_A));
  if (key >= GLFW_KEY_0 && key <= GLFW_KEY_9)
    return std::string(1, static_cast<char>('0' + key - GLFW_KEY_0));
  return {};
}

Script::Script(const std::string& path) : path_(path) {
  std::istringstream file(read_text_file(path, kMostBytes));
  std::string text;
  int number = 0;
  int depth = 0;
  while (std::getline(file, text)) {
    ++number;
    Line line{number, words_of(text)};
    if (line.words.empty()) continue;
    check(line, &depth);
    lines_.push_back(std::move(line));
  }
  if (depth != 0) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: a 'repeat' has no 'end'", path));
  }
}

void Script::check(const Line& line, int* depth) const {
  const auto complain = [&](const std::string& what) {
    throw Error(ErrorCode::kFileFormat,
                fmt::format("{}:{}: {}", path_, line.number, cli::message_line(what)));
  };
  const std::string& command = line.words.front();
  const auto form = std::find_if(kForms.begin(), kForms.end(),
                                 [&](const Form& known) { return command == known.command; });
  if (form == kForms.end()) return complain(fmt::format("'{}' is no command", command));
  const std::size_t following = line.words.size() - 1;
  std::string fault = "?";
  if (following >= form->least && following <= form->most) {
    fault = fault_of_input(line.words);
    if (fault.empty()) fault = fault_of_others(line.words);
  }
  if (fault == "?") fault = fmt::format("expected: {}", form->form);
  if (!fault.empty()) complain(fault);
  if (command == "repeat") ++*depth;
  if (command == "end" && --*depth < 0) complain("'end' without 'repeat'");
}

void Script::fail(const std::string& what) const {
  const int number = at_ < lines_.size() ? lines_[at_].number : 0;
  throw Error(ErrorCode::kInvalidArgument, fmt::format("{}:{}: {}", path_, number, what));
}

// What the program answers; its complaint becomes one about the line.
template <typename Question>
auto Script::asked(const Question& question) const {
  try {
    return question();
  } catch (const Error& error) {
    fail(error.what());
  }
}

void Script::move_to(double x, double y) { frames_.push_back({MouseMoved{x, y}}); }

void Script::press(int button, bool is_down) {
  frames_.push_back({ButtonChanged{button, is_down}});
}

// "X,Y", or a widget's name, with "@FX,FY" a place in it by fractions.
std::optional<ImVec2> Script::place_of(const std::string& target, ScriptHost& host) {
  if (const auto place = pair_in(target))
    return ImVec2(static_cast<float>(place->first), static_cast<float>(place->second));
  const std::size_t at = target.rfind('@');
  const auto share = at == std::string::npos ? std::nullopt : pair_in(target.substr(at + 1));
  const std::string name = share ? target.substr(0, at) : target;
  const auto box = host.find(name);
  if (!box) {
    if (++searches_ > kMostSearches || (!host.scroll_to(name) && searches_ > 3))
      fail(fmt::format("there is no '{}' in the window", name));
    return std::nullopt;  // to be looked for again in the next frame
  }
  searches_ = 0;
  const double fx = share ? share->first : 0.5;
  const double fy = share ? share->second : 0.5;
  return ImVec2(static_cast<float>(box->x0 + fx * (box->x1 - box->x0)),
                static_cast<float>(box->y0 + fy * (box->y1 - box->y0)));
}

void Script::press_key(const std::string& chord) {
  std::vector<int> keys;
  std::stringstream parts(chord);
  for (std::string part; std::getline(parts, part, '+');) keys.push_back(key_by_name(part));
  const bool is_question = !keys.empty() && keys.back() == GLFW_KEY_SLASH;
  int modifiers = is_question ? GLFW_MOD_SHIFT : 0;
  for (const int key : keys) {
    modifiers |= modifier_of(key);
    frames_.push_back({KeyChanged{key, true, modifiers}});
  }
  for (auto key = keys.rbegin(); key != keys.rend(); ++key)
    frames_.push_back({KeyChanged{*key, false, 0}});
}

void Script::drag(const Line& line, ImVec2 from) {
  const int button = *button_by_name(line.words[1]);
  const auto [dx, dy] = *pair_in(line.words[3]);
  constexpr long kMostFrames = 1'000'000;
  const long asked = line.words.size() > 4 ? times_in(line.words[4]).value_or(10) : 10;
  const int steps = static_cast<int>(std::min(asked, kMostFrames));
  move_to(from.x, from.y);
  press(button, true);
  for (int i = 1; i <= steps; ++i) move_to(from.x + dx * i / steps, from.y + dy * i / steps);
  press(button, false);
}

void Script::expect(const Line& line, const ScriptHost& host) const {
  const std::string& key = line.words[1];
  const std::string& how = line.words[2];
  const std::string& wanted = line.words[3];
  const std::string is = asked([&] { return host.value_of(key); });
  const auto a = number_in(is);
  const auto b = number_in(wanted);
  const bool are_numbers = a && b;
  bool holds = false;
  if (how == "==")
    holds = are_numbers ? *a == *b : is == wanted;
  else if (how == "!=")
    holds = are_numbers ? *a != *b : is != wanted;
  else if (how == "contains")
    holds = is.find(wanted) != std::string::npos;
  else if (!are_numbers)
    fail(fmt::format("{} is '{}', which is no number", key, is));
  else if (how == "<")
    holds = *a < *b;
  else if (how == "<=")
    holds = *a <= *b;
  else if (how == ">")
    holds = *a > *b;
  else
    holds = *a >= *b;
  if (!holds) fail(fmt::format("{} is '{}', expected {} {}", key, is, how, wanted));
}

// Whether the line that was begun still waits for something.
bool Script::waits(ScriptHost& host) {
  if (frames_to_wait_ > 0) {
    --frames_to_wait_;
    return true;
  }
  const double now = now_ms();
  if (until_ms_ > 0) {
    if (now < until_ms_) return true;
    until_ms_ = 0;
  }
  if (awaited_.empty()) return false;
  if (host.has_come_to(awaited_)) {
    awaited_.clear();
    return false;
  }
  if (now - since_ms_ > kPatienceMs) {
    --at_;
    fail(fmt::format("'{}' was waited for in vain", awaited_));
  }
  return true;
}

// Mouse, keys and drops become frames; false while what is aimed at is not found yet.
bool Script::begin_input(const Line& line, ScriptHost& host) {
  const std::vector<std::string>& words = line.words;
  const std::string& command = words.front();
  std::string target;
  if (command == "move" || command == "click") target = words[1];
  if (command == "drag" || (command == "wheel" && words.size() > 2)) target = words[2];
  ImVec2 place(0, 0);
  if (!target.empty()) {
    const auto found = place_of(target, host);
    if (!found) return false;
    place = *found;
  }
  if (command == "drag") {
    drag(line, place);
  } else if (!target.empty()) {
    move_to(place.x, place.y);
    if (command != "move") frames_.push_back({});  // the item learns that the mouse is over it
  }
  if (command == "click") {
    const std::string how = words.size() > 2 ? words[2] : "left";
    const int button = how == "right" ? GLFW_MOUSE_BUTTON_RIGHT : GLFW_MOUSE_BUTTON_LEFT;
    for (int i = 0; i < (how == "double" ? 2 : 1); ++i) {
      press(button, true);
      press(button, false);
    }
  }
  if (command == "press" || command == "release")
    press(*button_by_name(words[1]), command == "press");
  if (command == "wheel") frames_.push_back({Scrolled{0, *number_in(words[1])}});
  if (command == "key" && words.size() == 3) {
    const int key = key_by_name(words[2]);
    frames_.push_back({KeyChanged{key, words[1] == "down", modifier_of(key)}});
  } else if (command == "key") {
    press_key(words[1]);
  }
  for (std::size_t i = 1; command == "type" && i < words.size(); ++i) {
    for (const char c : words[i])
      frames_.push_back({Typed{static_cast<unsigned>(static_cast<unsigned char>(c))}});
  }
  if (command == "drop") frames_.push_back({Dropped{{words.begin() + 1, words.end()}}});
  if (command == "close") frames_.push_back({CloseAsked{}});
  return true;
}

void Script::ask_host(const Line& line, ScriptHost& host) {
  const std::vector<std::string>& words = line.words;
  const std::string& command = words.front();
  if (command == "resize") {
    const auto [width, height] = *size_in(words[1]);
    host.resize(width, height);
  } else if (command == "screenshot") {
    host.save_screenshot(words[1]);
    frames_.push_back({});  // of the frame that is drawn next
  } else if (command == "picture") {
    asked([&] { host.save_picture(words[1]); });
  } else if (command == "state") {
    asked([&] { host.save_state(words[1]); });
  } else if (command == "expect") {
    expect(line, host);
  } else if (command == "print") {
    const std::string value = asked([&] { return host.value_of(words[1]); });
    cli::print_out("{} = {}\n", words[1], value);
    cli::flush_out();
  } else if (command == "measure") {
    host.begin_measure(words[1]);
  }
}

void Script::begin(const Line& line, ScriptHost& host) {
  const std::vector<std::string>& words = line.words;
  const std::string& command = words.front();
  if (command == "wait" && words.size() == 2) {
    awaited_ = words[1];
    since_ms_ = now_ms();
  } else if (command == "wait" && words[2] == "ms") {
    until_ms_ = now_ms() + *number_in(words[1]);
  } else if (command == "wait") {
    frames_to_wait_ = static_cast<int>(*number_in(words[1]));
  } else if (command == "pace") {
    const double rate = *number_in(words[1]);
    seconds_per_frame_ = rate > 0 ? 1 / rate : 0;
  } else if (command == "repeat") {
    loops_.push_back({at_ + 1, times_in(words[1]).value_or(1) - 1});
  } else if (command == "end") {
    if (!loops_.empty() && loops_.back().left-- > 0) {
      at_ = loops_.back().first;
      return;
    }
    if (!loops_.empty()) loops_.pop_back();
  } else if (begin_input(line, host)) {
    ask_host(line, host);
  } else {
    return;
  }
  ++at_;
  // What follows sees what this has led to.
  static constexpr std::array kActs = {"click", "drag", "key", "wheel", "type", "release", "drop"};
  if (std::find(kActs.begin(), kActs.end(), command) != kActs.end())
    frames_.insert(frames_.end(), kFramesToSettle, Frame{});
}

std::vector<Event> Script::next_frame(ScriptHost& host) {
  while (frames_.empty()) {
    if (waits(host)) return {};
    if (at_ >= lines_.size()) return {};
    const std::size_t before = at_;
    begin(lines_[at_], host);
    if (at_ == before && frames_.empty()) return {};  // looked for, and not found yet
  }
  Frame frame = std::move(frames_.front());
  frames_.erase(frames_.begin());
  return frame;
}

void Recorder::begin(int width, int height) {
  text_ = fmt::format("resize {}x{}\nwait loaded\n", width, height);
}

void Recorder::take(const std::vector<Event>& events, double at_ms) {
  static constexpr std::array<const char*, 3> kButtons = {"left", "right", "middle"};
  if (events.empty()) return;
  if (last_ms_ > 0 && at_ms - last_ms_ >= 1)
    text_ += fmt::format("wait {:.0f} ms\n", at_ms - last_ms_);
  last_ms_ = at_ms;
  for (const Event& event : events) {
    if (const auto* moved = std::get_if<MouseMoved>(&event))
      text_ += fmt::format("move {:g},{:g}\n", moved->x, moved->y);
    if (const auto* button = std::get_if<ButtonChanged>(&event)) {
      if (button->button < 0 || button->button > 2) continue;
      text_ += fmt::format("{} {}\n", button->is_down ? "press" : "release",
                           kButtons[static_cast<std::size_t>(button->button)]);
    }
    if (const auto* scrolled = std::get_if<Scrolled>(&event))
      text_ += fmt::format("wheel {:g}\n", scrolled->dy);
    if (const auto* key = std::get_if<KeyChanged>(&event)) {
      const std::string name = name_of_key(key->key);
      if (!name.empty()) text_ += fmt::format("key {} {}\n", key->is_down ? "down" : "up", name);
    }
    if (const auto* typed = std::get_if<Typed>(&event)) {
      if (typed->codepoint >= ' ' && typed->codepoint < 127 && typed->codepoint != '"')
        text_ += fmt::format("type \"{}\"\n", static_cast<char>(typed->codepoint));
    }
    if (const auto* dropped = std::get_if<Dropped>(&event)) {
      text_ += "drop";
      for (const std::string& path : dropped->paths) text_ += fmt::format(" \"{}\"", path);
      text_ += '\n';
    }
    if (std::holds_alternative<CloseAsked>(event)) text_ += "close\n";
  }
}

void Recorder::write() const { write_file(path_, text_); }

}  // namespace ovoid::viewer
