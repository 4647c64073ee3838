// SPDX-License-Identifier: Apache-2.0
// Does with VTK what `ovoid render --repeat N` does, and times it: one VTI volume, VTU mesh or PLY
// file of particles, a ParaView preset as look, a camera file, a picture size, a sampling distance.
// One warm-up frame, then N frames, the camera turned by 0.01 degree before each. Particles are
// first put on a grid, VTK's way to a volume of them; their value is the height y. Prints JSON:
//
//   frame_ms   Render() until the picture stands in the off-screen window, everything included
//   cast_ms    of it what the mapper itself says it took (fixed: without the upload of the
//   picture), null for the others
//   prepare_ms reading, and cutting a mesh into tetrahedra, which its mappers ask for, or putting
//   particles on a grid
//
// The picture it writes is the warm-up frame, so that it can be laid beside Ovoid's.
#include <vtkCamera.h>
#include <vtkColorTransferFunction.h>
#include <vtkDataSetTriangleFilter.h>
#include <vtkElevationFilter.h>
#include <vtkFixedPointVolumeRayCastMapper.h>
#include <vtkGaussianKernel.h>
#include <vtkGaussianSplatter.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkOpenGLGPUVolumeRayCastMapper.h>
#include <vtkPLYReader.h>
#include <vtkPNMWriter.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkPointInterpolator.h>
#include <vtkPolyData.h>
#include <vtkProjectedTetrahedraMapper.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkSPHCubicKernel.h>
#include <vtkSPHInterpolator.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridVolumeRayCastMapper.h>
#include <vtkUnstructuredGridVolumeZSweepMapper.h>
#include <vtkVersion.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>
#include <vtkWindowToImageFilter.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <exception>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using Json = nlohmann::json;

struct Settings {
  std::string volume, look, camera, picture, mapper = "fixed", array, grid;
  int width = 512, height = 512, threads = 2, repeat = 10, grid_size = 256;
  double sampling_distance = 1, unit_distance = 1;
  bool shade = true;
  double ambient = 0.1, diffuse = 0.7, specular = 0.2, specular_power = 10;
};

Json read_json(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be opened");
  return Json::parse(file);
}

// A ramp over the values, for grids of which nobody knows the values beforehand.
Json ramp_over(const std::array<double, 2>& range) {
  const auto [low, high] = range;
  return {{"RGBPoints", {low, 0.2, 0.3, 0.8, high, 0.9, 0.5, 0.2}},
          {"Points", {low, 0, 0.5, 0, low + 0.3 * (high - low), 0, 0.5, 0, high, 0.3, 0.5, 0}}};
}

// A preset file is a list of presets or a single one.
void apply_look(const Settings& settings, const std::array<double, 2>& range,
                vtkVolumeProperty* property) {
  Json preset = settings.look.empty() ? ramp_over(range) : read_json(settings.look);
  if (preset.is_array()) preset = preset.at(0);

  vtkNew<vtkColorTransferFunction> color;
  const std::string space = preset.value("ColorSpace", "RGB");
  if (space == "HSV") color->SetColorSpaceToHSV();
  if (space == "Lab") color->SetColorSpaceToLab();
  if (space == "Diverging") color->SetColorSpaceToDiverging();
  if (space == "Step") color->SetColorSpaceToStep();
  const auto rgb = preset.at("RGBPoints").get<std::vector<double>>();
  for (size_t i = 0; i + 3 < rgb.size(); i += 4) {
    color->AddRGBPoint(rgb[i], rgb[i + 1], rgb[i + 2], rgb[i + 3]);
  }
  vtkNew<vtkPiecewiseFunction> opacity;
  const auto points = preset.at("Points").get<std::vector<double>>();
  for (size_t i = 0; i + 3 < points.size(); i += 4) {
    opacity->AddPoint(points[i], points[i + 1], points[i + 2], points[i + 3]);
  }

  property->SetColor(color);
  property->SetScalarOpacity(opacity);
  property->SetScalarOpacityUnitDistance(settings.unit_distance);
  property->SetInterpolationTypeToLinear();
  property->SetShade(settings.shade);
  property->SetAmbient(settings.ambient);
  property->SetDiffuse(settings.diffuse);
  property->SetSpecular(settings.specular);
  property->SetSpecularPower(settings.specular_power);
}

