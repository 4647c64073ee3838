// SPDX-License-Identifier: Apache-2.0
#include "script.h"

#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <fstream>
#include <sstream>
#include <utility>

#include "ovoid/error.h"
#include "session.h"

namespace ovoid::viewer {
namespace {

constexpr double kPatienceMs = 60'000;
constexpr int kMostSearches = 10;
constexpr std::size_t kFramesToSettle = 2;
constexpr std::uintmax_t kMostBytes = 16U << 20;

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

constexpr std::array kCommands = {"wait",    "move",       "press",   "release", "click",
                                  "drag",    "wheel",      "key",     "type",    "drop",
                                  "resize",  "screenshot", "picture", "state",   "expect",
                                  "measure", "repeat",     "end",     "close",   "pace"};

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
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(ErrorCode::kFileNotFound, fmt::format("{}: cannot be opened", path));
  std::string text;
  int number = 0;
  int depth = 0;
  std::uintmax_t bytes = 0;
  while (std::getline(file, text)) {
    ++number;
    bytes += text.size();
    if (bytes > kMostBytes) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: larger than {} MiB", path, kMostBytes >> 20));
    }
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
                fmt::format("{}:{}: {}", path_, line.number, cli::one_line(what)));
  };
  const std::vector<std::string>& words = line.words;
  const std::string& command = words.front();
  if (std::find(kCommands.begin(), kCommands.end(), command) == kCommands.end())
    complain(fmt::format("'{}' is no command", command));
  const auto needs = [&](std::size_t least, std::size_t most, const char* form) {
    if (words.size() < least + 1 || words.size() > most + 1)
      complain(fmt::format("expected: {}", form));
  };
  const auto needs_button = [&](std::size_t at) {
    if (!button_by_name(words[at])) complain(fmt::format("'{}' is no button", words[at]));
  };
  if (command == "wait") needs(1, 2, "wait loaded|full|idle, wait N frames|ms");
  if (command == "wait" && words.size() == 2 && words[1] != "loaded" && words[1] != "full" &&
      words[1] != "idle")
    complain("expected: wait loaded|full|idle, wait N frames|ms");
  if (command == "wait" && words.size() == 3 &&
      (!number_in(words[1]) || (words[2] != "frames" && words[2] != "ms")))
    complain("expected: wait N frames|ms");
  if (command == "move") needs(1, 1, "move TARGET");
  if (command == "press" || command == "release") {
    needs(1, 1, "press|release left|middle|right");
    needs_button(1);
  }
  if (command == "click") needs(1, 2, "click TARGET [left|right|double]");
  if (command == "drag") {
    needs(3, 4, "drag BUTTON TARGET DX,DY [FRAMES]");
    needs_button(1);
    if (!pair_in(words[3])) complain(fmt::format("'{}': expected DX,DY", words[3]));
  }
  if (command == "wheel") {
    needs(1, 2, "wheel NOTCHES [TARGET]");
    if (!number_in(words[1])) complain(fmt::format("'{}': expected a number", words[1]));
  }
  if (command == "key") {
    needs(1, 2, "key CHORD, key down|up KEY");
    const std::string& chord = words.back();
    std::stringstream parts(chord);
    for (std::string part; std::getline(parts, part, '+');) {
      if (key_by_name(part) < 0) complain(fmt::format("'{}' is no key", part));
    }
  }
  if (command == "drop") needs(1, 1000, "drop FILE...");
  if (command == "resize" && (words.size() != 2 || !pair_in(words[1], 'x')))
    complain("expected: resize WIDTHxHEIGHT");
  if (command == "screenshot" || command == "picture" || command == "state")
    needs(1, 1, "screenshot|picture|state FILE");
  if (command == "expect") needs(3, 3, "expect KEY ==|!=|<|<=|>|>=|contains VALUE");
  if (command == "measure") needs(1, 1, "measure NAME");
  if (command == "pace" && (words.size() != 2 || !number_in(words[1]) || *number_in(words[1]) < 0))
    complain("expected: pace FRAMES_PER_SECOND (0: as fast as possible)");
  if (command == "repeat") {
    needs(1, 1, "repeat N");
    if (!number_in(words[1])) complain(fmt::format("'{}': expected a number", words[1]));
    ++*depth;
  }
  if (command == "end" && --*depth < 0) complain("'end' without 'repeat'");
}

