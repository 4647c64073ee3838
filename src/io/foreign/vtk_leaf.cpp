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

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "data/names_text.h"
#include "io/foreign/vtk_xml_base64.h"
#include "io/meshes/mesh_parts.h"
#include "ovoid/error.h"

namespace ovoid::io {
namespace {

// What VTK is to read: of the file itself, or of a copy of its text.
struct XmlToRead {
  VtkOutline outline;
  std::optional<std::string> text;  // none: the file's own
};

// Base64 that VTK cannot go through is put right in a copy, which is then checked as the file was.
XmlToRead xml_to_read(const ByteSource& source) {
  try {
    return {check_vtk_xml(source), {}};
  } catch (const Error&) {
    auto plain = with_plain_base64(source);
    if (!plain) throw;
    VtkOutline outline =
        check_vtk_xml(*open_memory(source.name(), std::as_bytes(std::span(*plain))));
    return {std::move(outline), std::move(plain)};
  }
}

bool is_text(const VtkOutline& outline, const std::string& name, bool is_cell_data) {
  return std::any_of(outline.texts.begin(), outline.texts.end(), [&](const VtkTextArray& t) {
    return t.name == name && t.is_cell_data == is_cell_data;
  });
}

// Switches text off, and if an array is wanted all other numbers.
void select_arrays(const ByteSource& source, vtkXMLReader* reader, const VtkOutline& outline,
                   const std::string& wanted, VtkRun& run) {
  std::vector<std::string> names;
  bool is_found = wanted.empty();
  for (const bool are_cells : {false, true}) {
    vtkDataArraySelection* const selection =
        are_cells ? reader->GetCellDataArraySelection() : reader->GetPointDataArraySelection();
    for (int i = 0; i < selection->GetNumberOfArrays(); ++i) {
      const std::string name = selection->GetArrayName(i);
      if (!is_text(outline, name, are_cells)) {
        names.push_back(name);
        is_found = is_found || name == wanted;
        continue;
      }
      selection->DisableArray(name.c_str());
      if (wanted.empty() || name == wanted)
        run.notes.push_back(
            fmt::format("{}: array '{}' is left out: it holds text", source.name(), name));
    }
    if (wanted.empty()) continue;
    const bool is_here = selection->ArrayExists(wanted.c_str()) != 0;
    selection->DisableAllArrays();
    for (const char* const ghosts : {kGhostArray, kOldGhostArray}) selection->EnableArray(ghosts);
    if (is_here && !is_text(outline, wanted, are_cells)) selection->EnableArray(wanted.c_str());
  }
  if (is_found) return;
  if (is_text(outline, wanted, false) || is_text(outline, wanted, true)) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("{}: array '{}': holds text: expected one of {}", source.name(), wanted,
                            data::names_text(names)));
  }
  throw_no_array(source, wanted, names);
}

template <typename Reader>
vtkSmartPointer<vtkDataSet> run_xml_reader(const ByteSource& source, const XmlToRead& xml,
                                           const std::string& array, VtkRun& run) {
  vtkNew<Reader> reader;
  if (xml.text) {
    reader->ReadFromInputStringOn();
    reader->SetInputString(*xml.text);
  } else {
    reader->SetFileName(path_for_vtk(source).c_str());
  }
  if (!array.empty() || !xml.outline.texts.empty()) {
    run(reader, [&] { reader->UpdateInformation(); });
    select_arrays(source, reader, xml.outline, array, run);
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

vtkSmartPointer<vtkDataSet> run_xml(const ByteSource& source, const XmlToRead& xml,
                                    const std::string& array, VtkRun& run) {
  switch (xml.outline.grid) {
    case VtkGrid::kImage:
      return run_xml_reader<vtkXMLImageDataReader>(source, xml, array, run);
    case VtkGrid::kRectilinear:
      return run_xml_reader<vtkXMLRectilinearGridReader>(source, xml, array, run);
    case VtkGrid::kStructured:
      return run_xml_reader<vtkXMLStructuredGridReader>(source, xml, array, run);
    case VtkGrid::kUnstructured:
      return run_xml_reader<vtkXMLUnstructuredGridReader>(source, xml, array, run);
    case VtkGrid::kPolyData:
      return run_xml_reader<vtkXMLPolyDataReader>(source, xml, array, run);
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

VtkOutline outline_of_vtk_xml_leaf(const ByteSource& source) { return xml_to_read(source).outline; }

VtkLeaf read_vtk_leaf(const ByteSource& source, bool is_xml, const ReadOptions& options,
                      VtkRun& run) {
  VtkLeaf leaf;
  XmlToRead xml;
  if (is_xml) xml = xml_to_read(source);
  leaf.grid = is_xml ? xml.outline.grid : check_legacy_vtk(source);
  // Of polygons without their faces the points are read, as particles.
  const bool are_particles = leaf.grid == VtkGrid::kPolyData && !options.faces;
  leaf.has_one_array = is_xml && !are_particles && !options.array.empty();
  leaf.data = is_xml ? run_xml(source, xml, leaf.has_one_array ? options.array : "", run)
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