void apply_camera(const std::string& path, vtkCamera* camera) {
  const Json file = read_json(path);
  const auto vector = [&](const char* name) { return file.at(name).get<std::array<double, 3>>(); };
  camera->SetPosition(vector("position").data());
  camera->SetFocalPoint(vector("focal_point").data());
  camera->SetViewUp(vector("view_up").data());
  camera->SetParallelProjection(file.value("parallel_projection", false));
  camera->SetParallelScale(file.value("parallel_scale", 1.0));
  camera->SetViewAngle(file.value("view_angle", 30.0));
}

// Mappers are kept from trading quality for time on their own.
vtkSmartPointer<vtkVolumeMapper> make_image_mapper(const Settings& settings, vtkImageData* image) {
  if (settings.mapper == "fixed") {
    auto mapper = vtkSmartPointer<vtkFixedPointVolumeRayCastMapper>::New();
    mapper->SetInputData(image);
    mapper->SetNumberOfThreads(settings.threads);
    mapper->AutoAdjustSampleDistancesOff();
    mapper->LockSampleDistanceToInputSpacingOff();
    mapper->SetImageSampleDistance(1);
    mapper->SetSampleDistance(static_cast<float>(settings.sampling_distance));
    mapper->SetInteractiveSampleDistance(static_cast<float>(settings.sampling_distance));
    return mapper;
  }
  auto mapper = vtkSmartPointer<vtkOpenGLGPUVolumeRayCastMapper>::New();
  mapper->SetInputData(image);
  mapper->AutoAdjustSampleDistancesOff();
  mapper->LockSampleDistanceToInputSpacingOff();
  mapper->UseJitteringOff();
  mapper->SetImageSampleDistance(1);
  mapper->SetSampleDistance(static_cast<float>(settings.sampling_distance));
  return mapper;
}

vtkSmartPointer<vtkImageData> read_image(const Settings& settings) {
  vtkNew<vtkXMLImageDataReader> reader;
  reader->SetFileName(settings.volume.c_str());
  reader->Update();
  if (reader->GetOutput()->GetNumberOfPoints() == 0)
    throw std::runtime_error(settings.volume + ": no volume");
  return reader->GetOutput();
}

// A grid of cubes over the particles, and each filter's own way to fill it. Where one asks for a
// radius it gets two cubes' worth.
vtkSmartPointer<vtkImageData> grid_particles(const Settings& settings) {
  vtkNew<vtkPLYReader> reader;
  reader->SetFileName(settings.volume.c_str());
  reader->Update();
  std::array<double, 6> bounds{};
  reader->GetOutput()->GetBounds(bounds.data());
  vtkNew<vtkElevationFilter> height;
  height->SetInputConnection(reader->GetOutputPort());
  height->SetLowPoint(0, bounds[2], 0);
  height->SetHighPoint(0, bounds[3], 0);
  if (settings.grid == "splat") {
    vtkNew<vtkGaussianSplatter> splatter;
    splatter->SetInputConnection(height->GetOutputPort());
    splatter->SetSampleDimensions(settings.grid_size, settings.grid_size, settings.grid_size);
    splatter->SetRadius(2.0 / settings.grid_size);
    splatter->NormalWarpingOff();
    splatter->CappingOff();
    splatter->SetAccumulationModeToSum();
    splatter->Update();
    return splatter->GetOutput();
  }
  const double longest =
      std::max({bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4]});
  const double spacing = longest / (settings.grid_size - 1);
  vtkNew<vtkImageData> grid;
  grid->SetDimensions(settings.grid_size, settings.grid_size, settings.grid_size);
  grid->SetSpacing(spacing, spacing, spacing);
  grid->SetOrigin((bounds[0] + bounds[1] - longest) / 2, (bounds[2] + bounds[3] - longest) / 2,
                  (bounds[4] + bounds[5] - longest) / 2);
  vtkSmartPointer<vtkDataSetAlgorithm> filter;
  if (settings.grid == "sph") {
    vtkNew<vtkSPHCubicKernel> kernel;
    kernel->SetSpatialStep(spacing);
    const auto interpolator = vtkSmartPointer<vtkSPHInterpolator>::New();
    interpolator->SetKernel(kernel);
    interpolator->SetSourceConnection(height->GetOutputPort());
    filter = interpolator;
  } else {
    vtkNew<vtkGaussianKernel> kernel;
    kernel->SetKernelFootprintToNClosest();
    kernel->SetNumberOfPoints(32);
    const auto interpolator = vtkSmartPointer<vtkPointInterpolator>::New();
    interpolator->SetKernel(kernel);
    interpolator->SetSourceConnection(height->GetOutputPort());
    filter = interpolator;
  }
  filter->SetInputData(grid);
  filter->Update();
  vtkSmartPointer<vtkImageData> filled = filter->GetImageDataOutput();
  filled->GetPointData()->SetActiveScalars("Elevation");
  return filled;
}

