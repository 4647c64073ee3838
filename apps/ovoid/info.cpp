// SPDX-License-Identifier: Apache-2.0
// ovoid info: what is in a file, and how it would be drawn. The facts are gathered as JSON, from
// which the text for people is printed too, so that both say the same.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "command.h"
#include "console.h"
#include "environment.h"
#include "histogram_2d.h"
#include "info.h"
#include "info_text.h"
#include "load.h"
#include "make_field.h"
#include "ovoid/devices.h"
#include "profile.h"
#include "setting_forms.h"

namespace ovoid::cli {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const DeviceInfo& device) {
  return {{"index", device.index},
          {"name", device.name},
          {"kind", name_of(device.kind)},
          {"memory_bytes", device.memory_bytes},
          {"driver", device.driver},
          {"vulkan", device.api_version},
          {"lack", device.lack.empty() ? Json(nullptr) : Json(device.lack)}};
}

Json devices_json() {
  const DeviceList list = list_devices(setup_of_environment().vulkan);
  Json vulkan;
  vulkan["backend"] = "vulkan";
  vulkan["devices"] = Json::array();
  for (const DeviceInfo& device : list.devices) vulkan["devices"].push_back(json_of(device));
  vulkan["problem"] = list.problem.empty() ? Json(nullptr) : Json(list.problem);
  Json cpu;
  cpu["backend"] = "cpu";
  cpu["simd_targets"] = simd_targets();
  Json reference;
  reference["backend"] = "reference";
  return Json::array({vulkan, cpu, reference});
}

std::string device_text(const Json& device) {
  std::string text = fmt::format(
      "device {}: {}, {}, {}, {}, Vulkan {}", number_text(device["index"]),
      one_line(device["name"].get<std::string>()), device["kind"].get<std::string>(),
      readable_bytes(device["memory_bytes"].get<double>()),
      one_line(device["driver"].get<std::string>()), device["vulkan"].get<std::string>());
  if (device["lack"].is_null()) return text;
  return fmt::format("{}; not usable: it {}", text, device["lack"].get<std::string>());
}

void print_devices(const Json& devices) {
  for (const Json& device : devices) {
    const auto name = device["backend"].get<std::string>();
    const auto print_line = [&](const std::string& text) { print_out("{:<12}{}\n", name, text); };
    if (name == "vulkan") {
      for (const Json& one : device["devices"]) print_line(device_text(one));
      if (!device["problem"].is_null())
        print_line("none: " + one_line(device["problem"].get<std::string>()));
    } else if (name == "cpu") {
      print_line(
          fmt::format("SIMD targets, best first: {}",
                      fmt::join(device["simd_targets"].get<std::vector<std::string>>(), ", ")));
    } else {
      print_line("double precision, slow: the definition");
    }
  }
}

void print_json(const Json& json) {
  // Names in files may hold any bytes; JSON is UTF-8.
  print_out("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

struct InfoFlags {
  bool is_json = false;
  bool lists_devices = false;
  std::string histogram_2d;  // a file; empty: none
};

const Table<InfoFlags>& info_settings() {
  static const Table<InfoFlags> all = {
      {"--json", Toggle(), &InfoFlags::is_json, "as JSON"},
      {"--devices", Toggle(), &InfoFlags::lists_devices,
       "list what can draw on this machine; needs no INPUT"},
      {"--histogram2d", word("OUT.png|OUT.json", Content::kFile), &InfoFlags::histogram_2d,
       "write how often values and gradients go together, as a picture (gradients upwards, the "
       "brighter the more, by the logarithm) or as counts: for choosing the regions of --tf2d"},
  };
  return all;
}

}  // namespace

void run_info(const Words& words, Session& session) {
  DataFlags data;
  ModelFlags model;
  InfoFlags info;
  Flags flags("info", "INPUT... [FLAG...]", "Tells what is in a file, and how it would be drawn.");
  flags.section("");
  flags.add(info_settings(), &info);
  add_input_flags(flags, &data);
  add_array_flags(flags, &model);
  add_kernel_flags(flags, &model);
  flags.add(relevant_settings(), &model);
  if (!flags.parse(words)) return;

  if (info.lists_devices) {
    const Json devices = devices_json();
    return info.is_json ? print_json(devices) : print_devices(devices);
  }
  require_inputs(flags, data);
  take_from_model(&data, &model);
  data.may_stay_in_file = true;
  const Dataset dataset = load(data, session);
  const Json json = info_json(dataset, model, flags, session);
  if (!info.histogram_2d.empty()) {
    const Field field = make_field(dataset, model, 0, session).field;
    const Histogram2D histogram = histogram_2d_of(field, session.stop());
    write_histogram_2d(histogram, info.histogram_2d);
    session.note(fmt::format("{}: values {:g} to {:g}, gradients 0 to {:g}", info.histogram_2d,
                             histogram.value_lo, histogram.value_hi, histogram.gradient_hi));
  }
  return info.is_json ? print_json(json) : print_info(json);
}

}  // namespace ovoid::cli
