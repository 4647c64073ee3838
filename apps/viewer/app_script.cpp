// SPDX-License-Identifier: Apache-2.0
// What scripts see of the program.
#include <fmt/format.h>
#include <imgui.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <utility>

#include "app.h"
#include "command.h"
#include "ovoid/error.h"
#include "ovoid/io.h"

#ifdef __linux__
#include <unistd.h>
#endif

namespace ovoid::viewer {
namespace {

double resident_mib() {
#ifdef __linux__
  std::ifstream file("/proc/self/statm");
  double all = 0;
  double resident = 0;
  file >> all >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1048576;
#else
  return 0;
#endif
}

std::string plain(const nlohmann::ordered_json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

nlohmann::ordered_json to_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::ordered_json to_json(const std::vector<OpacityPoint>& points) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const OpacityPoint& point : points)
    list.push_back({{"x", point.x}, {"opacity", point.opacity}});
  return list;
}

nlohmann::ordered_json to_json(const TransferFunction2D& function) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const LookRegion& region : function.regions()) {
    list.push_back({{"shape", region.shape == LookRegion::Shape::kBox ? "box" : "gaussian"},
                    {"values", region.values},
                    {"gradients", region.gradients},
                    {"rgb", region.rgb},
                    {"opacity", region.opacity},
                    {"softness", region.softness},
                    {"foot", region.foot}});
  }
  return list;
}

nlohmann::ordered_json to_json(const View& view) {
  const TransferFunction& tf = view.look.transfer_function;
  nlohmann::ordered_json json = {{"points", tf.opacities.size()},
                                 {"opacities", to_json(tf.opacities)},
                                 {"colors", tf.colors.size()},
                                 {"gradient_points", tf.gradient_opacities.size()},
                                 {"range", {tf.lo(), tf.hi()}},
                                 {"mode", cli::name_of_mode(view.look.mode)},
                                 {"isovalue", view.look.isovalue},
                                 {"isosurfaces", view.look.isosurfaces.size()},
                                 {"shade", view.look.shade},
                                 {"unit_distance", view.look.unit_distance},
                                 {"sampling_distance", view.options.sampling_distance},
                                 {"clips", view.clip_planes.size()},
                                 {"has_crop", view.crop.has_value()},
                                 {"has_plane", view.plane.has_value()}};
  const auto& function = view.look.transfer_function_2d;
  json["is_2d"] = function.has_value();
  json["regions"] = function ? function->regions().size() : 0;
  if (function) json["region"] = to_json(*function);
  for (const Isosurface& surface : view.look.isosurfaces) {
    json["isosurface"].push_back({{"value", surface.value},
                                  {"opacity", surface.opacity},
                                  {"has_color", surface.color.has_value()}});
  }
  if (view.plane) json["plane"] = {{"offset", view.plane->offset}};
  if (view.crop)
    json["crop"] = {{"min", to_json(view.crop->min())}, {"max", to_json(view.crop->max())}};
  for (const ClipPlane& plane : view.clip_planes)
    json["clip"].push_back({{"normal", to_json(plane.normal)}, {"offset", plane.offset}});
  return json;
}

}  // namespace

std::optional<Box2> App::find(const std::string& name) const { return widgets_.find(name); }

bool App::scroll_to(const std::string& name) {
  frames_due_ = std::max(frames_due_, 2);
  return widgets_.scroll_to(name);
}

bool App::has_come_to(const std::string& state) const {
  const bool has_failed = !load_error_.empty() && !loader_->is_busy();
  const bool is_loaded = document_.is_open() || has_failed;
  if (state == "loaded") return is_loaded;
  if (has_failed && !document_.is_open()) return true;
  if (!document_.is_open() || is_moving_ || waits_for_time_ || progress_) return false;
  // A solid that cannot be made is not waited for.
  if (!document_.shown->is_of(document_.view.solid) && loader_->is_busy()) return false;
  if (!document_.surfaces_to_make().empty() && loader_->is_busy()) return false;
  const bool is_full =
      picture_view_.full(document_) != nullptr || failed_version_ == document_.version();
  if (state == "full") return is_full;
  return is_full && !loader_->is_busy() && worker_->is_idle() && !status_.fit.is_running;
}

