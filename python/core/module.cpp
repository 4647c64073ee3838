// SPDX-License-Identifier: Apache-2.0
// The extension module ovoid._core: what the package in plain Python stands on. Not for users; its
// arguments are checked there.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "arrays.h"
#include "errors.h"
#include "film.h"
#include "info.h"
#include "ovoid/io.h"
#include "ovoid/look.h"
#include "scene.h"
#include "suggest.h"
#include "waiting.h"

namespace ovoid::python {
namespace {

namespace py = pybind11;
using Json = nlohmann::ordered_json;
using Arrays = std::vector<std::tuple<std::string, py::array, std::string>>;
using SharedDataset = std::shared_ptr<const Dataset>;

// Names in files may hold any bytes; JSON is UTF-8.
std::string text_of(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::vector<NamedArray> named(const Arrays& arrays) {
  std::vector<NamedArray> all;
  for (const auto& [name, values, unit] : arrays) all.push_back({name, values, unit});
  return all;
}

// A dataset that Python holds.
struct Data {
  SharedDataset dataset;
};

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
    text = text_of(cli::info_json(*data.dataset, drawing.model, flags, session));
  });
  return text;
}

std::vector<std::tuple<std::string, int, std::string, std::string>> settings() {
  cli::DataFlags data;
  cli::DrawingFlags drawing;
  std::vector<std::tuple<std::string, int, std::string, std::string>> all;
  const DrawFlags flags(&data, &drawing);
  for (const cli::FlagForm& form : flags.forms())
    all.emplace_back(form.name, static_cast<int>(form.kind), form.form, form.text);
  return all;
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
  return {new Scene(data == nullptr ? nullptr : data->dataset, std::move(inputs)), end};
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
      .def("info", info_of)
      .def("write", [](const Data& data, const std::string& path) {
        wait_for([&](Work& work) { write_dataset(*data.dataset, path, {.stop = work.stop}); });
      });
  module.def("lattice",
             [](const std::string& source, const Index3& dims,
                const std::array<std::array<double, 4>, 3>& matrix, const Arrays& arrays) {
               return Data{make_lattice(source, dims, matrix, named(arrays))};
             });
  module.def("particles",
             [](const std::string& source, const py::array& positions, const Arrays& arrays) {
               return Data{make_particles(source, positions, named(arrays))};
             });
  module.def("read", [](const std::vector<std::string>& inputs, const cli::Words& words) {
    SharedDataset dataset;
    auto notes = wait_for([&](Work& work) { dataset = read_files(inputs, words, work); });
    return std::pair(Data{std::move(dataset)}, std::move(notes));
  });
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
      .def_property_readonly("look", [](const Picture& p) { return to_text(p.shot.look); })
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
      .def("save", [](const Shared& picture, const std::string& path) {
        wait_for([&](Work& work) { save_picture(*picture, path, work.stop); });
      });
}

void add_scene(py::module_& module) {
  py::class_<Scene, std::shared_ptr<Scene>>(module, "Scene")
      .def(py::init(&make_scene))
      .def(
          "draw",
          [](Scene& scene, const cli::Words& words, bool with_stages, const py::object& on_progress,
             int coarseness) {
            std::shared_ptr<Picture> picture;
            wait_for(
                [&](Work& work) {
                  picture = scene.draw(words, {with_stages, coarseness}, work);
                },
                on_progress);
            return picture;
          },
          py::arg("words"), py::arg("with_stages"), py::arg("on_progress"),
          py::arg("coarseness") = 0);
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
  module.def("did_you_mean", cli::did_you_mean);
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
