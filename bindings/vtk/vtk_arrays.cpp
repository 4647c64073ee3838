// SPDX-License-Identifier: Apache-2.0
#include "vtk_arrays.h"

#include <fmt/format.h>
#include <vtkAbstractMapper.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkPointData.h>
#include <vtkPointSet.h>
#include <vtkSmartPointer.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "ovoid/error.h"
#include "ovoid/model.h"

namespace ovoid::mappers {
namespace {

template <typename T>
constexpr ScalarType integer_type() {
  if constexpr (sizeof(T) == 1) return std::is_signed_v<T> ? ScalarType::kInt8 : ScalarType::kUInt8;
  if constexpr (sizeof(T) == 2)
    return std::is_signed_v<T> ? ScalarType::kInt16 : ScalarType::kUInt16;
  if constexpr (sizeof(T) == 4)
    return std::is_signed_v<T> ? ScalarType::kInt32 : ScalarType::kUInt32;
  return std::is_signed_v<T> ? ScalarType::kInt64 : ScalarType::kUInt64;
}

std::string array_names(vtkFieldData* fields) {
  std::string names;
  for (int i = 0; i < fields->GetNumberOfArrays(); ++i) {
    const char* const name = fields->GetArrayName(i);
    names += (names.empty() ? "" : ", ") + std::string(name != nullptr ? name : "(unnamed)");
  }
  return names.empty() ? "none" : names;
}

std::string name_of_array(vtkDataArray* array) {
  return array->GetName() != nullptr ? array->GetName() : "(unnamed)";
}

[[noreturn]] void throw_no_array(vtkDataSet* data, const ArrayChoice& choice) {
  const bool is_chosen = choice.scalar_mode == VTK_SCALAR_MODE_USE_POINT_FIELD_DATA ||
                         choice.scalar_mode == VTK_SCALAR_MODE_USE_CELL_FIELD_DATA;
  std::string what = "no scalars are active: expected some, or SelectScalarArray";
  if (is_chosen && choice.access_mode == VTK_GET_ARRAY_BY_NAME) {
    what =
        fmt::format("array '{}': not there", choice.array_name != nullptr ? choice.array_name : "");
  } else if (is_chosen) {
    what = fmt::format("array {}: not there", choice.array_id);
  }
  throw Error(ErrorCode::kInvalidArgument,
              fmt::format("{}: {}; arrays of points: {}; of cells: {}", data->GetClassName(), what,
                          array_names(data->GetPointData()), array_names(data->GetCellData())));
}

// Of two colour and opacity, of four red, green, blue and opacity.
std::vector<DrawnComponent> dependent_components(vtkDataArray* array, bool takes_several) {
  const int count = array->GetNumberOfComponents();
  if (!takes_several || (count != 2 && count != 4)) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("array '{}': {} dependent components: two or four of an image or even "
                            "rectilinear grid are drawn (IndependentComponentsOn, SetVectorMode)",
                            name_of_array(array), count));
  }
  std::vector<DrawnComponent> chosen{{count - 1, 0, 1}};
  for (int i = 0; i + 1 < count; ++i) chosen.push_back({i, 0, 1});
  return chosen;
}

// The components that the property gives weight.
std::vector<DrawnComponent> weighted_components(vtkDataArray* array, bool takes_several,
                                                vtkVolumeProperty* property) {
  const int count = array->GetNumberOfComponents();
  const std::string name = name_of_array(array);
  std::vector<DrawnComponent> chosen;
  for (int i = 0; i < std::min(count, VTK_MAX_VRCOMP); ++i) {
    const double weight = property->GetComponentWeight(i);
    if (weight > 0) chosen.push_back({i, i, weight});
  }
  if (chosen.size() > 1 && !takes_several) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("array '{}': {} independent components with a weight: one is drawn "
                            "(SetComponentWeight 0 of the others, SetVectorMode)",
                            name, chosen.size()));
  }
  if (chosen.size() > 1 && count > VTK_MAX_VRCOMP) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("array '{}': {} independent components: at most {} are drawn at once "
                            "(SetComponentWeight 0 of all but one, SetVectorMode)",
                            name, count, VTK_MAX_VRCOMP));
  }
  if (chosen.empty()) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("array '{}': no component has a weight > 0", name));
  }
  return chosen;
}

}  // namespace

