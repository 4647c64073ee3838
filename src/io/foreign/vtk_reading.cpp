// SPDX-License-Identifier: Apache-2.0
#ifdef OVOID_IO_VTK

#include "io/foreign/vtk_reading.h"

#include <fmt/format.h>
#include <vtkAlgorithm.h>
#include <vtkCallbackCommand.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkInformation.h>
#include <vtkInformationStringKey.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <new>

#include "io/core/samples.h"
#include "io/foreign/vtk_messages.h"
#include "ovoid/error.h"

namespace ovoid::io {

void VtkRun::operator()(vtkAlgorithm* reader, const std::function<void()>& action) {
  vtkNew<vtkCallbackCommand> command;
  command->SetClientData(this);
  command->SetCallback([](vtkObject* object, unsigned long, void* self, void*) {
    static_cast<VtkRun*>(self)->on_progress(vtkAlgorithm::SafeDownCast(object));
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
    throw Error(ErrorCode::kOutOfMemory,
                fmt::format("{}: memory for its arrays: the system has none left", source_.name()));
  }
}

void VtkRun::on_progress(vtkAlgorithm* reader) {
  if (options_.stop.stop_requested()) {
    was_stopped_ = true;
    reader->SetAbortExecute(1);
  } else if (options_.progress) {
    options_.progress(std::clamp(reader->GetProgress(), 0.0, 1.0));
  }
}

std::string path_for_vtk(const ByteSource& source) {
  return std::filesystem::absolute(source.name()).string();
}

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

namespace {

// Bits take a byte each here.
vtkSmartPointer<vtkDataArray> without_bits(vtkDataArray* array) {
  if (array == nullptr || array->GetDataType() != VTK_BIT) return array;
  const auto bytes = vtkSmartPointer<vtkUnsignedCharArray>::New();
  bytes->DeepCopy(array);
  return bytes;
}

}  // namespace

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

std::vector<VtkArray> numbers_of(const std::string& source, vtkFieldData* fields,
                                 std::int64_t num_expected, bool is_cell_data) {
  std::vector<VtkArray> results;
  if (num_expected == 0) return results;
  for (int i = 0; i < fields->GetNumberOfArrays(); ++i) {
    vtkAbstractArray* const abstract = fields->GetAbstractArray(i);
    if (abstract == nullptr) continue;
    VtkArray& result = results.emplace_back();
    result.name = abstract->GetName() != nullptr ? abstract->GetName() : "";
    if (result.name.empty())
      result.name = fmt::format("{}{}", is_cell_data ? "cells" : "points", i);
    const vtkSmartPointer<vtkDataArray> array = without_bits(vtkDataArray::SafeDownCast(abstract));
    const auto type =
        scalar_type_of(array != nullptr ? array->GetDataType() : abstract->GetDataType());
    if (array == nullptr || !type || array->GetNumberOfTuples() != num_expected ||
        array->GetNumberOfComponents() < 1) {
      result.note = fmt::format(
          "{}: array '{}' ({} tuples of {} {}) is left out: expected {} tuples of numbers", source,
          result.name, abstract->GetNumberOfTuples(), abstract->GetNumberOfComponents(),
          abstract->GetDataTypeAsString(), num_expected);
      continue;
    }
    DataArray numbers{result.name,  *type, array->GetNumberOfComponents(), num_expected, "",
                      is_cell_data, {}};
    vtkInformation* const information = array->HasInformation() ? array->GetInformation() : nullptr;
    if (information != nullptr && information->Has(vtkDataArray::UNITS_LABEL()) != 0)
      numbers.unit = information->Get(vtkDataArray::UNITS_LABEL());
    numbers.bytes = share(
        array, checked_num_bytes(source, std::array{num_expected}, *type, numbers.num_components));
    result.numbers = std::move(numbers);
  }
  return results;
}

}  // namespace ovoid::io

#endif
