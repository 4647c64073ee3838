// SPDX-License-Identifier: Apache-2.0
#include "io/vtk_image.h"

#include <fmt/format.h>

#include "ovoid/error.h"

#ifndef OVOID_IO_VTK

namespace ovoid::io {

Dataset read_vtk_image(const ByteSource& source, FileKind, const ReadOptions&) {
  throw Error(ErrorCode::kUnsupported,
              fmt::format("{}: this build has no VTK and cannot read VTI, VTR and legacy VTK files",
                          source.name()));
}

void write_vtk_image(const Dataset&, const std::string& path) {
  throw Error(
      ErrorCode::kUnsupported,
      fmt::format("{}: this build has no VTK and cannot write VTI and legacy VTK files", path));
}

}  // namespace ovoid::io

#else

#include <vtkAOSDataArrayTemplate.h>
#include <vtkAlgorithm.h>
#include <vtkCallbackCommand.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataArraySelection.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPointData.h>
#include <vtkRectilinearGrid.h>
#include <vtkRectilinearGridReader.h>
#include <vtkSmartPointer.h>
#include <vtkStructuredPoints.h>
#include <vtkStructuredPointsReader.h>
#include <vtkStructuredPointsWriter.h>
#include <vtkXMLImageDataReader.h>
#include <vtkXMLImageDataWriter.h>
#include <vtkXMLRectilinearGridReader.h>

#include <algorithm>
#include <limits>
#include <new>
#include <vector>

#include "io/atomic_file.h"
#include "io/rectilinear.h"
#include "io/samples.h"
#include "io/vtk_header.h"
#include "io/vtk_messages.h"

namespace ovoid::io {
namespace {

std::optional<ScalarType> scalar_type_of(int vtk_type) {
  switch (vtk_type) {
    case VTK_CHAR:
      return std::is_signed_v<char> ? ScalarType::kInt8 : ScalarType::kUInt8;
    case VTK_SIGNED_CHAR:
      return ScalarType::kInt8;
    case VTK_UNSIGNED_CHAR:
      return ScalarType::kUInt8;
    case VTK_SHORT:
      return ScalarType::kInt16;
    case VTK_UNSIGNED_SHORT:
      return ScalarType::kUInt16;
    case VTK_INT:
      return ScalarType::kInt32;
    case VTK_UNSIGNED_INT:
      return ScalarType::kUInt32;
    case VTK_LONG:
      return sizeof(long) == 8 ? ScalarType::kInt64 : ScalarType::kInt32;
    case VTK_UNSIGNED_LONG:
      return sizeof(long) == 8 ? ScalarType::kUInt64 : ScalarType::kUInt32;
    case VTK_LONG_LONG:
      return ScalarType::kInt64;
    case VTK_UNSIGNED_LONG_LONG:
      return ScalarType::kUInt64;
    case VTK_ID_TYPE:
      return sizeof(vtkIdType) == 8 ? ScalarType::kInt64 : ScalarType::kInt32;
    case VTK_FLOAT:
      return ScalarType::kFloat32;
    case VTK_DOUBLE:
      return ScalarType::kFloat64;
    default:
      return std::nullopt;
  }
}

// In the order of ScalarType.
constexpr int kVtkTypes[] = {VTK_UNSIGNED_CHAR, VTK_SIGNED_CHAR, VTK_UNSIGNED_SHORT, VTK_SHORT,
                             VTK_UNSIGNED_INT,  VTK_INT,         VTK_TYPE_UINT64,    VTK_TYPE_INT64,
                             VTK_FLOAT,         VTK_DOUBLE};

// Runs a reader: its messages are collected, its progress is passed on, and the caller may stop it.
class ReaderRun {
 public:
  ReaderRun(const ByteSource& source, const ReadOptions& options)
      : source_(source), options_(options) {}

  template <typename Action>
  void operator()(vtkAlgorithm* reader, const Action& action) {
    vtkNew<vtkCallbackCommand> command;
    command->SetClientData(this);
    command->SetCallback([](vtkObject* object, unsigned long, void* self, void*) {
      static_cast<ReaderRun*>(self)->on_progress(vtkAlgorithm::SafeDownCast(object));
    });
    const unsigned long tag = reader->AddObserver(vtkCommand::ProgressEvent, command);
    try {
      const VtkMessages messages;
      action();
      reader->RemoveObserver(tag);
      was_stopped_ = was_stopped_ || options_.stop.stop_requested();
      if (was_stopped_) throw Error(ErrorCode::kCancelled, "reading: stopped by the caller");
      if (!messages.errors().empty()) {
        throw Error(ErrorCode::kFileFormat,
                    fmt::format("{}: {}", source_.name(), messages.errors().front()));
      }
      if (reader->GetErrorCode() != 0)
        throw Error(ErrorCode::kFileFormat, fmt::format("{}: VTK cannot read it", source_.name()));
      for (const std::string& warning : messages.warnings())
        notes.push_back(fmt::format("{}: {}", source_.name(), warning));
    } catch (const std::bad_alloc&) {
      throw Error(
          ErrorCode::kOutOfMemory,
          fmt::format("{}: memory for its arrays: the system has none left", source_.name()));
    }
  }