std::optional<ScalarType> scalar_type_of(int vtk_type) {
  switch (vtk_type) {
    case VTK_CHAR:
      return integer_type<char>();
    case VTK_SIGNED_CHAR:
      return ScalarType::kInt8;
    case VTK_UNSIGNED_CHAR:
      return ScalarType::kUInt8;
    case VTK_SHORT:
      return integer_type<short>();
    case VTK_UNSIGNED_SHORT:
      return integer_type<unsigned short>();
    case VTK_INT:
      return integer_type<int>();
    case VTK_UNSIGNED_INT:
      return integer_type<unsigned int>();
    case VTK_LONG:
      return integer_type<long>();
    case VTK_UNSIGNED_LONG:
      return integer_type<unsigned long>();
    case VTK_LONG_LONG:
      return integer_type<long long>();
    case VTK_UNSIGNED_LONG_LONG:
      return integer_type<unsigned long long>();
    case VTK_ID_TYPE:
      return integer_type<vtkIdType>();
    case VTK_FLOAT:
      return ScalarType::kFloat32;
    case VTK_DOUBLE:
      return ScalarType::kFloat64;
    default:
      return std::nullopt;
  }
}

DataArray shared_array(vtkDataArray* array, bool is_cell_data) {
  const std::optional<ScalarType> type = scalar_type_of(array->GetDataType());
  if (!type) {
    throw Error(ErrorCode::kUnsupported,
                fmt::format("array '{}': holds {}: expected numbers", name_of_array(array),
                            array->GetDataTypeAsString()));
  }
  vtkSmartPointer<vtkDataArray> plain = array;
  if (!array->HasStandardMemoryLayout()) {
    plain =
        vtkSmartPointer<vtkDataArray>::Take(vtkDataArray::CreateDataArray(array->GetDataType()));
    plain->DeepCopy(array);
  }
  DataArray shared;
  shared.name = name_of_array(array);
  shared.type = *type;
  shared.num_components = array->GetNumberOfComponents();
  shared.num_tuples = array->GetNumberOfTuples();
  shared.is_cell_data = is_cell_data;
  const std::size_t num_bytes =
      static_cast<std::size_t>(array->GetNumberOfValues()) * size_of(*type);
  shared.bytes = {std::make_shared<vtkSmartPointer<vtkDataArray>>(plain),
                  {static_cast<const std::byte*>(plain->GetVoidPointer(0)), num_bytes}};
  return shared;
}

DrawnValues drawn_values(vtkDataSet* data, const ArrayChoice& choice, vtkVolumeProperty* property) {
  int flag = 0;
  DrawnValues drawn;
  drawn.array = vtkAbstractMapper::GetScalars(data, choice.scalar_mode, choice.access_mode,
                                              choice.array_id, choice.array_name, flag);
  const bool may_lack_values =
      choice.scalar_mode == VTK_SCALAR_MODE_DEFAULT && vtkPointSet::SafeDownCast(data) != nullptr;
  if (drawn.array == nullptr && may_lack_values) return drawn;
  if (drawn.array == nullptr) throw_no_array(data, choice);
  // 2: of field data, which is points' or cells' by the mode.
  drawn.is_cell_data =
      flag == 1 || (flag == 2 && choice.scalar_mode == VTK_SCALAR_MODE_USE_CELL_FIELD_DATA);
  const vtkIdType expected =
      drawn.is_cell_data ? data->GetNumberOfCells() : data->GetNumberOfPoints();
  const std::string name = name_of_array(drawn.array);
  if (drawn.array->GetNumberOfTuples() != expected) {
    throw Error(ErrorCode::kInvalidArgument,
                fmt::format("array '{}': {} tuples: expected {}, one for each {}", name,
                            drawn.array->GetNumberOfTuples(), expected,
                            drawn.is_cell_data ? "cell" : "point"));
  }
  const int count = drawn.array->GetNumberOfComponents();
  if (count == 1) return drawn;  // a number's sign is no direction
  if (choice.vector_mode == 0) {
    drawn.components.front().component = LatticeModelOptions::kMagnitude;
  } else if (choice.vector_mode == 1) {
    if (choice.vector_component >= count) {
      throw Error(ErrorCode::kInvalidArgument,
                  fmt::format("VectorComponent = {}: array '{}' has {} components",
                              choice.vector_component, name, count));
    }
    drawn.components.front().component = choice.vector_component;
  } else if (property->GetIndependentComponents() == 0) {
    drawn.are_dependent = true;
    drawn.components = dependent_components(drawn.array, choice.takes_several);
  } else {
    drawn.components = weighted_components(drawn.array, choice.takes_several, property);
  }
  return drawn;
}

}  // namespace ovoid::mappers
