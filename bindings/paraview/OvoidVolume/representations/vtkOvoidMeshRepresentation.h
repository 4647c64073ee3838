// SPDX-License-Identifier: Apache-2.0
/**
 * @class   vtkOvoidMeshRepresentation
 * @brief   unstructured grids as volumes that Ovoid draws
 *
 * ParaView's own representation of unstructured volumes with another mapper: of cells of any kind,
 * which are not cut into tetrahedra, and lit.
 */
#pragma once

#include "vtkOvoidRepresentationsModule.h"
#include "vtkUnstructuredGridVolumeRepresentation.h"

class VTKOVOIDREPRESENTATIONS_EXPORT vtkOvoidMeshRepresentation
    : public vtkUnstructuredGridVolumeRepresentation {
 public:
  static vtkOvoidMeshRepresentation* New();
  // clang-format off
  vtkTypeMacro(vtkOvoidMeshRepresentation, vtkUnstructuredGridVolumeRepresentation)
      // clang-format on
      void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * There is one mapper: the name is not read.
   */
  void SetActiveVolumeMapper(const char* name) override;

  /**
   * Light, as of images' volumes.
   */
  void SetShade(bool shade);

 protected:
  vtkOvoidMeshRepresentation();
  ~vtkOvoidMeshRepresentation() override;

  void UpdateMapperParameters() override;

 private:
  vtkOvoidMeshRepresentation(const vtkOvoidMeshRepresentation&) = delete;
  void operator=(const vtkOvoidMeshRepresentation&) = delete;
};