void Script::fail(const std::string& what) const {
  const int number = at_ < lines_.size() ? lines_[at_].number : 0;
  throw Error(ErrorCode::kInvalidArgument, fmt::format("{}:{}: {}", path_, number, what));
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
  const double asked = line.words.size() > 4 ? number_in(line.words[4]).value_or(10) : 10;
  const int steps = std::clamp(static_cast<int>(asked), 1, 1'000'000);
  move_to(from.x, from.y);
  press(button, true);
  for (int i = 1; i <= steps; ++i) move_to(from.x + dx * i / steps, from.y + dy * i / steps);
  press(button, false);
}

void Script::expect(const Line& line, const ScriptHost& host) const {
  const std::string& key = line.words[1];
  const std::string& how = line.words[2];
  const std::string& wanted = line.words[3];
  const std::string is = host.value_of(key);
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
  else if (how == ">=")
    holds = *a >= *b;
  else
    fail(fmt::format("'{}' is no comparison", how));
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

void Script::begin(const Line& line, ScriptHost& host) {
  const std::vector<std::string>& words = line.words;
  const std::string& command = words.front();
  if (command == "wait" && words.size() == 2) {
    awaited_ = words[1];
    since_ms_ = now_ms();
  } else if (command == "wait") {
    const double number = *number_in(words[1]);
    if (words[2] == "ms")
      until_ms_ = now_ms() + number;
    else
      frames_to_wait_ = static_cast<int>(number);
  } else if (command == "move" || command == "click") {
    const auto place = place_of(words[1], host);
    if (!place) return;
    move_to(place->x, place->y);
    if (command == "click") {
      frames_.push_back({});  // the item learns that the mouse is over it
      const std::string how = words.size() > 2 ? words[2] : "left";
      const int button = how == "right" ? GLFW_MOUSE_BUTTON_RIGHT : GLFW_MOUSE_BUTTON_LEFT;
      for (int i = 0; i < (how == "double" ? 2 : 1); ++i) {
        press(button, true);
        press(button, false);
      }
    }
  } else if (command == "press" || command == "release") {
    press(*button_by_name(words[1]), command == "press");
  } else if (command == "drag") {
    const auto place = place_of(words[2], host);
    if (!place) return;
    drag(line, *place);
  } else if (command == "wheel") {
    if (words.size() > 2) {
      const auto place = place_of(words[2], host);
      if (!place) return;
      move_to(place->x, place->y);
      frames_.push_back({});
    }
    frames_.push_back({Scrolled{0, *number_in(words[1])}});
  } else if (command == "key" && words.size() == 3) {
    const int key = key_by_name(words[2]);
    frames_.push_back({KeyChanged{key, words[1] == "down", modifier_of(key)}});
  } else if (command == "key") {
    press_key(words[1]);
  } else if (command == "type") {
    for (std::size_t i = 1; i < words.size(); ++i) {
      for (const char c : words[i])
        frames_.push_back({Typed{static_cast<unsigned>(static_cast<unsigned char>(c))}});
    }
  } else if (command == "drop") {
    frames_.push_back({Dropped{{words.begin() + 1, words.end()}}});
  } else if (command == "resize") {
    const auto [width, height] = *pair_in(words[1], 'x');
    host.resize(static_cast<int>(width), static_cast<int>(height));
  } else if (command == "screenshot") {
    host.save_screenshot(words[1]);
  } else if (command == "picture") {
    host.save_picture(words[1]);
  } else if (command == "state") {
    host.save_state(words[1]);
  } else if (command == "expect") {
    expect(line, host);
  } else if (command == "pace") {
    const double rate = *number_in(words[1]);
    seconds_per_frame_ = rate > 0 ? 1 / rate : 0;
  } else if (command == "measure") {
    host.begin_measure(words[1]);
  } else if (command == "repeat") {
    loops_.push_back({at_ + 1, static_cast<long>(*number_in(words[1])) - 1});
  } else if (command == "end") {
    if (!loops_.empty() && loops_.back().left-- > 0) {
      at_ = loops_.back().first;
      return;
    }
    if (!loops_.empty()) loops_.pop_back();
  } else if (command == "close") {
    frames_.push_back({CloseAsked{}});
  }
  if (searches_ > 0) return;
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
      if (typed->codepoint > ' ' && typed->codepoint < 127 && typed->codepoint != '"')
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

void Recorder::write() const { cli::write_text(text_, path_); }

}  // namespace ovoid::viewer
