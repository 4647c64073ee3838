// SPDX-License-Identifier: Apache-2.0
/**
 * @class   vtkOvoidGridRepresentation
 * @brief   images and rectilinear grids as volumes that Ovoid draws
 *
 * ParaView's own representation of volumes with another mapper: its properties, transfer functions
 * and parallel pictures are those of "Volume".
 */
#pragma once

#include "vtkImageVolumeRepresentation.h"
#include "vtkOvoidRepresentationsModule.h"

class VTKOVOIDREPRESENTATIONS_EXPORT vtkOvoidGridRepresentation
    : public vtkImageVolumeRepresentation {
 public:
  static vtkOvoidGridRepresentation* New();
  // clang-format off
  vtkTypeMacro(vtkOvoidGridRepresentation, vtkImageVolumeRepresentation)
      // clang-format on
      void PrintSelf(ostream& os, vtkIndent indent) override;

  /**
   * What stands at every sample: vtkOvoidVolumeMapper::KernelType.
   */
  void SetKernel(int kernel);

 protected:
  vtkOvoidGridRepresentation();
  ~vtkOvoidGridRepresentation() override;

  void UpdateMapperParameters() override;

 private:
  vtkOvoidGridRepresentation(const vtkOvoidGridRepresentation&) = delete;
  void operator=(const vtkOvoidGridRepresentation&) = delete;
};