vtkSmartPointer<vtkUnstructuredGrid> read_mesh(const Settings& settings) {
  vtkNew<vtkXMLUnstructuredGridReader> reader;
  reader->SetFileName(settings.volume.c_str());
  vtkNew<vtkDataSetTriangleFilter> tetrahedra;
  tetrahedra->SetInputConnection(reader->GetOutputPort());
  tetrahedra->TetrahedraOnlyOn();
  tetrahedra->Update();
  vtkUnstructuredGrid* mesh = tetrahedra->GetOutput();
  if (mesh->GetNumberOfCells() == 0) throw std::runtime_error(settings.volume + ": no tetrahedra");
  if (mesh->GetPointData()->SetActiveScalars(settings.array.c_str()) < 0)
    throw std::runtime_error(settings.volume + ": no point array '" + settings.array + "'");
  return mesh;
}

// VTK's mesh mappers draw the same with and without shading: they do not shade.
vtkSmartPointer<vtkUnstructuredGridVolumeMapper> make_mesh_mapper(const Settings& settings,
                                                                  vtkUnstructuredGrid* mesh) {
  vtkSmartPointer<vtkUnstructuredGridVolumeMapper> mapper;
  if (settings.mapper == "raycast") {
    auto caster = vtkSmartPointer<vtkUnstructuredGridVolumeRayCastMapper>::New();
    caster->SetNumberOfThreads(settings.threads);
    caster->AutoAdjustSampleDistancesOff();
    caster->SetImageSampleDistance(1);
    mapper = caster;
  } else if (settings.mapper == "zsweep") {
    auto sweeper = vtkSmartPointer<vtkUnstructuredGridVolumeZSweepMapper>::New();
    sweeper->AutoAdjustSampleDistancesOff();
    sweeper->SetImageSampleDistance(1);
    mapper = sweeper;
  } else {
    mapper = vtkSmartPointer<vtkProjectedTetrahedraMapper>::New();
  }
  mapper->SetInputData(mesh);
  return mapper;
}

bool takes_meshes(const std::string& mapper) { return mapper != "fixed" && mapper != "gpu"; }

vtkSmartPointer<vtkAbstractVolumeMapper> make_mapper(const Settings& settings) {
  if (takes_meshes(settings.mapper)) return make_mesh_mapper(settings, read_mesh(settings));
  return make_image_mapper(settings,
                           settings.grid.empty() ? read_image(settings) : grid_particles(settings));
}

std::array<double, 2> value_range(vtkAbstractVolumeMapper* mapper) {
  vtkDataSet* data = mapper->GetDataSetInput();
  std::array<double, 2> range{};
  data->GetScalarRange(range.data());
  return range;
}

void write_picture(vtkRenderWindow* window, const std::string& path) {
  vtkNew<vtkWindowToImageFilter> grab;
  grab->SetInput(window);
  grab->SetInputBufferTypeToRGB();
  grab->ReadFrontBufferOff();
  grab->ShouldRerenderOff();
  vtkNew<vtkPNMWriter> writer;
  writer->SetInputConnection(grab->GetOutputPort());
  writer->SetFileName(path.c_str());
  writer->Write();
}