nlohmann::ordered_json App::facts() const {
  nlohmann::ordered_json json = {{"is_open", document_.is_open()},
                                 {"error", load_error_},
                                 {"message", last_message_},
                                 {"memory_mib", resident_mib()},
                                 {"has_panel", has_panel_},
                                 {"clipboard", window_.clipboard()},
                                 {"help", shows_help_}};
  json["interface_scale"] = gui_.scale();
  json["is_browsing"] = dialog_.is_shown();
  json["recent"] = nlohmann::ordered_json::array();
  for (const RecentInput& input : memory_.recent())
    json["recent"].push_back({{"title", input.title()}, {"is_there", input.is_there}});
  json["theme"] = cli::name_in(theme_names(), theme_);
  if (!document_.is_open()) return json;
  const Size size = picture_size();
  json["picture"] = {{"width", size.width}, {"height", size.height}};
  json["version"] = document_.version();
  json["level"] = {{"pixels", status_.level.pixels}, {"field", status_.level.field}};
  json["is_final"] = status_.is_final;
  json["array"] = document_.shown->array;
  json["color_array"] = document_.shown->color_array;
  json["component"] = document_.shown->component;
  json["kernels"] = document_.shown->field().num_kernels();
  json["quality"] = quality_name(document_);
  json["view"] = to_json(document_.view);
  const Camera& camera = document_.camera;
  json["camera"] = {{"position", to_json(camera.position)},
                    {"focal_point", to_json(camera.focal_point)},
                    {"view_up", to_json(camera.view_up)},
                    {"parallel", camera.parallel_projection},
                    {"distance", (camera.position - camera.focal_point).norm()},
                    {"parallel_scale", camera.parallel_scale}};
  json["time"] = {{"now", document_.shown->time},
                  {"is_playing", document_.time.is_playing},
                  {"steps", document_.info->times.size()}};
  json["can_undo"] = document_.can_undo();
  json["can_redo"] = document_.can_redo();
  json["compare"] = {{"mode", static_cast<int>(document_.compare)},
                     {"divider", picture_view_.divider()},
                     {"psnr", std::isfinite(status_.psnr) ? status_.psnr : 1e9}};
  json["fit"] = facts_of_fit();
  json["scene"] = facts_of_scene();
  if (document_.view.solid) json["solid"] = facts_of_solid();
  json["backend"] = status_.profile.backend;
  json["has_extras"] = document_.extras != nullptr;
  json["has_counted_2d"] = document_.counted_2d && document_.counted_2d->histogram;
  json["selected_region"] = panel_state_.regions.editing.selected;
  if (const auto& picked = picture_view_.picked()) {
    json["picked"] = {{"position", to_json(picked->position)},
                      {"value", picked->value},
                      {"is_defined", picked->is_defined}};
  }
  return json;
}

nlohmann::ordered_json App::facts_of_fit() const {
  nlohmann::ordered_json json = {{"is_running", status_.fit.is_running},
                                 {"fraction", status_.fit.fraction},
                                 {"error", panel_state_.fit.error},
                                 {"has_result", document_.fit != nullptr},
                                 {"is_of_shown", document_.has_fit_of_shown()},
                                 {"is_compared", document_.compares_fit()}};
  if (document_.fit == nullptr) return json;
  const FitReport& report = document_.fit->report;
  json["kernels"] = report.kernels;
  json["bytes"] = report.bytes;
  json["psnr"] = std::isfinite(report.psnr) ? report.psnr : 1e9;
  json["greatest_error"] = report.greatest_error;
  return json;
}

nlohmann::ordered_json App::facts_of_solid() const {
  const SolidShape& solid = *document_.view.solid;
  const int vertex = panel_state_.vertex;
  nlohmann::ordered_json json = {{"levels", solid.levels},
                                 {"basis", name_of(solid.basis)},
                                 {"vertices", solid.control->num_vertices()},
                                 {"vertex", vertex},
                                 {"is_saved", document_.control_file() != nullptr},
                                 {"refusal", panel_state_.vertex_refusal}};
  if (vertex < 0) return json;
  json["place"] = to_json(solid.control->position(static_cast<std::size_t>(vertex)));
  json["density"] = solid.control->densities[static_cast<std::size_t>(vertex)];
  return json;
}

// "camera.position.0": members and elements by dots.
std::string App::value_of(const std::string& key) const {
  nlohmann::ordered_json at = facts();
  if (key == "all") return at.dump();
  std::stringstream parts(key);
  for (std::string part; std::getline(parts, part, '.');) {
    nlohmann::ordered_json next;
    if (at.is_object() && at.contains(part)) {
      next = at[part];
    } else if (at.is_array() && !part.empty() &&
               part.find_first_not_of("0123456789") == std::string::npos && part.size() < 6 &&
               std::stoul(part) < at.size()) {
      next = at[std::stoul(part)];
    } else {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("'{}': nothing is known by that name", key));
    }
    at = std::move(next);
  }
  return plain(at);
}

void App::save_screenshot(const std::string& path) {
  screenshot_wish_ = path;
  frames_due_ = std::max(frames_due_, 1);
}

void App::write_screenshot() {
  Size size;
  const std::vector<std::uint8_t> rgb = gui_.pixels(&size);
  Image image;
  image.width = size.width;
  image.height = size.height;
  const std::size_t pixels = rgb.size() / 3;
  image.rgba.resize(pixels * 4);
  image.depth.assign(pixels, 0.0F);
  image.front_depth = image.depth;
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c)
      image.rgba[i * 4 + c] = static_cast<float>(rgb[i * 3 + c]) / 255.0F;
    image.rgba[i * 4 + 3] = 1;
  }
  write_image(image, std::exchange(screenshot_wish_, {}));  // scripts alone ask for it
}

void App::save_picture(const std::string& path) {
  if (picture_view_.full(document_) == nullptr)
    throw Error(ErrorCode::kInvalidArgument, "picture: the full one is not there yet (wait full)");
  save_the_picture(path);
}

void App::resize(int width, int height) {
  window_.resize({std::max(width, 1), std::max(height, 1)});
  frames_due_ = std::max(frames_due_, 3);
}

void App::begin_measure(const std::string& name) { meter_.begin(name); }

}  // namespace ovoid::viewer
