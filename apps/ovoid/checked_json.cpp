// SPDX-License-Identifier: Apache-2.0
#include "checked_json.h"

#include <fmt/format.h>

#include <unordered_set>
#include <vector>

#include "console.h"
#include "ovoid/error.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kMaxDepth = 64;
// Of one object: members are found one after the other, so that their number must not be the
// file's to choose.
constexpr std::size_t kMaxMembers = 1000;

[[noreturn]] void refuse_json(const std::string& message) {
  throw Error(ErrorCode::kFileFormat, message);
}

// Refuses while it is read.
class Watch {
 public:
  explicit Watch(const std::string& source) : source_(source) {}

  bool operator()(int depth, Json::parse_event_t event, const Json& parsed) {
    if (depth > kMaxDepth)
      refuse_json(fmt::format("{}: nested deeper than {} levels", source_, kMaxDepth));
    if (event == Json::parse_event_t::object_start) open_.emplace_back();
    if (event == Json::parse_event_t::object_end) open_.pop_back();
    if (event != Json::parse_event_t::key) return true;
    const std::string& key = parsed.get_ref<const std::string&>();
    if (!open_.back().insert(key).second)
      refuse_json(fmt::format("{}: '{}' stands twice in one object", source_, cut_line(key)));
    if (open_.back().size() > kMaxMembers)
      refuse_json(fmt::format("{}: an object has more than {} members", source_, kMaxMembers));
    return true;
  }

 private:
  const std::string& source_;
  std::vector<std::unordered_set<std::string>> open_;
};

}  // namespace

std::string cut_line(const std::string& text) {
  constexpr std::size_t kShown = 40;
  return one_line(text.substr(0, kShown));
}

Json checked_json(const std::string& text, const std::string& source) {
  Watch watch(source);
  const auto callback = [&watch](int depth, Json::parse_event_t event, Json& parsed) {
    return watch(depth, event, parsed);
  };
  try {
    return Json::parse(text, callback);
  } catch (const Json::parse_error& error) {
    refuse_json(fmt::format("{}: not JSON at byte {}", source, error.byte));
  } catch (const Json::exception&) {
    refuse_json(source + ": holds a number that double cannot");
  }
}

}  // namespace ovoid::cli