Json summary(std::vector<double> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  const size_t half = values.size() / 2;
  const double median =
      values.size() % 2 != 0 ? values[half] : (values[half - 1] + values[half]) / 2;
  return {{"median", median}, {"min", values.front()}, {"max", values.back()}};
}

Json measure(const Settings& settings) {
  const auto begin = std::chrono::steady_clock::now();
  const auto mapper = make_mapper(settings);
  const std::chrono::duration<double, std::milli> prepared =
      std::chrono::steady_clock::now() - begin;
  vtkNew<vtkVolume> volume;
  volume->SetMapper(mapper);
  apply_look(settings, value_range(mapper), volume->GetProperty());

  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(0, 0, 0);
  renderer->TwoSidedLightingOn();
  renderer->AddVolume(volume);
  vtkNew<vtkRenderWindow> window;
  window->SetMultiSamples(0);
  window->OffScreenRenderingOn();
  window->SetSize(settings.width, settings.height);
  window->AddRenderer(renderer);
  if (settings.camera.empty()) {
    renderer->ResetCamera();
  } else {
    apply_camera(settings.camera, renderer->GetActiveCamera());
  }

  std::vector<double> frames, casts;
  for (int i = 0; i <= settings.repeat; ++i) {
    if (i > 0) renderer->GetActiveCamera()->Azimuth(0.01);
    renderer->ResetCameraClippingRange();
    const auto start = std::chrono::steady_clock::now();
    window->Render();
    window->WaitForCompletion();
    const std::chrono::duration<double, std::milli> elapsed =
        std::chrono::steady_clock::now() - start;
    if (i == 0) {
      if (!settings.picture.empty()) write_picture(window, settings.picture);
      continue;
    }
    frames.push_back(elapsed.count());
    if (auto* fixed = vtkFixedPointVolumeRayCastMapper::SafeDownCast(mapper))
      casts.push_back(fixed->GetTimeToDraw() * 1e3);
  }
  return {{"mapper", settings.mapper},          {"threads", settings.threads},
          {"vtk", vtkVersion::GetVTKVersion()}, {"prepare_ms", prepared.count()},
          {"frame_ms", summary(frames)},        {"cast_ms", summary(casts)}};
}

}  // namespace

int main(int argc, char** argv) try {
  Settings settings;
  CLI::App app("VTK's volume mappers, timed");
  app.add_option("--volume", settings.volume, "VTI, VTU or PLY file")->required();
  app.add_option("--look", settings.look, "ParaView JSON preset; default: a ramp");
  app.add_option("--camera", settings.camera, "camera JSON; default: VTK's own");
  app.add_option("--grid", settings.grid, "how particles are put on a grid")
      ->check(CLI::IsMember({"sph", "nearest", "splat"}));
  app.add_option("--grid-size", settings.grid_size, "its samples along each side")
      ->check(CLI::Range(2, 2048));
  app.add_option("-o", settings.picture, "picture of the first frame (PPM)");
  app.add_option("--mapper", settings.mapper)
      ->check(CLI::IsMember({"fixed", "gpu", "raycast", "zsweep", "projected"}));
  app.add_option("--array", settings.array, "of a mesh's nodes");
  app.add_option("--width", settings.width)->check(CLI::PositiveNumber);
  app.add_option("--height", settings.height)->check(CLI::PositiveNumber);
  app.add_option("--threads", settings.threads, "of the fixed mapper")->check(CLI::PositiveNumber);
  app.add_option("--repeat", settings.repeat)->check(CLI::PositiveNumber);
  app.add_option("--sampling-distance", settings.sampling_distance, "world units");
  app.add_option("--unit-distance", settings.unit_distance, "world units");
  app.add_flag("--shade,!--no-shade", settings.shade);
  app.add_option("--ambient", settings.ambient);
  app.add_option("--diffuse", settings.diffuse);
  app.add_option("--specular", settings.specular);
  app.add_option("--specular-power", settings.specular_power);
  CLI11_PARSE(app, argc, argv);
  std::cout << measure(settings).dump(1) << '\n';
} catch (const std::exception& error) {
  std::cerr << "vtk_peer: " << error.what() << '\n';
  return 1;
}
