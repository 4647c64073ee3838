// SPDX-License-Identifier: Apache-2.0
// The extension module ovoid._core: what the package in plain Python stands on. Not for users; its
// arguments are checked there.
#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "arrays.h"
#include "camera_path.h"
#include "color_words.h"
#include "data.h"
#include "errors.h"
#include "film.h"
#include "functions.h"
#include "info.h"
#include "ovoid/error.h"
#include "ovoid/io.h"
#include "ovoid/look.h"
#include "ovoid/series.h"
#include "scene.h"
#include "state_file.h"
#include "suggest.h"
#include "values.h"
#include "waiting.h"

namespace ovoid::python {
namespace {

namespace py = pybind11;
using Json = nlohmann::ordered_json;
// Name, values, unit and, where they are not False, 1 and 0, is_cell_data, value_scale,
// value_offset.
using Arrays = std::vector<py::tuple>;
using SharedDataset = std::shared_ptr<const Dataset>;
// Data in memory by the names that words have for them.
using Beside = std::map<std::string, Data>;

// Names in files may hold any bytes; JSON is UTF-8.
std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::vector<NamedArray> named(const Arrays& arrays) {
  std::vector<NamedArray> all;
  for (const py::tuple& array : arrays) {
    NamedArray& one = all.emplace_back(NamedArray{
        array[0].cast<std::string>(), array[1].cast<py::array>(), array[2].cast<std::string>()});
    if (array.size() > 3) one.is_cell_data = array[3].cast<bool>();
    if (array.size() > 4) one.value_scale = array[4].cast<double>();
    if (array.size() > 5) one.value_offset = array[5].cast<double>();
  }
  return all;
}

std::vector<std::string> array_names(const Data& data) {
  std::vector<std::string> names;
  for (const DataArray& array : data.dataset->arrays) names.push_back(array.name);
  return names;
}

std::array<std::array<double, 4>, 3> matrix_of(const Data& data) {
  std::array<std::array<double, 4>, 3> matrix{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      matrix[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
          data.dataset->lattice.world_from_index.matrix()(row, column);
    }
  }
  return matrix;
}

std::string info_of(const Data& data) {
  std::string text;
  wait_for([&](Work& work) {
    cli::DataFlags files;
    cli::DrawingFlags drawing;
    DrawFlags flags(&files, &drawing);
    flags.parse({});
    cli::Session session([](const std::string&) {}, work.stop);
    const Dataset dataset =
        data.steps == nullptr ? *data.dataset : step_to_show(*data.steps, {}, work.stop);
    text = text_of(cli::info_json(dataset, drawing.model, flags, session));
  });
  return text;
}

std::vector<std::tuple<std::string, int, std::string, std::string>> settings(
    const std::string& command) {
  std::vector<std::tuple<std::string, int, std::string, std::string>> all;
  for (const cli::FlagForm& form : forms_of(command))
    all.emplace_back(form.name, static_cast<int>(form.kind), form.form, form.text);
  return all;
}

Data data_of(Dataset&& dataset) { return {std::make_shared<const Dataset>(std::move(dataset))}; }

// Long work on a dataset that gives another one, with the notes.
using WorkOnData = std::function<Dataset(Work&)>;
std::pair<Data, std::vector<std::string>> data_after(const WorkOnData& make,
                                                     const py::object& on_progress) {
  Dataset made;
  auto notes = wait_for([&](Work& work) { made = make(work); }, on_progress);
  return {data_of(std::move(made)), std::move(notes)};
}

Source source_of(const Data* data, std::vector<std::string> inputs) {
  if (data == nullptr) return {nullptr, std::move(inputs)};
  const auto& steps = data->steps;
  return {steps != nullptr ? steps : make_steps(data->dataset->source, {data->dataset}), {}};
}

// Datasets in memory as the steps of one.
Data series_of(const std::string& name, const std::vector<Data>& steps,
               const std::vector<double>& times, const std::string& unit) {
  std::vector<SharedDataset> datasets;
  datasets.reserve(steps.size());
  for (const Data& step : steps) datasets.push_back(step.dataset);
  const auto made = make_steps(name, std::move(datasets), {times, unit});
  return {std::make_shared<const Dataset>(made->read(0)), made};
}

std::int64_t num_steps_of(const Data& data) {
  return data.steps == nullptr ? 1 : data.steps->num_steps();
}

// None of data that know none.
std::optional<std::vector<double>> times_of(const Data& data) {
  if (data.steps == nullptr || !data.steps->has_times()) return std::nullopt;
  return data.steps->times();
}

Asked asked_for(const cli::Words& words, const Beside& beside) {
  Asked asked{words, {}};
  for (const auto& [name, data] : beside) asked.beside.emplace(name, data.dataset);
  return asked;
}

// Writes a file and tells a report, with the notes.
using Report = std::string (*)(const Source&, const cli::Words&, Work&);
template <Report kMake>
std::pair<std::string, std::vector<std::string>> report_of(const Data* data,
                                                           std::vector<std::string> inputs,
                                                           const cli::Words& words,
                                                           const py::object& on_progress) {
  const Source source = source_of(data, std::move(inputs));
  std::string report;
  auto notes = wait_for([&](Work& work) { report = kMake(source, words, work); }, on_progress);
  return {std::move(report), std::move(notes)};
}

// Whether memory does not hold a field of an array's values: as read_dataset() decides of files.
bool would_stay_in_file(const std::string& type, std::int64_t num_values, const cli::Words& words) {
  cli::DataFlags data;
  cli::Flags flags("read", "DATA", "Reads data.");
  cli::add_input_flags(flags, &data);
  flags.parse(words);
  ReadOptions options;
  options.memory_limit = static_cast<std::int64_t>(data.memory_limit.value_or(0));
  for (const ScalarType one : {ScalarType::kUInt8, ScalarType::kInt8, ScalarType::kUInt16,
                               ScalarType::kInt16, ScalarType::kFloat32}) {
    if (type == name_of(one)) {
      const auto size = static_cast<std::int64_t>(size_of(one));
      return ovoid::would_stay_in_file(one, num_values * size, options);
    }
  }
  return false;
}

py::array eight_bits(const Picture& picture) {
  const Image& image = picture.seen();
  std::vector<std::uint8_t> rgba;
  {
    const py::gil_scoped_release unlocked;
    rgba = to_rgba8(image, picture.drawing.background);
  }
  auto* const kept = new std::vector<std::uint8_t>(std::move(rgba));
  const py::capsule keeper(
      kept, [](void* pixels) { delete static_cast<std::vector<std::uint8_t>*>(pixels); });
  return py::array_t<std::uint8_t>({image.height, image.width, 4}, kept->data(), keeper);
}

// A scene's threads end without Python's lock, which their last words may need.
std::shared_ptr<Scene> make_scene(const Data* data, std::vector<std::string> inputs) {
  const auto end = [](Scene* scene) {
    const py::gil_scoped_release unlocked;
    delete scene;
  };
  return {new Scene(source_of(data, std::move(inputs))), end};
}

void add_data(py::module_& module) {
  py::class_<Data>(module, "Data")
      .def_property_readonly("kind", [](const Data& d) { return name_of(d.dataset->kind); })
      .def_property_readonly("source", [](const Data& d) { return d.dataset->source; })
      .def_property_readonly("format", [](const Data& d) { return d.dataset->format; })
      .def_property_readonly("space", [](const Data& d) { return name_of(d.dataset->space); })
      .def_property_readonly("dims", [](const Data& d) { return d.dataset->lattice.dims; })
      .def_property_readonly(
          "is_cartesian",
          [](const Data& d) { return d.dataset->lattice.kind == LatticeKind::kCartesian; })
      .def_property_readonly("matrix", matrix_of)
      .def_property_readonly("notes", [](const Data& d) { return d.dataset->notes; })
      .def_property_readonly("array_names", array_names)
      .def("positions", [](const Data& d) { return to_numpy(d.dataset->positions); })
      .def("array", [](const Data& d, std::size_t i) { return to_numpy(d.dataset->arrays.at(i)); })
      .def("array_unit", [](const Data& d, std::size_t i) { return d.dataset->arrays.at(i).unit; })
      .def("is_cell_data",
           [](const Data& d, std::size_t i) { return d.dataset->arrays.at(i).is_cell_data; })
      .def("value_scale",
           [](const Data& d, std::size_t i) {
             const DataArray& array = d.dataset->arrays.at(i);
             return std::pair(array.value_scale, array.value_offset);
           })
      .def("connectivity", [](const Data& d) { return node_numbers(d.dataset); })
      .def("with_facts",
           [](const Data& d, const std::string& format, const std::string& space,
              const std::vector<std::string>& notes) {
             return Data{with_facts(*d.dataset, {format, space, notes})};
           })
      .def_property_readonly("num_steps", num_steps_of)
      .def_property_readonly("times", times_of)
      .def_property_readonly("time_unit", [](const Data& d) { return d.dataset->time_unit; })
      .def("info", info_of)
      .def("named",
           [](const Data& d, const std::string& source) {
             auto copy = std::make_shared<Dataset>(*d.dataset);
             copy->source = source;
             return Data{std::move(copy), d.steps};
           })
      .def("write", [](const Data& data, const std::string& path) {
        wait_for([&](Work& work) { write_dataset(*data.dataset, path, {.stop = work.stop}); });
      });
  module.def("lattice",
             [](const std::string& source, const Index3& dims,
                const std::array<std::array<double, 4>, 3>& matrix, const Arrays& arrays) {
               return Data{make_lattice(source, dims, matrix, named(arrays))};
             });
  module.def("lattice_of", [](const Data& read, const std::string& source, const Index3& dims,
                              const std::array<std::array<double, 4>, 3>& matrix,
                              const std::string& name, const std::string& unit) {
    return Data{make_lattice_of(*read.dataset, source, dims, matrix, name, unit)};
  });
  module.def("would_stay_in_file", would_stay_in_file);
  module.def("particles",
             [](const std::string& source, const py::array& positions, const Arrays& arrays) {
               return Data{make_particles(source, positions, named(arrays))};
             });
  module.def("mesh", [](const std::string& source, const py::array& positions,
                        const py::array& types, const py::array& offsets,
                        const py::array& connectivity, const Index3& dims, const Arrays& arrays) {
    return Data{make_mesh(source, positions, {types, offsets, connectivity, dims}, named(arrays))};
  });
  module.def("series", series_of);
  module.def("read", [](const std::vector<std::string>& inputs, const cli::Words& words,
                        bool may_stay, const py::object& on_progress) {
    return data_after([&](Work& work) { return read_files(inputs, words, may_stay, work); },
                      on_progress);
  });
  module.def(
      "convert", [](const Data* data, std::vector<std::string> inputs, const cli::Words& words) {
        const Source source = source_of(data, std::move(inputs));
        return data_after([&](Work& work) { return convert(source, words, work); }, py::none());
      });
  module.def("fit", report_of<fit>);
  module.def("simplify", report_of<simplify>);
}

// The cameras of a film's frames, whose first picture without a path is this one; `count` 0: up to
// the last key.
std::vector<std::string> cameras_along(const Picture& picture, const std::string& path,
                                       std::int64_t count) {
  const cli::CameraPath keys = cli::CameraPath::of_flag(path);
  if (keys.is_timed()) {
    throw Error(ErrorCode::kUnsupported,
                keys.source() +
                    ": its keys are at times, expected frames; `ovoid animate` draws "
                    "files in time along it");
  }
  const cli::CameraTrack track(keys, picture.unturned, picture.drawing.camera);
  std::vector<std::string> cameras;
  const std::int64_t num_frames = count > 0 ? count : keys.num_frames();
  for (std::int64_t frame = 0; frame < num_frames; ++frame)
    cameras.push_back(to_text(track.at(static_cast<double>(frame))));
  return cameras;
}

// A colour's word as "#rrggbb".
std::string color_text(const std::string& word) {
  try {
    return cli::hex_text(cli::color_of_word(word));
  } catch (const cli::BadValue& error) {
    throw Error(ErrorCode::kInvalidArgument, fmt::format("'{}': {}", word, error.what()));
  }
}

void add_picture(py::module_& module) {
  using Shared = std::shared_ptr<Picture>;
  py::class_<Picture, Shared>(module, "Picture")
      .def_property_readonly("width", [](const Picture& p) { return p.image.width; })
      .def_property_readonly("height", [](const Picture& p) { return p.image.height; })
      .def_property_readonly("notes", [](const Picture& p) { return p.notes; })
      .def_property_readonly("inputs", [](const Picture& p) { return p.inputs; })
      .def_property_readonly("words", [](const Picture& p) { return p.flags.words(); })
      .def_property_readonly("flags", [](const Picture& p) { return text_of(p.flags.to_json()); })
      .def_property_readonly("profile", [](const Picture& p) { return cli::to_json(p.profile); })
      .def_property_readonly("camera", [](const Picture& p) { return to_text(p.shot.camera); })
      .def_property_readonly("unturned", [](const Picture& p) { return to_text(p.unturned); })
      .def("cameras_along", cameras_along)
      .def_property_readonly("look", [](const Picture& p) { return to_text(p.shot.look()); })
      .def_property_readonly("values",
                             [](const Picture& p) {
                               return std::pair(p.values.lo,
                                                p.values.hi);  // of nothing the first is greater
                             })
      .def_property_readonly("sampling_distance",
                             [](const Picture& p) { return p.sampling_distance; })
      .def_property_readonly("unit_distance", [](const Picture& p) { return p.unit_distance; })
      .def_property_readonly("num_steps", [](const Picture& p) { return p.num_steps; })
      .def_property_readonly("step", [](const Picture& p) { return p.step; })
      .def_property_readonly("is_series", [](const Picture& p) { return p.is_series; })
      .def("encode",
           [](const Picture& picture, const std::string& ending, int quality) {
             std::string bytes;
             wait_for([&](Work&) { bytes = encode_picture(picture, ending, quality); });
             return py::bytes(bytes);
           })
      .def("rgba8", eight_bits)
      .def("rgba",
           [](const Shared& p) {
             return float_view(p->image.rgba, {p->image.height, p->image.width, 4}, p);
           })
      .def("depth",
           [](const Shared& p) {
             return float_view(p->image.depth, {p->image.height, p->image.width}, p);
           })
      .def("pick",
           [](const Shared& picture, int x, int y) {
             std::string found;
             wait_for([&](Work&) { found = picked(*picture, x, y); });
             return found;
           })
      .def("save", [](const Shared& picture, const std::string& path) {
        wait_for([&](Work& work) { save_picture(*picture, path, work.stop); });
      });
}

py::tuple histogram(Scene& scene, const cli::Words& words, const Beside& beside,
                    bool is_logarithmic) {
  const Asked asked = asked_for(words, beside);
  cli::Histogram found;
  wait_for([&](Work& work) { found = scene.histogram(asked, work); });
  const cli::Histogram::Bins& bins = is_logarithmic ? found.logarithmic : found.linear;
  py::array counts = copy_of(bins.counts);
  return py::make_tuple(std::move(counts), bins.lo, bins.hi);
}

using Place = std::array<double, 3>;
Place place_of(const Vec3& at) { return {at.x(), at.y(), at.z()}; }

std::pair<Place, Place> bounds(Scene& scene, const cli::Words& words, const Beside& beside) {
  const Asked asked = asked_for(words, beside);
  Bounds3 box;
  wait_for([&](Work& work) { box = scene.bounds(asked, work); });
  return {place_of(box.min()), place_of(box.max())};
}

void add_scene(py::module_& module) {
  py::class_<Scene, std::shared_ptr<Scene>>(module, "Scene")
      .def(py::init(&make_scene))
      .def(
          "draw",
          [](Scene& scene, const cli::Words& words, const Beside& beside, bool with_stages,
             const py::object& on_progress, int coarseness) {
            const Asked asked = asked_for(words, beside);
            std::shared_ptr<Picture> picture;
            wait_for(
                [&](Work& work) {
                  picture = scene.draw(asked, {with_stages, coarseness}, work);
                },
                on_progress);
            return picture;
          },
          py::arg("words"), py::arg("beside"), py::arg("with_stages"), py::arg("on_progress"),
          py::arg("coarseness") = 0)
      .def("bounds", bounds)
      .def("histogram", histogram)
      .def("sample",
           [](Scene& scene, const cli::Words& words, const Beside& beside, const Data& points,
              const py::object& on_progress) {
             const Asked asked = asked_for(words, beside);
             return data_after(
                 [&](Work& work) { return scene.sample(asked, *points.dataset, work); },
                 on_progress);
           })
      .def("resample",
           [](Scene& scene, const cli::Words& words, const Beside& beside, const Index3& dims,
              const std::array<std::array<double, 4>, 3>& matrix, const py::object& on_progress) {
             const Asked asked = asked_for(words, beside);
             const LatticeGeometry lattice = geometry_of(dims, matrix);
             return data_after([&](Work& work) { return scene.resample(asked, lattice, work); },
                               on_progress);
           });
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  cli::Progress::be_silent();
  translate_errors();
  add_data(module);
  add_picture(module);
  add_scene(module);
  module.attr("version") = OVOID_VERSION;
  module.def("settings", settings);
  module.def("color_map_names", color_map_names);
  module.def("read_state", [](const std::string& path) {
    const cli::State state = cli::read_state(path);
    return std::pair(state.inputs, text_of(state.flags.to_json()));
  });
  module.def("did_you_mean", cli::did_you_mean);
  module.def("color_text", color_text);
  module.def("quoted", cli::quoted);
  module.def("make_film", [](const std::string& frames, std::int64_t num_frames,
                             const std::string& path, double fps) {
    const std::string ffmpeg = cli::needs_ffmpeg(path) ? cli::find_ffmpeg(path) : "";
    wait_for([&](Work& work) {
      const cli::Session session([](const std::string&) {}, work.stop);
      cli::make_film({path, frames, num_frames, fps}, ffmpeg, session);
    });
  });
}

}  // namespace ovoid::python