  std::vector<std::string> notes;

 private:
  void on_progress(vtkAlgorithm* reader) {
    if (options_.stop.stop_requested()) {
      was_stopped_ = true;
      reader->SetAbortExecute(1);
    } else if (options_.progress) {
      options_.progress(std::clamp(reader->GetProgress(), 0.0, 1.0));
    }
  }

  const ByteSource& source_;
  const ReadOptions& options_;
  bool was_stopped_ = false;
};

[[noreturn]] void throw_no_array(const ByteSource& source, const std::string& wanted,
                                 const std::vector<std::string>& names) {
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: array '{}': not there: expected one of '{}'", source.name(), wanted,
                          fmt::join(names, "', '")));
}

// Leaves only the wanted array switched on.
void select_array(const ByteSource& source, vtkXMLReader* reader, const std::string& wanted) {
  std::vector<std::string> names;
  bool is_found = false;
  for (vtkDataArraySelection* selection :
       {reader->GetPointDataArraySelection(), reader->GetCellDataArraySelection()}) {
    for (int i = 0; i < selection->GetNumberOfArrays(); ++i)
      names.emplace_back(selection->GetArrayName(i));
    selection->DisableAllArrays();
    if (selection->ArrayExists(wanted.c_str()) == 0) continue;
    selection->EnableArray(wanted.c_str());
    is_found = true;
  }
  if (!is_found) throw_no_array(source, wanted, names);
}

template <typename Reader>
vtkSmartPointer<vtkDataSet> run_xml_reader(const ByteSource& source, const ReadOptions& options,
                                           ReaderRun& run) {
  vtkNew<Reader> reader;
  reader->SetFileName(source.name().c_str());
  if (!options.array.empty()) {
    run(reader, [&] { reader->UpdateInformation(); });
    select_array(source, reader, options.array);
  }
  run(reader, [&] { reader->Update(); });
  return reader->GetOutput();
}

template <typename Reader>
vtkSmartPointer<vtkDataSet> run_legacy_reader(const ByteSource& source, ReaderRun& run) {
  vtkNew<Reader> reader;
  reader->SetFileName(source.name().c_str());
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

vtkSmartPointer<vtkDataSet> run_reader(const ByteSource& source, bool is_xml, VtkGrid grid,
                                       const ReadOptions& options, ReaderRun& run) {
  const bool is_image = grid == VtkGrid::kImage;
  if (is_xml && is_image) return run_xml_reader<vtkXMLImageDataReader>(source, options, run);
  if (is_xml) return run_xml_reader<vtkXMLRectilinearGridReader>(source, options, run);
  if (is_image) return run_legacy_reader<vtkStructuredPointsReader>(source, run);
  return run_legacy_reader<vtkRectilinearGridReader>(source, run);
}

// The image's lattice, with index 0 at its first sample whatever its extent.
LatticeGeometry lattice_of(const ByteSource& source, vtkImageData* image) {
  LatticeGeometry lattice;
  Mat3 linear;
  Vec3 first;
  for (int axis = 0; axis < 3; ++axis) {
    lattice.dims[static_cast<std::size_t>(axis)] = image->GetDimensions()[axis];
    first[axis] = image->GetExtent()[2 * axis];
    for (int row = 0; row < 3; ++row) {
      linear(row, axis) =
          image->GetDirectionMatrix()->GetElement(row, axis) * image->GetSpacing()[axis];
    }
  }
  lattice.world_from_index.linear() = linear;
  lattice.world_from_index.translation() = Vec3(image->GetOrigin()) + linear * first;
  check_geometry(source.name() + ": Spacing, Direction or Origin", lattice.world_from_index);
  return lattice;
}

LatticeGeometry lattice_of(const ByteSource& source, vtkRectilinearGrid* grid) {
  std::array<AxisCoordinates, 3> axes;
  vtkDataArray* const arrays[] = {grid->GetXCoordinates(), grid->GetYCoordinates(),
                                  grid->GetZCoordinates()};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const vtkIdType count = grid->GetDimensions()[axis];
    if (arrays[axis] == nullptr || arrays[axis]->GetNumberOfTuples() != count ||
        arrays[axis]->GetNumberOfComponents() != 1) {
      throw Error(ErrorCode::kFileFormat,
                  fmt::format("{}: VTK finds no {} coordinates for {} samples", source.name(),
                              "xyz"[axis], count));
    }
    axes[axis].is_float32 = arrays[axis]->GetDataType() == VTK_FLOAT;
    for (vtkIdType i = 0; i < count; ++i)
      axes[axis].values.push_back(arrays[axis]->GetComponent(i, 0));
  }
  return lattice_of_coordinates(source.name(), axes);
}

