// SPDX-License-Identifier: Apache-2.0
// VTK's arrays as the library's, and which of a data set's arrays a mapper draws.
#pragma once

#include <optional>
#include <vector>

#include "ovoid/dataset.h"

class vtkDataArray;
class vtkDataSet;
class vtkVolumeProperty;

namespace ovoid::mappers {

// None for types that hold no numbers.
std::optional<ScalarType> scalar_type_of(int vtk_type);

// The array's values, where they lie; an array in no standard layout (VTK's of structures or of
// formulas) is copied into one. The result keeps the VTK array alive. Throws Error(kUnsupported)
// for an array that holds no numbers.
DataArray shared_array(vtkDataArray* array, bool is_cell_data);

// What vtkAbstractVolumeMapper says of scalars, and the mappers' VectorMode and VectorComponent.
struct ArrayChoice {
  int scalar_mode = 0;
  int access_mode = 0;
  int array_id = 0;
  const char* array_name = nullptr;
  int vector_mode = -1;
  int vector_component = 0;
  bool takes_several = false;  // components at once
};

struct DrawnComponent {
  int component = 0;       // of the tuples; LatticeModelOptions::kMagnitude: their length
  int property_index = 0;  // of the component whose functions of a vtkVolumeProperty count
  double weight = 1;       // in (0, 1], of its opacities
};

struct DrawnValues {
  vtkDataArray* array = nullptr;  // null: none is active, and the places alone are drawn
  bool is_cell_data = false;
  std::vector<DrawnComponent> components{DrawnComponent{}};  // one; of takes_several, up to four
  // The first of `components`, the tuples' last, is what is drawn, and the others are its colours:
  // a value, or red, green and blue.
  bool are_dependent = false;
};

// No array for vtkPointSets whose mapper asks for the usual scalars and that have none: particles
// may be drawn without. Throws Error: kInvalidArgument that names the arrays where none is active
// or the chosen one is not there, or a component that the tuples do not have; kUnsupported for
// several at once where the choice does not take them, or of tuples of more than the four that a
// vtkVolumeProperty knows, and for dependent ones of tuples of other than two or four.
DrawnValues drawn_values(vtkDataSet* data, const ArrayChoice& choice, vtkVolumeProperty* property);

}  // namespace ovoid::mappers
