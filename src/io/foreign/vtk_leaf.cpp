// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include "io/foreign/vtk_leaf.h"

#include <fmt/format.h>
#include <vtkDataArraySelection.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkPolyDataReader.h>
#include <vtkRectilinearGrid.h>
#include <vtkRectilinearGridReader.h>
#include <vtkStructuredGrid.h>
#include <vtkStructuredGridReader.h>
#include <vtkStructuredPoints.h>
#include <vtkStructuredPointsReader.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridReader.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLPolyDataReader.h>
#include <vtkXMLRectilinearGridReader.h>
#include <vtkXMLStructuredGridReader.h>
#include <vtkXMLUnstructuredGridReader.h>

#include "data/names_text.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// Leaves only the wanted array switched on.
void select_array(const ByteSource& source, vtkXMLReader* reader, const std::string& wanted) {
  std::vector<std::string> names;
  bool is_found = false;
  for (vtkDataArraySelection* selection :
       {reader->GetPointDataArraySelection(), reader->GetCellDataArraySelection()}) {
    for (int i = 0; i < selection->GetNumberOfArrays(); ++i)
      names.emplace_back(selection->GetArrayName(i));
    selection->DisableAllArrays();
    selection->EnableArray("vtkGhostType");
    if (selection->ArrayExists(wanted.c_str()) == 0) continue;
    selection->EnableArray(wanted.c_str());
    is_found = true;
  }
  if (!is_found) throw_no_array(source, wanted, names);
}

template <typename Reader>
vtkSmartPointer<vtkDataSet> run_xml_reader(const ByteSource& source, const std::string& array,
                                           VtkRun& run) {
  vtkNew<Reader> reader;
  reader->SetFileName(path_for_vtk(source).c_str());
  if (!array.empty()) {
    run(reader, [&] { reader->UpdateInformation(); });
    select_array(source, reader, array);
  }
  run(reader, [&] { reader->Update(); });
  return reader->GetOutput();
}

template <typename Reader>
vtkSmartPointer<vtkDataSet> run_legacy_reader(const ByteSource& source, VtkRun& run) {
  vtkNew<Reader> reader;
  reader->SetFileName(path_for_vtk(source).c_str());
  reader->ReadAllScalarsOn();
  reader->ReadAllVectorsOn();
  reader->ReadAllNormalsOn();
  reader->ReadAllTensorsOn();
  reader->ReadAllColorScalarsOn();
  reader->ReadAllTCoordsOn();
  reader->ReadAllFieldsOn();
  run(reader, [&] { reader->Update(); });
  return reader->GetOutput();
}

vtkSmartPointer<vtkDataSet> run_xml(const ByteSource& source, VtkGrid grid,
                                    const std::string& array, VtkRun& run) {
  switch (grid) {
    case VtkGrid::kImage:
      return run_xml_reader<vtkXMLImageDataReader>(source, array, run);
    case VtkGrid::kRectilinear:
      return run_xml_reader<vtkXMLRectilinearGridReader>(source, array, run);
    case VtkGrid::kStructured:
      return run_xml_reader<vtkXMLStructuredGridReader>(source, array, run);
    case VtkGrid::kUnstructured:
      return run_xml_reader<vtkXMLUnstructuredGridReader>(source, array, run);
    case VtkGrid::kPolyData:
      return run_xml_reader<vtkXMLPolyDataReader>(source, array, run);
  }
  return nullptr;
}

vtkSmartPointer<vtkDataSet> run_legacy(const ByteSource& source, VtkGrid grid, VtkRun& run) {
  switch (grid) {
    case VtkGrid::kImage:
      return run_legacy_reader<vtkStructuredPointsReader>(source, run);
    case VtkGrid::kRectilinear:
      return run_legacy_reader<vtkRectilinearGridReader>(source, run);
    case VtkGrid::kStructured:
      return run_legacy_reader<vtkStructuredGridReader>(source, run);
    case VtkGrid::kUnstructured:
      return run_legacy_reader<vtkUnstructuredGridReader>(source, run);
    case VtkGrid::kPolyData:
      return run_legacy_reader<vtkPolyDataReader>(source, run);
  }
  return nullptr;
}

}  // namespace

VtkLeaf read_vtk_leaf(const ByteSource& source, bool is_xml, const ReadOptions& options,
                      VtkRun& run) {
  VtkLeaf leaf;
  leaf.grid = is_xml ? check_vtk_xml(source) : check_legacy_vtk(source);
  // Of polygons without their faces the points are read, as particles.
  const bool are_particles = leaf.grid == VtkGrid::kPolyData && !options.faces;
  leaf.has_one_array = is_xml && !are_particles && !options.array.empty();
  leaf.data = is_xml ? run_xml(source, leaf.grid, leaf.has_one_array ? options.array : "", run)
                     : run_legacy(source, leaf.grid, run);
  if (leaf.data == nullptr)
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: VTK finds no data in it", source.name()));
  return leaf;
}

const char* format_of_leaf(VtkGrid grid, bool is_xml) noexcept {
  if (!is_xml) return "legacy VTK";
  switch (grid) {
    case VtkGrid::kImage:
      return "VTI";
    case VtkGrid::kRectilinear:
      return "VTR";
    case VtkGrid::kStructured:
      return "VTS";
    case VtkGrid::kUnstructured:
      return "VTU";
    case VtkGrid::kPolyData:
      return "VTP";
  }
  return "VTK";
}

void throw_no_array(const ByteSource& source, const std::string& wanted,
                    const std::vector<std::string>& names) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: array '{}': not there: expected one of {}", source.name(), wanted,
                          data::names_text(names)));
}

}  // namespace ovoid::io

#endif