LatticeGeometry lattice_of(const ByteSource& source, vtkDataSet* data) {
  if (auto* const grid = vtkRectilinearGrid::SafeDownCast(data)) return lattice_of(source, grid);
  return lattice_of(source, vtkImageData::SafeDownCast(data));
}

Bytes share(vtkDataArray* array, std::int64_t num_bytes) {
  vtkSmartPointer<vtkDataArray> plain = array;
  if (!array->HasStandardMemoryLayout()) {
    plain =
        vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(array->GetDataType()));
    plain->DeepCopy(array);
  }
  const auto* data = static_cast<const std::byte*>(plain->GetVoidPointer(0));
  return {std::make_shared<vtkSmartPointer<vtkDataArray>>(plain),
          {data, static_cast<std::size_t>(num_bytes)}};
}

// Takes over the arrays of points or cells that hold numbers, one tuple for each sample; adds the
// names of those that it could take to `names`.
void add_arrays(Dataset& dataset, vtkFieldData* fields, std::int64_t num_expected,
                bool is_cell_data, const std::string& wanted, std::vector<std::string>& names) {
  for (int i = 0; i < fields->GetNumberOfArrays(); ++i) {
    vtkAbstractArray* const abstract = fields->GetAbstractArray(i);
    if (abstract == nullptr) continue;
    std::string name = abstract->GetName() != nullptr ? abstract->GetName() : "";
    if (name.empty()) name = fmt::format("{}{}", is_cell_data ? "cells" : "points", i);
    const bool is_wanted = wanted.empty() || name == wanted;
    vtkDataArray* const array = vtkDataArray::SafeDownCast(abstract);
    const auto type = scalar_type_of(abstract->GetDataType());
    if (array == nullptr || !type || array->GetNumberOfTuples() != num_expected ||
        array->GetNumberOfComponents() < 1) {
      if (!is_wanted) continue;
      dataset.notes.push_back(fmt::format(
          "{}: array '{}' ({} tuples of {} {}) is left out: expected {} tuples of numbers",
          dataset.source, name, abstract->GetNumberOfTuples(), abstract->GetNumberOfComponents(),
          abstract->GetDataTypeAsString(), num_expected));
      continue;
    }
    names.push_back(name);
    if (!is_wanted) continue;
    DataArray result{name,         *type, array->GetNumberOfComponents(), num_expected, "",
                     is_cell_data, {}};
    vtkInformation* const information = array->HasInformation() ? array->GetInformation() : nullptr;
    if (information != nullptr && information->Has(vtkDataArray::UNITS_LABEL()) != 0) {
      result.unit = information->Get(vtkDataArray::UNITS_LABEL());
    }
    result.bytes = share(array, checked_num_bytes(dataset.source, std::array{num_expected}, *type,
                                                  result.num_components));
    dataset.arrays.push_back(std::move(result));
  }
}

}  // namespace

Dataset read_vtk_image(const ByteSource& source, FileKind kind, const ReadOptions& options) {
  const bool is_xml = kind == FileKind::kVtkXml;
  const VtkGrid grid = is_xml ? check_vti(source) : check_legacy_vtk(source);
  ReaderRun run(source, options);
  const vtkSmartPointer<vtkDataSet> image = run_reader(source, is_xml, grid, options, run);
  if (image == nullptr || image->GetNumberOfPoints() < 1) {
    throw Error(ErrorCode::kFileFormat, fmt::format("{}: VTK finds no image in it", source.name()));
  }
  Dataset dataset;
  dataset.source = source.name();
  dataset.format = !is_xml ? "legacy VTK" : grid == VtkGrid::kImage ? "VTI" : "VTR";
  dataset.notes = std::move(run.notes);
  dataset.lattice = lattice_of(source, image);
  std::vector<std::string> names;
  add_arrays(dataset, image->GetPointData(), image->GetNumberOfPoints(), false, options.array,
             names);
  add_arrays(dataset, image->GetCellData(), image->GetNumberOfCells(), true, options.array, names);
  if (dataset.arrays.empty() && !names.empty()) throw_no_array(source, options.array, names);
  if (dataset.arrays.empty()) {
    throw Error(
        options.array.empty() ? ErrorCode::kFileFormat : ErrorCode::kInvalidArgument,
        fmt::format("{}: {}", source.name(),
                    options.array.empty() ? "has no array of numbers"
                                          : "has no array '" + options.array + "' of numbers"));
  }
  if (vtkDataArray* const time = image->GetFieldData()->GetArray("TimeValue");
      time != nullptr && time->GetNumberOfTuples() == 1) {
    dataset.times.push_back(time->GetTuple1(0));
  }
  shorten_notes(dataset.notes);
  return dataset;
}

namespace {

vtkSmartPointer<vtkImageData> image_of(const Dataset& dataset) {
  auto image = vtkSmartPointer<vtkImageData>::New();
  const Index3& dims = dataset.lattice.dims;
  if (*std::max_element(dims.begin(), dims.end()) > kMaxAxisSize) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("dims {}: VTK images have at most {} samples along an axis",
                            dims_text(dims), kMaxAxisSize));
  }
  image->SetDimensions(static_cast<int>(dims[0]), static_cast<int>(dims[1]),
                       static_cast<int>(dims[2]));
  const Vec3 spacing = dataset.lattice.spacing();
  // Divided, since a product with the inverse is not 1 where the axes are the world's.
  const Mat3 direction =
      dataset.lattice.world_from_index.linear().array().rowwise() / spacing.transpose().array();
  image->SetSpacing(spacing.data());
  image->SetOrigin(Vec3(dataset.lattice.world_from_index.translation()).data());
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      image->GetDirectionMatrix()->SetElement(row, column, direction(row, column));
  }
  for (const DataArray& array : dataset.arrays) {
    const auto values = vtkSmartPointer<vtkDataArray>::Take(
        vtkDataArray::CreateDataArray(kVtkTypes[static_cast<std::size_t>(array.type)]));
    values->SetName(array.name.c_str());
    values->SetNumberOfComponents(array.num_components);
    if (!array.unit.empty())
      values->GetInformation()->Set(vtkDataArray::UNITS_LABEL(), array.unit.c_str());
    // Lent, not copied; writers only read.
    constexpr int kKeepForCaller = 1;
    values->SetVoidArray(const_cast<std::byte*>(array.bytes.view.data()),
                         array.num_tuples * array.num_components, kKeepForCaller);
    vtkDataSetAttributes* const attributes =
        array.is_cell_data ? static_cast<vtkDataSetAttributes*>(image->GetCellData())
                           : image->GetPointData();
    attributes->AddArray(values);
    // Programs without a choice show the active scalars, and legacy files name them most plainly.
    if (attributes->GetScalars() == nullptr && array.num_components == 1)
      attributes->SetActiveScalars(array.name.c_str());
  }
  return image;
}

// VTK writes the numbers of the header in 6 digits if it is not told otherwise.
class ExactPointsWriter final : public vtkStructuredPointsWriter {
 public:
  static ExactPointsWriter* New();

  ostream* OpenVTKFile() override {
    ostream* const stream = vtkStructuredPointsWriter::OpenVTKFile();
    if (stream != nullptr) stream->precision(std::numeric_limits<double>::max_digits10);
    return stream;
  }
};

vtkStandardNewMacro(ExactPointsWriter);

template <typename Writer>
void run_writer(Writer* writer, const std::string& path) {
  AtomicFile file(path);
  writer->SetFileName(file.partial_path().c_str());
  const VtkMessages messages;
  if (writer->Write() == 0 || writer->GetErrorCode() != 0 || !messages.errors().empty()) {
    throw Error(
        ErrorCode::kFileWrite,
        fmt::format("{}: cannot be written: VTK: {}", path,
                    messages.errors().empty() ? "no reason given" : messages.errors().front()));
  }
  file.commit();
}

}  // namespace

void write_vtk_image(const Dataset& dataset, const std::string& path) {
  const auto image = image_of(dataset);
  if (ending_of(path) == ".vti") {
    vtkNew<vtkXMLImageDataWriter> writer;
    writer->SetInputData(image);
    writer->SetDataModeToAppended();
    writer->EncodeAppendedDataOff();
    writer->SetHeaderTypeToUInt64();
    writer->SetCompressorTypeToZLib();
    return run_writer(writer.Get(), path);
  }
  if (!image->GetDirectionMatrix()->IsIdentity()) {
    throw Error(ErrorCode::kUnsupported, fmt::format("{}: legacy VTK knows no axis directions, the "
                                                     "lattice is rotated or flipped: write .vti",
                                                     path));
  }
  vtkNew<ExactPointsWriter> writer;
  writer->SetInputData(image);
  writer->SetFileTypeToBinary();
  run_writer(writer.Get(), path);
}

}  // namespace ovoid::io

#endif
